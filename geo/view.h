// What selection needs to know of a view, whoever's it is: the camera's or a light's.
#pragma once

#include "geo/bounds.h"
#include "geo/camera.h"

#include <vector>

namespace gnomon {

struct View {
    std::vector<Plane> planes; // a volume outside any of them is not seen
    Point<Ecef> eye;           // where distance is measured from (perspective)
    Vector<Ecef> forward;      // unit view axis, for load priority

    // Perspective: pixels per metre at distance 1 m, H / (2 tan(fovy / 2)). Orthographic: 0.
    double pixelsPerRadian = 0.0;
    // Orthographic: the size of a pixel (a shadow map's texel) in metres.
    double pixelMetres = 0.0;
    // Orthographic: a metre farther against `forward` than `growthFromMetres` before `eye`, a pixel
    // counts as so much larger: what casts from afar casts blurred.
    double pixelGrowth = 0.0;
    double growthFromMetres = 0.0;
    double weight = 1.0; // multiplies the view's screen-space error; light views may ask for less
};

// The four side planes; near and far are left out, so that what is behind a near plane streams too.
View perspectiveView(const Camera& camera);

// Pixels that an error of `geometricErrorMetres` inside `volume` may show in `view`. Infinite when
// the eye is inside the volume.
double screenSpaceError(const View& view, const BoundingVolume& volume,
                        double geometricErrorMetres);

} // namespace gnomon
