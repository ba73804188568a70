// JSON as people's exporters write it: NaN, Infinity and numbers beyond double's range become null,
// which the reader then treats as a missing value.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>

namespace gnomon {

std::string_view asText(std::span<const std::byte> bytes);
std::string withoutNonFinite(std::string_view json);

enum class JsonKind { NotJson, Tileset, Gltf, Other };
// By the keys of the outermost object; reads no further than it must.
JsonKind sniffJson(std::span<const std::byte> bytes);

} // namespace gnomon
