// The flat ground where no terrain is: the ellipsoid raised by a height, and how that height is
// found.
#pragma once

#include "streaming/mesh.h"
#include "viewer/scene.h"

#include <chrono>
#include <optional>

namespace gnomon {

// The ellipsoid raised by `heightMetres`, as rings about the anchor whose width grows with
// distance, round the whole Earth. A facet lies below the true surface by at most 0.4 % of its own
// width: 2 mm at 2 km. Closed: its faces look outward. Its meshes are stored along the anchor's
// axes.
TileContent makeGround(const Scene& scene, double heightMetres);

// The height on which the inputs' buildings stand: three quarters of their lowest points, in the
// content nearest the anchor, lie below it. None when the content brings ground of its own
// (terrain), which shows in its upward area covering most of its footprint, or when there is no
// content at all. With `allMustCome`, content that has not come by the deadline is an error; else
// what is there has to do.
Result<std::optional<double>>
findGroundHeight(Scene& scene, std::chrono::steady_clock::time_point deadline, bool allMustCome);

} // namespace gnomon
