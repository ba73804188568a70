#version 450 core
// Triangles of a lamp's map, already projected and cut (shadows/lamp_casters.h).
layout(location = 0) in vec3 corner; // clip x, y, w

void main() { gl_Position = vec4(corner.xy, 0.5 * corner.z, corner.z); }
