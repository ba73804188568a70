#version 450 core
// What one lamp gives to the surfaces seen, added up lamp by lamp in a target of its own; and for those
// who measure, its shadow alone. After Brabec, Annen & Seidel, 2002.
//
// No bias: each texel's own ray is cut with the receiver's plane, and what the map holds on that ray is
// compared with the distance there (as shaders/sun.frag does along the sun's parallel rays).
#include "interface.h"
#include "surface.glsl"
#include "lamp.glsl"
#include "shadow_texels.glsl"

layout(binding = TEX_DEPTH) uniform sampler2D depthTexture;
layout(binding = TEX_NORMALS) uniform sampler2D normalTexture;
layout(binding = TEX_LAMP_MAPS) uniform sampler2DArray lampMaps;

in vec2 ndc;
layout(location = 0) out vec4 outLight;
layout(location = 1) out vec2 outVisibility; // 0…1, -1 sky; metres across the texel it is from, 0 none

// Sine of the height over the rim below which a lamp that lights a half space fades: about 5°.
const float RIM = 0.09;

struct Receiver {
    vec3 direction; // from the lamp
    float distance;
    vec3 normal;
    vec2 texel;
    int map;
    float tolerance, toleranceSlope; // metres; metres a metre sideways
    float texelMetres;
};

// What the 2×2 texels from `corner` on say: how far before the receiver's plane each stands, 0 where it
// does not block; `says` is 0 for one that could as well be the face next to the receiver's own.
vec4 gaps(Receiver r, vec2 corner, out vec4 dx, out vec4 dy, out vec4 says) {
    float size = lampReach.z;
    vec2 base = clamp(corner, vec2(0.0), vec2(size - 2.0));
    float layer = lampLayers[r.map >> 2][r.map & 3];
    vec4 stored = textureGather(lampMaps, vec3((base + 1.0) / size, layer));
    vec4 distance = lampReach.x + stored * (lampReach.y - lampReach.x);
    dx = base.x + GATHER_X - r.texel.x;
    dy = base.y + GATHER_Y - r.texel.y;
    vec3 v0 = lampDirection(base + vec2(0.5, 1.5), r.map, size);
    vec3 v1 = lampDirection(base + vec2(1.5, 1.5), r.map, size);
    vec3 v2 = lampDirection(base + vec2(1.5, 0.5), r.map, size);
    vec3 v3 = lampDirection(base + vec2(0.5, 0.5), r.map, size);
    float offPlane = r.distance * dot(r.normal, r.direction); // both negative
    vec4 towards = vec4(dot(r.normal, v0), dot(r.normal, v1), dot(r.normal, v2), dot(r.normal, v3));
    // Beyond the plane's horizon a ray never meets it.
    vec4 expected = mix(vec4(2.0 * lampReach.y), offPlane / towards, lessThan(towards * 2.0 * lampReach.y, vec4(offPlane)));
    vec4 gap = mix(expected - distance - r.tolerance, vec4(-1.0), greaterThanEqual(stored, vec4(1.0)));
    bvec4 before = greaterThan(gap, vec4(0.0));
    // An edge in the map may be off by its bend; so may the place of what a texel beside it holds.
    vec4 sideways = (sqrt(dx * dx + dy * dy) + lampLayers[1].z) * r.texelMetres;
    // A quad that is all one plane tells by that plane: does it pass before the receiver?
    vec3 p0 = distance.x * v0, edge1 = distance.y * v1 - p0, edge3 = distance.w * v3 - p0;
    vec3 across = cross(edge1, edge3);
    float area = length(across);
    bool planar = all(before) && abs(dot(across, distance.z * v2 - p0)) < 4.0 * r.tolerance * area;
    float at = dot(across, p0), along = dot(across, r.direction);
    float doubt = 2.0 * r.tolerance * (abs(dx.x) + abs(dy.x)) + 0.02 * r.texelMetres;
    bool above = planar && at * along > 0.0 && abs(at) < (r.distance - doubt) * abs(along);
    bvec4 clear = planar ? bvec4(above) : greaterThan(gap, r.toleranceSlope * sideways);
    says = vec4(not(before)) + vec4(clear);
    return mix(vec4(0.0), gap, clear);
}

// A box of full width `width` texels with exact coverage at its rim; width 1 is bilinear. -1 where no texel
// says anything.
float boxFilter(Receiver r, vec2 centre, float width) {
    vec2 low = centre - 0.5 * width, high = centre + 0.5 * width;
    vec2 first = floor(low);
    int quads = int(ceil((width + 1.0) * 0.5));
    float sum = 0.0, total = 0.0;
    for (int j = 0; j < quads; ++j)
        for (int i = 0; i < quads; ++i) {
            vec4 dx, dy, says;
            vec4 shade = lit(gaps(r, first + 2.0 * vec2(i, j), dx, dy, says));
            vec4 x = dx + r.texel.x, y = dy + r.texel.y;
            vec4 weight = boxWeights(says, x, y, low, high);
            sum += dot(shade, weight);
            total += dot(weight, vec4(1.0));
        }
    return total > 0.0 ? sum / total : -1.0;
}

vec3 inLamp(vec3 v) { return vec3(dot(lampX.xyz, v), dot(lampY.xyz, v), dot(lampZ.xyz, v)); }

void main() {
    float depth = texelFetch(depthTexture, ivec2(gl_FragCoord.xy), 0).r;
    outLight = vec4(0.0);
    outVisibility = vec2(-1.0, 0.0);
    if (depth <= 0.0)
        return;
    vec3 position = viewRay(ndc) * viewDepth(depth);
    vec4 oct = texelFetch(normalTexture, ivec2(gl_FragCoord.xy), 0) * 2.0 - 1.0;
    vec3 offset = inLamp(position) + vec3(lampX.w, lampY.w, lampZ.w);
    Receiver r;
    r.distance = length(offset);
    r.direction = offset / max(r.distance, 1e-6);
    r.normal = inLamp(decodeOct(oct.xy));
    float facing = -dot(r.normal, r.direction);
    bool lit = facing > 0.0 && r.distance < lampReach.y && (lampPower.w > 0.0 || r.direction.z > 0.0);
    r.texel = lampTexel(r.direction, lampReach.z, r.map);
    r.texelMetres = r.distance * lampTexelRadians(r.direction, lampReach.z);

    // Rounding, each by where it comes from: the position at this distance from the eye, off the plane by
    // that much; the map's floats of [0, 1]; a triangle's plane seen through its slope; and, a metre
    // sideways, the normal's 16 bits through the derivative of the slope.
    float slope = sqrt(max(1.0 - facing * facing, 0.0)) / max(facing, 1e-3);
    r.tolerance = (1e-6 * length(position) + 5e-7 * lampReach.y) * (1.0 + slope);
    r.toleranceSlope = NEIGHBOUR_SLOPE + slope + 6e-5 * (1.0 + slope * slope);

    // The nearest texel alone is a box of one on its centre; where that says nothing its neighbours are
    // asked. Where nobody does a blocker touches: in a hollow the receiver's own face speaks.
    float visibility = lit ? -1.0 : 0.0;
    float width = lampReach.w;
    vec2 centre = width > 0.0 ? r.texel : floor(r.texel) + 0.5;
    for (int round = 0; visibility < 0.0 && round < (width > 0.0 ? 1 : 2); ++round)
        visibility = boxFilter(r, round == 0 ? centre : r.texel, max(width, 1.0));
    visibility = max(visibility, 0.0);
    outVisibility = vec2(visibility, r.distance < lampReach.y ? r.texelMetres : 0.0);

    float share = r.distance / lampReach.y, window = max(1.0 - share * share * share * share, 0.0);
    float rim = lampPower.w > 0.0 ? 1.0 : smoothstep(0.0, RIM, r.direction.z);
    float fall = window * window / max(r.distance * r.distance, lampReach.x * lampReach.x);
    float lambert = max(-dot(inLamp(decodeOct(oct.zw)), r.direction), 0.0);
    outLight = vec4(lampPower.rgb * (visibility * rim * fall * lambert), 0.0);
}
