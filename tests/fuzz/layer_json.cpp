// A quantized mesh's layer.json.
// words: streaming/terrain/layer_json.cpp
#include "tests/fuzz/fuzz.h"

#include "streaming/terrain/layer_json.h"

#include <nlohmann/json.hpp>

namespace gnomon::fuzz {

void fuzzOne(Span bytes) {
    const auto layer = parseLayerJson(bytes, "layer.json");
    if (!layer) {
        demandReadable(layer.error());
        return;
    }
    demand(!layer->templates.empty(), "its tiles have names");
    demand(layer->available.size() <= 32, "levels there can be");
    for (const TileRanges& ranges : layer->available)
        for (const TileRange& range : ranges)
            demand(range.startX <= range.endX && range.startY <= range.endY, "ranges go upwards");
    demand(layer->metadataLevels <= 32, "levels there can be");
    demand(isPlainLine(layer->attribution), "a credit is one line");
    demand(layer->uriOf(3, 4, 5) == layer->uriOf(3, 4, 5), "a tile has one name");
    for (const std::string& warning : layer->warnings)
        demandReadable(warning);
}

} // namespace gnomon::fuzz
