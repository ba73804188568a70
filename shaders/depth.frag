#version 450 core
#include "interface.h"
#include "depth_layers.glsl"

void main() { keepLayer(); }
