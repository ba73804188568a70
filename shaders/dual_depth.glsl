// The depth between two layers that a dual map holds: behind the first by half the way to the second,
// but by no more than `most`. All are stored depths, 1 nearest the sun; a second of 0 is none.
// After Weiskopf and Ertl, "Shadow mapping based on dual depth layers", 2003.
layout(location = 6) uniform float most;

float dualDepth(float first, float second) {
    precise float depth = first - min(0.5 * (first - second), most);
    return depth;
}

float storedDepth() { return clamp(gl_FragCoord.z, 0.0, 1.0); } // as depth clamping will
