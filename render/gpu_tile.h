// A decoded tile on the GPU. Positions stand in a buffer of their own, so that depth passes read
// twelve bytes a vertex.
#pragma once

#include "render/handles.h"
#include "streaming/mesh.h"

#include <cstdint>
#include <vector>

namespace gnomon::render {

// What is drawn at once: one material, one origin.
struct GpuMesh {
    Point<Ecef> origin;
    OrientedBox box;
    std::uint32_t firstIndex = 0;
    std::uint32_t closedIndices = 0; // of closed components, first
    std::uint32_t openIndices = 0;   // after them
    std::uint32_t skirtIndices = 0;  // last; for the eye only
    std::int32_t baseVertex = 0;
    std::uint32_t material = 0;
};

struct GpuMaterial {
    Material look;
    int texture = -1; // into GpuTile::textures()
};

class GpuTile {
  public:
    // All at once; in parts see gpu_tile_upload.h. `warnings` gets a line for each texture that had
    // to be scaled down.
    GpuTile(const TileContent& content, std::vector<std::string>& warnings);
    // What bytes() will be of this content; more where a texture has to be scaled down.
    static std::size_t bytesOf(const TileContent& content);

    const std::vector<GpuMesh>& meshes() const { return meshes_; }
    const GpuMaterial& material(const GpuMesh& mesh) const { return materials_[mesh.material]; }
    void bindTextures(const GpuMaterial& material) const;
    const VertexArray& vertices() const { return vertices_; }           // all attributes
    const VertexArray& positionsOnly() const { return positionsOnly_; } // for opaque depth
    const Texture& faceNormals() const { return faceNormals_; }
    std::size_t bytes() const { return bytes_; }

  private:
    friend class GpuTileUpload;
    GpuTile() = default;

    std::vector<GpuMesh> meshes_;
    std::vector<GpuMaterial> materials_;
    std::vector<Texture> textures_;
    Buffer positions_, attributes_, indices_, faceNormalBuffer_;
    Texture faceNormals_;
    VertexArray vertices_, positionsOnly_;
    std::size_t bytes_ = 0;
};

// A mesh to draw, and the number that stands for its tile in pictures; 0 for the ground, which is
// in no tile.
struct DrawItem {
    const GpuTile* tile = nullptr;
    const GpuMesh* mesh = nullptr;
    std::uint32_t tileId = 0;
};

} // namespace gnomon::render
