// The water of a layer at a moment, on the GPU.
#pragma once

#include "render/handles.h"
#include "streaming/flood/water_surface.h"

#include <cstdint>
#include <span>
#include <vector>

namespace gnomon::render {

struct GpuWaterMesh {
    Point<Ecef> origin;
    OrientedBox box;
    std::uint32_t firstIndex = 0, indices = 0;
    std::int32_t baseVertex = 0;
};

class GpuWater {
  public:
    explicit GpuWater(std::span<const WaterMesh> meshes);

    const std::vector<GpuWaterMesh>& meshes() const { return meshes_; }
    const VertexArray& vertices() const { return vertices_; }
    const Texture& faceNormals() const { return faceNormals_; } // oct, one a triangle
    std::size_t bytes() const { return bytes_; }

  private:
    std::vector<GpuWaterMesh> meshes_;
    Buffer surface_, normals_, indices_, faceNormalBuffer_;
    Texture faceNormals_;
    VertexArray vertices_;
    std::size_t bytes_ = 0;
};

} // namespace gnomon::render
