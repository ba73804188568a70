// The GLSL files of this folder, compiled into the program.
#pragma once

#include <string_view>

namespace gnomon {

// The text of "sun.frag" and the like; empty when there is no such file.
std::string_view shaderSource(std::string_view name);

} // namespace gnomon
