// The property tables of EXT_structural_metadata: columns of raw bytes that a schema explains.
// 3D Tiles 1.1 has the same tables for its own metadata. After "3D Metadata Specification" 1.0.
#pragma once

#include "streaming/feature_table.h"
#include "streaming/source.h"

#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace gnomon {

class Warnings;   // streaming/gltf_parts.h
class ByteBudget; // streaming/soup.h

// What tables are read with: the bytes of a buffer view and of a file named by a relative uri.
struct PropertyTableReader {
    std::function<Result<std::span<const std::byte>>(std::uint64_t bufferView)> view;
    std::function<Result<Bytes>(const std::string& uri)> file; // for schemaUri; may be null
};

// One entry a table, in the file's order; null where a table cannot be read. `extension` is the
// JSON of the extension. What is wrong with a column leaves that column out; `warnings` names it.
std::vector<std::shared_ptr<const FeatureTable>>
readPropertyTables(std::string_view extension, const PropertyTableReader& reader,
                   Warnings& warnings, ByteBudget& budget);

} // namespace gnomon
