// Tiles that are made where others are read: terrain cut from a raster, houses put up from their
// footprints. A tree of them streams, is culled and casts like any tileset.
#pragma once

#include "streaming/content.h"
#include "streaming/tileset.h"

#include <memory>
#include <string>
#include <vector>

namespace gnomon {

class ContentMaker {
  public:
    virtual ~ContentMaker() = default;
    // The content of the tile whose node has this path, on the Earth already, stored along
    // `options.meshAxes`. Called from several threads at once; the same path gives the same bytes.
    virtual Result<TileContent> make(const std::string& path,
                                     const DecodeOptions& options) const = 0;
    // What lies below a tile of the kind ExternalTileset: a tree of its own, its root first. Where
    // trees are small enough to be told at once nobody asks.
    virtual Result<std::vector<MadeTile>> below(const std::string& path) const;
    // As the user would write it, for messages.
    virtual std::string describe(const std::string& path) const = 0;
};

struct MadeTileset {
    std::vector<MadeTile> tiles; // see TileTree::ofTiles
    std::shared_ptr<const ContentMaker> maker;
};

} // namespace gnomon
