// From the bytes of one tile (b3dm, glb, gltf) to meshes. Bytes are hostile until proven otherwise:
// every length, offset, count and index is checked, and what is wrong comes back as an error.
#pragma once

#include "streaming/mesh.h"
#include "streaming/source.h"

#include <functional>
#include <optional>
#include <span>

namespace gnomon {

enum class UpAxis { X, Y, Z };

struct DecodeOptions {
    Transform<Ecef, Tile> ecefFromTile; // all transforms above the content, placement included
    UpAxis gltfUpAxis = UpAxis::Y;
    // The axes meshes are stored and cut along: orthonormal columns in ECEF. A scene gives those of
    // its anchor, so that its floats are the same wherever on Earth it stands. Without: stored
    // along ECEF's, cut along east, north, up.
    std::optional<glm::dmat3> meshAxes;
    // Reads a file the content refers to by a relative uri (an external buffer or image).
    std::function<Result<Bytes>(const std::string& uri)> readUri;
    std::size_t maxBytes = std::size_t(1) << 30; // decoded
};

// `name` is for messages only. The format is known by the first bytes.
Result<TileContent> decodeContent(std::span<const std::byte> bytes, const std::string& name,
                                  const DecodeOptions& options);

} // namespace gnomon
