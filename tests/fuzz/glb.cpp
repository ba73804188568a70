// A glTF or GLB, up to the finished meshes. What it refers to outside is its own bytes.
// words: streaming/gltf*.cpp streaming/accessor.cpp streaming/meshopt*.cpp
#include "tests/fuzz/content_promises.h"

namespace gnomon::fuzz {

void fuzzOne(Span bytes) {
    const bool glb = textOf(bytes).starts_with("glTF");
    const bool gltf =
        textOf(bytes).find_first_not_of(" \t\r\n\xef\xbb\xbf") == textOf(bytes).find_first_of('{');
    if (glb || gltf)
        fuzzContent(bytes, bytes, glb ? UpAxis::Y : UpAxis::Z);
}

} // namespace gnomon::fuzz
