// The batch table of a pnts whose columns are in the Draco buffer, put together as it would be
// without compression.
#pragma once

#include "streaming/draco.h"
#include "streaming/source.h"
#include "streaming/tile_headers.h"

#include <map>
#include <string>

namespace gnomon {

// Columns by name, and the unique ids of their attributes. Empty when nothing is compressed; throws
// BadContent for what is malformed.
std::map<std::string, std::uint32_t> dracoColumns(const TileParts& parts, ByteBudget& budget);

struct PlainBatchTable {
    Bytes json, binary;
};
// `columns` have as many values as there are points.
PlainBatchTable plainBatchTable(const TileParts& parts,
                                const std::map<std::string, const DracoAttribute*>& columns,
                                ByteBudget& budget);

} // namespace gnomon
