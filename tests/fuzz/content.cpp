// One tile's content in any of its wrappings (b3dm, i3dm, cmpt, pnts, glb, gltf): headers, tables
// and what they hold.
// words: streaming/content.cpp streaming/tile_headers.cpp streaming/i3dm.cpp streaming/pnts.cpp
// words: streaming/batch_table.cpp streaming/feature_table.cpp
#include "tests/fuzz/content_promises.h"

namespace gnomon::fuzz {

void fuzzOne(Span bytes) {
    fuzzContent(bytes, bytes, UpAxis::Y);
}

} // namespace gnomon::fuzz
