// The planes that fill most of a picture's sunlit part, found in what the camera sees: its depth
// and its surfaces' normals. The same picture gives the same planes.
#pragma once

#include "shadows/projective.h"

#include <cstdint>
#include <span>
#include <vector>

namespace gnomon {

// What the visibility pass read back, rows top to bottom: metres along the view axis (infinite: the
// sky); four octahedral numbers a pixel, of which the first two are the geometric normal.
struct SeenSurfaces {
    Camera camera;
    glm::dmat3 meshAxes{1.0};
    std::span<const float> viewDepth;
    std::span<const std::uint16_t> normals;

    std::size_t pixels() const {
        return std::size_t(camera.widthPixels) * std::size_t(camera.heightPixels);
    }
};

// Positions and normals of pixels, camera-relative, along the meshes' axes.
class SurfaceReader {
  public:
    explicit SurfaceReader(const SeenSurfaces& seen);
    bool sky(int x, int y) const { return !(viewDepth(x, y) < 1e30); }
    double viewDepth(int x, int y) const;
    glm::dvec3 position(int x, int y) const; // y counts rows from the top
    glm::dvec3 normal(int x, int y) const;

  private:
    SeenSurfaces seen_;
    glm::dvec3 right_, up_, forward_;
    std::size_t index(int x, int y) const {
        return std::size_t(y) * std::size_t(seen_.camera.widthPixels) + std::size_t(x);
    }
};

struct FoundPlane {
    ReceiverPlane plane;
    double share = 0.0; // of the picture's pixels, about
};

// At most `count`, the one with most pixels first. A point that stands off a plane belongs to it as
// long as its shadow map sees it less than half a pixel beside where the eye does: millimetres at
// the eye's feet, and the round Earth for kilometres. Planes that hold less than a hundredth of the
// picture are not worth a map.
std::vector<FoundPlane> findPlanes(const SeenSurfaces& seen, const glm::dvec3& towardsSun,
                                   int count);

} // namespace gnomon
