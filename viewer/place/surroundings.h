// What lies round the place and happens to it: terrain as a GeoTIFF, hills all round three times as
// wide as the place; a flood that rises over six hours; a barrier that appears after three.
//
// Rasters are in the ellipsoidal orthographic projection at `at` (EPSG method 9840), whose east and
// north are those of the place's own frame; heights are what brings each pixel to the frame's
// plane.
#pragma once

#include "geo/ellipsoid.h"
#include "geo/result.h"
#include "viewer/place/plan.h"

#include <nlohmann/json.hpp>

#include <string>

namespace gnomon::builtin {

// Metres above the plane of the place's frame, in it and all round.
double surroundingHeight(const Plan& plan, glm::dvec2 p);
// The flood's level there so many hours after it began to rise, in the same metres.
double floodLevel(const Plan& plan, glm::dvec2 p, double hours);
inline constexpr int kFloodHours = 6;
inline constexpr int kBarrierHour = 3;

// `name` below the folder `path`; what is there is replaced.
Failure writeTerrain(const Plan& plan, const Geodetic& at, const std::string& path);
// A band an hour, from 0 to kFloodHours: the level where it is above the ground, else no data.
Failure writeFlood(const Plan& plan, const Geodetic& at, const std::string& path);

// The place's square, where its own tiles show the ground (GeoJSON).
nlohmann::json holeJson(const Plan& plan, const Geodetic& at);
// A wall along the river on the tower's side, on both sides of the bridge's road (GeoJSON).
nlohmann::json barriersJson(const Plan& plan, const Geodetic& at);

} // namespace gnomon::builtin
