// What bytes are, by what is in them: behind viewer/input.h.
#pragma once

#include "streaming/source.h"
#include "viewer/input.h"

namespace gnomon {

struct FoundKind {
    InputKind kind = InputKind::Tileset;
    std::optional<WaterKind> waterKind = {};
    std::string guess = {};
};

// `uri` is the file's name in messages.
Result<FoundKind> kindOfFile(const std::string& path, const std::string& uri);
// Of a whole document from the web: a tileset, a model or a quantized mesh. `path` is its address.
Result<InputKind> kindOfWebDocument(const Bytes& bytes, const std::string& path,
                                    const std::string& uri);
// The format tells it for sure.
bool isSure(InputKind kind);

} // namespace gnomon
