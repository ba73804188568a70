// What the filters of all shadow maps share: what 2×2 texels say of a receiver, and what they weigh.

// Where the texels of textureGather stand from the quad's corner.
const vec4 GATHER_X = vec4(0.5, 1.5, 1.5, 0.5);
const vec4 GATHER_Y = vec4(1.5, 1.5, 0.5, 0.5);

// Turns by the golden angle, 137.5°: the next arm of the spiral that samples a disc (Vogel, 1979).
const mat2 GOLDEN_TURN = mat2(-0.737368878, 0.675490294, -0.675490294, -0.737368878);

// Two lit faces that meet in a hollow, as a wall and the ground before it, must not shade each other.
// Across such an edge a face rises over the receiver's plane by (tan a + tan b) for each unit sideways,
// a and b the angles between the light and the two normals. A texel that stands no higher than that says
// nothing: it may be the neighbouring face or a blocker that touches; tan b is taken as this (63°).
// Where its 2×2 quad is a plane, that plane tells too: continued to the receiver, the neighbouring face
// passes below it and a blocker above.
const float NEIGHBOUR_SLOPE = 2.0;

// Which of four texels are blockers for sure: the quad's plane passes above the receiver, or the texel's
// `gap` over the receiver's plane is more than its neighbouring face may have. dx and dy
// are from the receiver, `gradient` its plane's, `before` what stands before it.
bvec4 standsClear(bvec4 before, vec4 depth, vec4 gap, vec4 neighbour, vec2 gradient, vec4 dx, vec4 dy,
                  float tolerance, float leastDoubt) {
    vec2 tilt = 0.5 * vec2(depth.y - depth.x + depth.z - depth.w, depth.x - depth.w + depth.y - depth.z) -
                gradient;
    // A quad across the edge may look like a plane too, but part of it is the receiver's own face.
    bool planar = all(before) && abs(depth.x - depth.y + depth.z - depth.w) < 4.0 * tolerance;
    // The quad's slope carries the map's rounding as far as the receiver is off; besides, the callers say
    // a fiftieth of a texel for what rounding was not thought of.
    float doubt = 2.0 * tolerance * (abs(dx.x) + abs(dy.x)) + leastDoubt;
    bool above = planar && gap.x - tilt.x * dx.x - tilt.y * dy.x > doubt;
    bvec4 clear = greaterThan(gap, neighbour);
    return above ? bvec4(true) : clear;
}

vec4 lit(vec4 gap) { return vec4(lessThanEqual(gap, vec4(0.0))); }

// Of what was said. Where nothing is, a blocker touches: in a hollow the receiver's own face speaks.
float share(float litSum, float total) { return total > 0.0 ? litSum / total : 0.0; }

// How much of each texel, x and y its centre, a box covers, of what it says.
vec4 boxWeights(vec4 says, vec4 x, vec4 y, vec2 low, vec2 high) {
    vec4 wx = clamp(min(x + 0.5, high.x) - max(x - 0.5, low.x), 0.0, 1.0);
    vec4 wy = clamp(min(y + 0.5, high.y) - max(y - 0.5, low.y), 0.0, 1.0);
    return says * wx * wy;
}
