#include "render/gpu_tile.h"

#include "render/gpu_tile_upload.h"
#include "shaders/interface.h"

#include <limits>

namespace gnomon::render {

GpuTile::GpuTile(const TileContent& content, std::vector<std::string>& warnings) {
    // Not owned: the content outlives this call.
    GpuTileUpload upload(std::shared_ptr<const TileContent>(std::shared_ptr<void>(), &content));
    while (!upload.step(std::numeric_limits<std::size_t>::max()))
        ;
    *this = upload.take(warnings);
}

std::size_t GpuTile::bytesOf(const TileContent& content) {
    return GpuTileUpload::bytesOf(content);
}

void GpuTile::bindTextures(const GpuMaterial& material) const {
    if (material.texture >= 0)
        bindTexture(TEX_BASE_COLOR, textures_[std::size_t(material.texture)]);
}

} // namespace gnomon::render
