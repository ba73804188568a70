// tinygltf, compiled by us (tinygltf.cpp) under a name of our own. Debian's libdraco.so exports an
// older tinygltf with another layout, so in a program that links both, the order of the link line
// decides which of the two a call ends in. Compiled without file access and image loading, it
// cannot open anything either. For .cpp files only.
#pragma once

#define TINYGLTF_NO_STB_IMAGE
#define TINYGLTF_NO_STB_IMAGE_WRITE
#define TINYGLTF_NO_EXTERNAL_IMAGE
#define TINYGLTF_NO_FS
#define TINYGLTF_NO_INCLUDE_JSON
#include <nlohmann/json.hpp>

#define tinygltf gnomon_tinygltf
#include <tiny_gltf.h>
#undef tinygltf
