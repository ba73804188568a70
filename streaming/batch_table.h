// The batch table of b3dm, i3dm and pnts (3D Tiles 1.0): JSON whose members are columns, an array
// of one value a feature or a reference into the binary part beside it.
#pragma once

#include "streaming/feature_table.h"

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

namespace gnomon {

class ByteBudget; // streaming/soup.h

// Where a batchLength is from: the file's word, or the highest row that something is of, behind
// which the table may have more.
enum class BatchRows { Told, UsedAtLeast };

// Never throws for what the bytes say: a column that is wrong is left out and named in `warnings`,
// and so is a table nothing can be read of, for the mesh is worth showing without. A file that says
// it has features but nothing of them still gives a table, of rows without properties. Null when
// batchLength is 0. What is kept is taken from `budget`; where that does not allow a column, it is
// left out like one that is wrong.
std::shared_ptr<const FeatureTable>
readBatchTable(std::span<const std::byte> json, std::span<const std::byte> binary,
               std::uint32_t batchLength, std::vector<std::string>& warnings, ByteBudget& budget,
               BatchRows rowsAre = BatchRows::Told);
// With a budget of its own, of a gigabyte.
std::shared_ptr<const FeatureTable> readBatchTable(std::span<const std::byte> json,
                                                   std::span<const std::byte> binary,
                                                   std::uint32_t batchLength,
                                                   std::vector<std::string>& warnings);

} // namespace gnomon
