// How much of each texel polygons cover: exact areas, by the signed areas of their edges (as font
// rasterisers do; Levien, "Inside the fastest font renderer in the world", 2016).
#pragma once

#include <glm/vec2.hpp>
#include <glm/vec3.hpp>

#include <span>
#include <vector>

namespace gnomon {

// From the sphere to the texels of a tile, whose places are known: texel (column, row) has its
// centre at +0.5. In between, a plane that touches the sphere at the tile's middle (stereographic),
// where neither poles nor the antimeridian are special.
class TexelPlane {
  public:
    TexelPlane(std::span<const glm::dvec2> lonLat, int width);
    // The ring, cut off not far outside of the tile.
    std::vector<glm::dvec2> texels(std::span<const glm::dvec3> ringOnSphere) const;

  private:
    glm::dvec2 onPlane(const glm::dvec3& p) const;
    glm::dvec2 texel(glm::dvec2 plane, glm::dvec2 guess) const;

    glm::dvec3 east_{1, 0, 0}, north_{0, 1, 0}, up_{0, 0, 1};
    std::vector<int> columnsAt_, rowsAt_; // texels whose places are kept
    std::vector<glm::dvec2> nodes_;       // on the plane, row by row
    glm::dvec2 low_{0}, high_{0};         // of the nodes, and a margin
};

class Coverage {
  public:
    Coverage(int width, int height);
    // Counts up or down by the ring's sense; texels outside do no harm.
    void add(std::span<const glm::dvec2> ring);
    std::vector<float> shares() const; // 0…1, row by row

  private:
    void addEdge(glm::dvec2 a, glm::dvec2 b);
    int width_, height_;
    std::vector<float> steps_; // a row has width + 2: change of cover from one texel to the next
};

} // namespace gnomon
