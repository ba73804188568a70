// A camera path in JSON: whatever it says, every sample is a camera.
// words: viewer/camera_path.cpp
#include "tests/fuzz/path_promises.h"

namespace gnomon::fuzz {

void fuzzOne(Span bytes) {
    const auto path = CameraPath::parse(std::string(textOf(bytes)), "flight.json", 45.0);
    if (path)
        checkPath(*path);
    else
        demandReadable(path.error());
}

} // namespace gnomon::fuzz
