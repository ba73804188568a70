// A content on its way to the GPU, a part at a time, so that no frame is held up by a large one.
#pragma once

#include "render/gpu_tile.h"

#include <memory>
#include <string>
#include <vector>

namespace gnomon::render {

class GpuTileUpload {
  public:
    explicit GpuTileUpload(std::shared_ptr<const TileContent> content);

    // Uploads about so many bytes more; true when all is there. The mipmaps of a texture are one
    // part, whatever their size.
    bool step(std::size_t bytes);
    GpuTile take(std::vector<std::string>& warnings); // when all is there

    static std::size_t bytesOf(const TileContent& content);

  private:
    enum class Stream { Positions, Attributes, Indices, FaceNormals };
    static constexpr int kStreams = 4;

    void allocate();
    std::size_t uploadMesh(std::size_t bytes);
    std::size_t uploadTexture(std::size_t bytes);
    void makeTexture(const Material& look);

    std::shared_ptr<const TileContent> content_;
    std::vector<std::string> warnings_;
    GpuTile tile_;
    // Where it has come to.
    bool allocated_ = false;
    std::size_t mesh_ = 0, material_ = 0;
    int stream_ = 0;
    std::size_t element_ = 0;          // of the mesh's stream
    std::size_t uploaded_[kStreams]{}; // bytes of each buffer
    bool hasTexture_ = false;          // of this material
    Image fitted_;                     // its image, where it had to be scaled down
    int row_ = 0;
};

} // namespace gnomon::render
