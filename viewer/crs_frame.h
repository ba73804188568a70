// Tilesets whose own coordinates are those of a map projection (--crs), and what those that are in
// no frame of the Earth's may have been meant in.
#pragma once

#include "geo/crs.h"
#include "streaming/curved_frame.h"

#include <memory>
#include <string>
#include <vector>

namespace gnomon {

// East, north, up of the system; `raiseMetres` lifts what stands in it.
std::shared_ptr<const CurvedFrame> crsFrame(CrsToEcef crs, double raiseMetres);

// Systems in common use that have these east and north among their coordinates, the ones with the
// smallest area first, with where on the Earth that is: "EPSG:3946 (4.85, 45.76)". Empty: none.
std::vector<std::string> likelySystems(const glm::dvec2& eastNorth);

} // namespace gnomon
