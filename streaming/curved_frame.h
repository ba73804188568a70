// A frame that no single affine map puts on the Earth well enough: that of a map projection. The
// ground falls off a tangent plane by d² / 2R, 2 m in 5 km, and a projection's scale changes. Each
// tile gets the map that touches the frame in its own middle, so what is left is its own size's.
#pragma once

#include "geo/bounds.h"
#include "geo/result.h"

#include <memory>

namespace gnomon {

class CurvedFrame {
  public:
    virtual ~CurvedFrame() = default;
    // Both may be called from several threads at once.
    virtual Result<Point<Ecef>> place(const glm::dvec3& at) const = 0;
    virtual Result<Transform<Ecef, Tile>> near(const glm::dvec3& at) const = 0;
};

// Where a tileset's own frame is: by one map, or by those that touch `curved`. A single model
// stands by `frame` in either case.
struct TilePlacement {
    TilePlacement(const Transform<Ecef, Tile>& map = {}) : frame(map) {}
    Transform<Ecef, Tile> frame;
    std::shared_ptr<const CurvedFrame> curved = {};
};

// `flat` is in the curved frame's coordinates, whatever its type says; `near` touches them in its
// middle. Grown by as much as the map is off at its corners. A region is left as it is.
BoundingVolume curvedVolume(const CurvedFrame& frame, const Transform<Ecef, Tile>& near,
                            const BoundingVolume& flat);
// The middle of such a volume.
glm::dvec3 middleOf(const BoundingVolume& flat);

} // namespace gnomon
