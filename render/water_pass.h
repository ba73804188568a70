// The nearest water that the camera sees, in targets of its own beside the visibility pass's: the
// ground below stays, so that both get their own share of sun.
#pragma once

#include "geo/view.h"
#include "render/visibility_pass.h"
#include "render/water_mesh.h"
#include "streaming/color_map.h"

#include <cstdint>
#include <map>
#include <span>
#include <vector>

namespace gnomon::render {

// A layer's water, and how it is coloured.
struct WaterItem {
    const GpuWater* water = nullptr;
    bool natural = false; // not by a number
    bool bySpeed = false; // else by depth
    ColorMap map = ColorMap::Depth;
    double most = 1.0; // metres or m/s of the last colour
};

// Pixels from the lower left corner.
struct PixelRect {
    int x = 0, y = 0, width = 0, height = 0;
};

struct WaterPassInput {
    Camera camera; // the one that `seen` was drawn with
    glm::dmat3 meshAxes{1.0};
    std::span<const WaterItem> items;
    // Drawn ground is coarser than the ground that the water's depth was reckoned from, by so many
    // metres at most, a value a tile number: as far as that it hides no water.
    std::span<const float> groundErrors;
};

class WaterPass {
  public:
    WaterPass();
    // What stands nearer in `seen` hides it; nothing is drawn where the depth is 0 or less. Returns
    // how many triangles that were.
    std::uint64_t draw(const VisibilityPass& seen, const WaterPassInput& input);
    // That there is none: costs nothing.
    void clear() { bounds_ = {}; }

    bool any() const { return bounds_.width > 0; } // of a layer's boxes in view
    const PixelRect& bounds() const { return bounds_; }
    int width() const { return width_; }
    int height() const { return height_; }
    const Texture& depth() const { return depth_; } // as VisibilityPass's; 0 where there is none
    const Texture& normals() const { return normals_; } // likewise
    const Texture& color() const { return color_; }     // sRGB8; a: 0 at the shore … 1
    const Texture& value() const { return value_; }     // R32F: metres of water; below 0: natural
    const Buffer& viewBlock() const { return *viewBlock_; }

    // As VisibilityPass's; +inf and 0 where there is none. Rows top to bottom.
    std::vector<float> readViewDepth() const;
    std::vector<std::uint16_t> readNormals() const;

  private:
    void resize(int width, int height);
    void setGroundErrors(std::span<const float> errors);
    const Texture& colors(ColorMap map);
    std::uint64_t drawItem(const WaterItem& item, const WaterPassInput& input, const View& view);

    Program program_;
    Texture depth_, normals_, color_, value_;
    Framebuffer target_;
    std::map<ColorMap, Texture> colors_;
    std::vector<float> errors_;
    Buffer errorBuffer_;
    Texture errorTexture_;
    const Buffer* viewBlock_ = nullptr;
    PixelRect bounds_;
    int width_ = 0, height_ = 0;
};

} // namespace gnomon::render
