// A camera path in KML.
// words: viewer/kml_playlist.cpp viewer/kml_tour.cpp
#include "tests/fuzz/path_promises.h"

namespace gnomon::fuzz {

void fuzzOne(Span bytes) {
    std::string text(textOf(bytes));
    if (text.find('<') == std::string::npos)
        return;
    const auto path = CameraPath::parse(text, "flight.kml", 45.0, 1.5);
    if (!path) {
        demandReadable(path.error());
        return;
    }
    checkPath(*path);
    for (const std::string& note : path->notes())
        demandReadable(note);
    checkPath(
        path->onGround([](double longitude, double latitude) { return longitude - latitude; }));
}

} // namespace gnomon::fuzz
