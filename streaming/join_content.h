// Several contents as one: the parts of a cmpt, the contents of a tile that has more than one.
#pragma once

#include "streaming/mesh.h"

#include <string>
#include <vector>

namespace gnomon {

// Meshes keep their order, their materials, images and features; features of different parts stay
// different, whatever numbers they had. `format` is what the whole is called.
TileContent joinContents(std::vector<TileContent> parts, const std::string& format);

} // namespace gnomon
