// Levels of water observed at points (CSV, GeoJSON), and the surface between them.
//
// Between the points the level is the sum of a constant and, for each point, a share of the
// distance to it (kriging with a linear variogram): exact at the points; along a line of points
// straight from one to the next and level beyond the last; without the overshoot of smoother
// surfaces. A stream observed along its course falls as it does between its gauges.
//
// Water is where that level is above the ground, and from where one can come to a point that stands
// in water without leaving it: hollows apart from it stay dry. Farther from all points than
// neighbouring points are from each other nothing is shown: nobody has looked there.
#pragma once

#include "streaming/flood/flood.h"

namespace gnomon {

// By the name's ending and, for CSV, a header of column names.
bool isPointFlood(const std::string& path);
// The result says nothing of where water is until FloodData::on has made it out for a ground.
Result<std::shared_ptr<const FloodData>> openPointFlood(const std::string& path,
                                                        const FloodOptions& options);

} // namespace gnomon
