#include "geo/view.h"

#include <algorithm>
#include <limits>

namespace gnomon {
namespace {

// Nearer than this an error fills the picture anyway; it keeps the quotient finite.
constexpr double kNearestMetres = 1e-7;

} // namespace

View perspectiveView(const Camera& camera) {
    const double tanX = camera.tanHalfWidth();
    const double tanY = camera.tanHalfHeight();
    View view;
    for (const Vector<Ecef>& inward :
         {tanX * camera.forward - camera.right, tanX * camera.forward + camera.right,
          tanY * camera.forward - camera.up, tanY * camera.forward + camera.up})
        view.planes.push_back({normalize(inward), camera.position});
    view.eye = camera.position;
    view.forward = camera.forward;
    view.pixelsPerRadian = std::max(camera.heightPixels, 1) / (2.0 * tanY);
    return view;
}

double screenSpaceError(const View& view, const BoundingVolume& volume,
                        double geometricErrorMetres) {
    // Written so that NaN ends here too.
    if (!(geometricErrorMetres > 0.0) || !(view.weight > 0.0))
        return 0.0;
    if (view.pixelsPerRadian <= 0.0) {
        const double before =
            view.pixelGrowth > 0.0
                ? extentAlong(volume, view.eye, -view.forward).min - view.growthFromMetres
                : 0.0;
        return view.weight * geometricErrorMetres /
               (view.pixelMetres + view.pixelGrowth * std::max(before, 0.0));
    }
    const double distance = distanceTo(volume, view.eye);
    if (!(distance > 0.0))
        return std::numeric_limits<double>::infinity();
    return view.weight * geometricErrorMetres * view.pixelsPerRadian /
           std::max(distance, kNearestMetres);
}

} // namespace gnomon
