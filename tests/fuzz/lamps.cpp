// Lamps in GeoJSON.
// words: viewer/lamps_file.cpp
#include "tests/fuzz/fuzz.h"

#include "viewer/lamps_file.h"

namespace gnomon::fuzz {

void fuzzOne(Span bytes) {
    const auto lamps = parseLampsFile(std::string(textOf(bytes)), "lamps.geojson");
    if (!lamps) {
        demandReadable(lamps.error());
        return;
    }
    for (const LampsFile::Entry& entry : lamps->entries) {
        demand(std::isfinite(entry.foot.longitudeDegrees) &&
                   std::abs(entry.foot.latitudeDegrees) <= 90.0 &&
                   std::isfinite(entry.foot.heightMetres) && std::isfinite(entry.heightMetres),
               "a lamp stands on the Earth");
        const Lamp lamp = placedLamp(entry, 40.0);
        demand(isFinite(lamp.position.xyz), "a lamp is somewhere");
    }
    for (const Error& error : lamps->leftOut)
        demandReadable(error);
    for (const std::string& note : lamps->notes)
        demandReadable(note);
}

} // namespace gnomon::fuzz
