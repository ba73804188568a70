// Lamps as people have them: GeoJSON points (RFC 7946), or points of any file and coordinate
// reference system that streaming/features/features.h reads.
//
//   [lon, lat] or [lon, lat, metres above the ellipsoid]
//   "height"  metres above that place: of the lantern over its foot. 6 where the point has no
//   height
//             of its own (its foot is then on the scene's level), else 0.
//   "facing"  "down" (default) or "all" round
//   "power"   light on a surface facing it 1 m away, as a number or [r, g, b]; 100
//   "range"   metres at which it has faded out; 50
#pragma once

#include "geo/ellipsoid.h"
#include "geo/result.h"
#include "shadows/lamp.h"
#include "streaming/features/features.h"

#include <cstddef>
#include <string>
#include <vector>

namespace gnomon {

struct LampsFile {
    struct Entry {
        Geodetic foot;
        bool onLevel = true; // the foot's height was not given
        double heightMetres = 6.0;
        bool allRound = false;
        Lamp lamp; // but for position and facing
    };
    std::vector<Entry> entries;
    std::size_t others = 0;         // features that are no points
    std::vector<std::string> notes; // what was taken for granted, and when not all can be lit
    std::vector<Error> leftOut;     // a line for each that cannot be used
    std::string crs;                // the file's, or the one given
};

Result<LampsFile> readLampsFile(const std::string& path, const FeatureOptions& options = {});
// GeoJSON in degrees. One line tells the first thing wrong and the feature it is in.
Result<LampsFile> parseLampsFile(const std::string& text, const std::string& name);
// Of features that are read already; `name` stands for their file in messages.
LampsFile lampsOf(const FeatureFile& features, const std::string& name);

// Feet without a height of their own stand `levelMetres` above the ellipsoid.
Lamp placedLamp(const LampsFile::Entry& entry, double levelMetres);

} // namespace gnomon
