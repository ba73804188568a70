#include <fstream> // its writers, which we never call, need it even without file access

#define TINYGLTF_IMPLEMENTATION
#include "streaming/tinygltf.h"
