// The built-in place: a small city that needs no data, written as a standard 3D Tiles 1.1 tileset
// (implicit quadtree, glb with Draco) with a scene, street lamps and a flight beside it.
//
// It is authored in one flat frame, east, north, up in metres at `at`, and put on the Earth by the
// root's transform alone; bounding volumes are boxes. So it is rigid: the same place to the last
// bit at Cologne, at a pole and on the antimeridian. Terrain all round, a flood and a barrier come
// as rasters and GeoJSON (viewer/place/surroundings.h). The same options give the same bytes; of
// the tileset only tileset.json depends on `at`, of what lies beside it all does.
#pragma once

#include "geo/ellipsoid.h"
#include "geo/result.h"

#include <cstddef>
#include <cstdint>
#include <functional>
#include <string>

namespace gnomon {

inline constexpr std::size_t kSmallPlaceBuildings = 400;
inline constexpr std::size_t kCityPlaceBuildings = 20000;

struct PlaceOptions {
    std::string folder;                           // made if it is not there
    std::size_t buildings = kSmallPlaceBuildings; // exactly so many; at most 2,000,000
    Geodetic at{6.96, 50.94, 100.0};              // where the river's surface at the middle is
    std::uint64_t seed = 1;
};

struct PlaceFacts {
    std::size_t buildings = 0, trees = 0, sheds = 0; // at full detail
    std::size_t levels = 0;                          // of the quadtree
    std::size_t tiles = 0, subtrees = 0, files = 0;
    std::uint64_t triangles = 0; // at full detail, every tree counted
    std::uint64_t bytes = 0;     // of all files
    double sideMetres = 0;       // of the square
    double flightSeconds = 0;
};

// Streams tile by tile: memory does not grow with the place. `progress` (may be empty) is called
// with 0…1.
Result<PlaceFacts> writePlace(const PlaceOptions& options,
                              const std::function<void(double fraction)>& progress = {});

} // namespace gnomon
