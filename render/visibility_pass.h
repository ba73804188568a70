// The first pass over what the camera sees: nearest surface, its depth, normals, colour and tile.
// The passes after it shade each pixel once, whatever the scene's depth complexity.
#pragma once

#include "geo/camera.h"
#include "render/gpu_tile.h"
#include "render/handles.h"
#include "render/program.h"

#include <cstdint>
#include <span>
#include <vector>

namespace gnomon::render {

// Nearer surfaces are cut away. A reversed float depth loses nothing by a small value.
inline constexpr double kNearPlaneMetres = 0.1;

class VisibilityPass {
  public:
    VisibilityPass();
    // Draws the items that the camera sees; returns how many triangles that were. `axes`: those the
    // items' meshes are stored along (columns, in ECEF); the normals come out along them too.
    std::uint64_t draw(const Camera& camera, std::span<const DrawItem> items,
                       const glm::dmat3& axes);

    int width() const { return width_; }
    int height() const { return height_; }
    const Texture& depth() const { return depth_; }     // 32F, near / view depth, 0 sky
    const Texture& albedo() const { return albedo_; }   // sRGB8; a = 1 unlit
    const Texture& normals() const { return normals_; } // oct: geometric, shading
    const Texture& tiles() const { return tiles_; }     // R32UI
    const Buffer& viewBlock() const { return viewBlock_; }
    std::uint32_t draws() const { return draws_; }

    // Rows top to bottom. Metres along the view axis, +inf sky; four oct components in 0…65535
    // (geometric, shading); tile numbers, 0 none.
    std::vector<float> readViewDepth() const;
    std::vector<std::uint16_t> readNormals() const;
    std::vector<std::uint32_t> readTiles() const;

  private:
    void resize(int width, int height);

    Program program_;
    Buffer viewBlock_;
    Texture depth_, albedo_, normals_, tiles_;
    Framebuffer target_;
    int width_ = 0, height_ = 0;
    std::uint32_t draws_ = 0;
};

} // namespace gnomon::render
