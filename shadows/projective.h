// Shadow maps whose texels follow the eye's perspective instead of a lattice of their own.
//
// planeOptimalMap: the light's view that samples one plane exactly as the camera's pixels do, after
// Chong & Gortler, "A lixel for every pixel", 2004. Every point is first moved along its light ray
// on to the plane, then seen through the camera: M = C S with S = I - D πᵀ / (π·D), D the light and
// π the plane as 4-vectors. perspectiveMap: the light's view of the camera's post-perspective
// space, after Stamminger & Drettakis, "Perspective shadow maps", 2002, to compare with.
//
// Both are three rows that vanish on D, so that all points of one light ray fall on one texel and
// have one w there. Hence depth / w, with depth any affine measure along the ray, sorts the points
// of a ray as depth does, is linear across the map on every plane, and can be the depth that GL
// interpolates: what is stored is as good as metres, times w. No near or far plane is swept by a
// perspective.
//
// Positions are relative to the camera, along the meshes' axes, in double.
#pragma once

#include "geo/camera.h"

#include <glm/vec2.hpp>
#include <glm/vec4.hpp>

#include <optional>

namespace gnomon {

// Pixels counted as GL does, from the picture's lower left corner; may reach beyond the picture.
struct PixelRect {
    int x = 0, y = 0, width = 0, height = 0;
};

// Points p with dot(normal, p) + offset = 0; the normal is unit and on the eye's side.
struct ReceiverPlane {
    glm::dvec3 normal{0.0};
    double offsetMetres = 0.0;
    // A point this far off it still belongs to it: metres, and metres for each metre of w.
    double toleranceMetres = 0.0, tolerancePerW = 0.0;

    double distance(const glm::dvec3& p) const { return glm::dot(normal, p) + offsetMetres; }
};

struct ProjectiveMap {
    // Times (p, 1). x / w and y / w run from -1 to 1 over the map; w > 0 for what it is for.
    glm::dvec4 x{0.0}, y{0.0}, w{0.0};
    // Metres towards the light, above the lowest receiver.
    glm::dvec4 depth{0.0};
    double minW = 0.0;       // of the receivers; casters are cut there
    double depthScale = 1.0; // depth / w · this is at most 1 where casters stand
    int width = 0, height = 0;
    ReceiverPlane plane; // a zero normal: for any receiver
    // What rounding may do to the stored depth, besides rounding of positions.
    double storedRounding = 0.0;
};

// (x, y) in texels from the lower left corner, and w.
glm::dvec3 texelOf(const ProjectiveMap& map, const glm::dvec3& p);
// Whether the map answers for a receiver there: see shaders/projective.glsl.
bool answersFor(const ProjectiveMap& map, const glm::dvec3& p, const glm::dvec3& normal);
// How far across its texel is at p, in metres on the plane that a sun in direction `towardsSun` is
// normal to: the longer axis, since texels are as oblong as pixels on slanted ground.
double texelMetres(const ProjectiveMap& map, const glm::dvec3& towardsSun, const glm::dvec3& p);

// A receiver whose normal is off the plane's by more (8°) is some other surface near it.
inline constexpr double kSamePlaneCosine = 0.99;
// Below this sine between light and plane the rows, which hold 1 / sine, would make a float's last
// place matter: 6e-8 · 5 / 0.02 of half a picture's width of 640 is a hundredth of a pixel.
inline constexpr double kMinPlaneFacing = 0.02;

// The camera's rows x, y and w over stored, camera-relative positions.
struct CameraRows {
    glm::dvec4 x, y, w;
};
CameraRows cameraRows(const Camera& camera, const glm::dmat3& meshAxes);

// `light` is (direction towards the sun, 0) or (position, 1). The map's texels are the pixels of
// `rect`, so a point on the plane falls on the texel of the very pixel that sees it. Nothing when
// the plane is seen edge on, or lit so.
std::optional<ProjectiveMap> planeOptimalMap(const Camera& camera, const glm::dmat3& meshAxes,
                                             const glm::dvec4& light, const ReceiverPlane& plane,
                                             const PixelRect& rect);
// Fits stored depth: `minW` of the receivers, the lowest's `depth` by the map's row as it is, and
// the highest casters'.
void setDepthRange(ProjectiveMap& map, double minW, double lowestMetres, double highestMetres);
// For positions counted from another origin, which stands at `shift` in the map's own.
ProjectiveMap seenFrom(const ProjectiveMap& map, const glm::dvec3& shift);

struct PerspectiveInput {
    Camera camera;
    glm::dmat3 meshAxes{1.0};
    glm::dvec3 towardsSun{0, 0, 1};              // along the meshes' axes, unit
    double nearMetres = 1.0, farMetres = 1000.0; // view depths of the receivers
    glm::dvec4 reach{0.0}; // dot(reach, (p, 1)): metres along the sun ray to the highest caster
    int mapSize = 2048;
};
// The camera is moved back, as the paper does, until all that can cast into its view is in front.
// Nothing when the sun's rays and the view leave no such map.
std::optional<ProjectiveMap> perspectiveMap(const PerspectiveInput& input);

} // namespace gnomon
