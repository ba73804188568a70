#include "shadows/projective.h"

#include "shadows/light_basis.h"

#include <glm/common.hpp>

#include <array>
#include <cmath>
#include <limits>

namespace gnomon {

namespace {

constexpr double kUlp = 1.0 / (1 << 24);

double at(const glm::dvec4& row, const glm::dvec3& p) {
    return glm::dot(row, glm::dvec4(p, 1.0));
}

// Turns -1…1 over `from` pixels into -1…1 over the part that starts at `first`, `count` pixels
// long.
glm::dvec4 restricted(const glm::dvec4& row, const glm::dvec4& w, int from, int first, int count) {
    return (double(from) * row + double(from - 2 * first - count) * w) / double(count);
}

// The corners of the part of the frustum between two view depths.
std::array<glm::dvec3, 8> sliceCorners(const PerspectiveInput& in) {
    const glm::dmat3 stored = glm::transpose(in.meshAxes);
    const glm::dvec3 right = stored * in.camera.right.xyz * in.camera.tanHalfWidth();
    const glm::dvec3 up = stored * in.camera.up.xyz * in.camera.tanHalfHeight();
    const glm::dvec3 forward = stored * in.camera.forward.xyz;
    std::array<glm::dvec3, 8> corners;
    for (std::size_t i = 0; i < 8; ++i)
        corners[i] =
            ((i & 4) != 0 ? in.farMetres : in.nearMetres) *
            (forward + ((i & 1) != 0 ? 1.0 : -1.0) * right + ((i & 2) != 0 ? 1.0 : -1.0) * up);
    return corners;
}

// The camera's rows of clip coordinates whose z runs from -w to w between the view depths of all
// that is seen and casts, from a place moved back along the view axis. In these the view is the
// cube from -1 to 1, about the origin.
std::array<glm::dvec4, 4> movedBackRows(const PerspectiveInput& in,
                                        const std::array<glm::dvec3, 8>& corners) {
    const CameraRows camera = cameraRows(in.camera, in.meshAxes);
    double nearest = in.nearMetres, farthest = in.farMetres;
    for (const glm::dvec3& p : corners) {
        const glm::dvec3 caster = p + std::max(at(in.reach, p), 0.0) * in.towardsSun;
        nearest = std::min(nearest, at(camera.w, caster));
        farthest = std::max(farthest, at(camera.w, caster));
    }
    const double back = in.nearMetres - nearest;
    const double n = in.nearMetres, f = farthest + back;
    const glm::dvec4 w = camera.w + glm::dvec4(0, 0, 0, back);
    const glm::dvec4 z = (f + n) / (f - n) * w - glm::dvec4(0, 0, 0, 2.0 * f * n / (f - n));
    return {camera.x, camera.y, z, w};
}

// Three rows over post-perspective coordinates that vanish where the sun is there, at `q`: two
// across the direction to it, and one that is positive in all the cube. The last is the distance
// from the plane through q that faces the cube's nearest point: the cube lies wholly on one side of
// it.
std::array<glm::dvec4, 3> rowsFacing(const glm::dvec4& q) {
    const glm::dvec3 towards = glm::normalize(glm::dvec3(q));
    const glm::dmat3 axes = lightAxes(towards);
    glm::dvec3 away = towards;
    // Beyond this distance in cubes the rays are parallel but for rounding.
    if (std::abs(q.w) > 1e-9 * glm::length(glm::dvec3(q))) {
        const glm::dvec3 place = glm::dvec3(q) / q.w;
        away = place - glm::clamp(place, glm::dvec3(-1.0), glm::dvec3(1.0));
        away = glm::normalize(away) * (q.w > 0.0 ? 1.0 : -1.0);
    }
    return {glm::dvec4(axes[0], 0.0), glm::dvec4(axes[1], 0.0),
            glm::dvec4(-q.w * away, glm::dot(away, glm::dvec3(q)))};
}

glm::dvec4 through(const glm::dvec4& row, const std::array<glm::dvec4, 4>& first) {
    return row.x * first[0] + row.y * first[1] + row.z * first[2] + row.w * first[3];
}

// Scales and shifts x and y so that all points lie between -limit and limit; false where one of
// them has no w.
bool fitTo(ProjectiveMap& map, const std::array<glm::dvec3, 8>& points, double limit) {
    glm::dvec2 low(std::numeric_limits<double>::infinity()), high(-low);
    for (const glm::dvec3& p : points) {
        const double w = at(map.w, p);
        if (!(w > 0.0))
            return false;
        const glm::dvec2 seen(at(map.x, p) / w, at(map.y, p) / w);
        low = glm::min(low, seen);
        high = glm::max(high, seen);
    }
    const glm::dvec2 scale = 2.0 * limit / (high - low), centre = 0.5 * (low + high);
    map.x = scale.x * (map.x - centre.x * map.w);
    map.y = scale.y * (map.y - centre.y * map.w);
    return std::isfinite(scale.x) && std::isfinite(scale.y);
}

} // namespace

CameraRows cameraRows(const Camera& camera, const glm::dmat3& meshAxes) {
    const glm::dmat3 stored = glm::transpose(meshAxes);
    return {glm::dvec4(stored * camera.right.xyz / camera.tanHalfWidth(), 0.0),
            glm::dvec4(stored * camera.up.xyz / camera.tanHalfHeight(), 0.0),
            glm::dvec4(stored * camera.forward.xyz, 0.0)};
}

glm::dvec3 texelOf(const ProjectiveMap& map, const glm::dvec3& p) {
    const double w = at(map.w, p);
    return {(0.5 * at(map.x, p) / w + 0.5) * map.width, (0.5 * at(map.y, p) / w + 0.5) * map.height,
            w};
}

bool answersFor(const ProjectiveMap& map, const glm::dvec3& p, const glm::dvec3& normal) {
    const glm::dvec3 texel = texelOf(map, p);
    if (texel.z < map.minW || texel.x < 0.0 || texel.x >= map.width || texel.y < 0.0 ||
        texel.y >= map.height)
        return false;
    if (map.minW > 0.0 && at(map.depth, p) < 0.0) // its range is set
        return false;
    if (map.plane.normal == glm::dvec3(0.0))
        return true;
    return glm::dot(normal, map.plane.normal) >= kSamePlaneCosine &&
           std::abs(map.plane.distance(p)) <=
               map.plane.toleranceMetres + map.plane.tolerancePerW * texel.z;
}

double texelMetres(const ProjectiveMap& map, const glm::dvec3& towardsSun, const glm::dvec3& p) {
    const double w = at(map.w, p), u = at(map.x, p) / w, v = at(map.y, p) / w;
    const glm::dmat3 axes = lightAxes(towardsSun);
    const glm::dvec3 du = 0.5 * map.width / w * (glm::dvec3(map.x) - u * glm::dvec3(map.w));
    const glm::dvec3 dv = 0.5 * map.height / w * (glm::dvec3(map.y) - v * glm::dvec3(map.w));
    const glm::dvec2 a(glm::dot(du, axes[0]), glm::dot(du, axes[1]));
    const glm::dvec2 b(glm::dot(dv, axes[0]), glm::dot(dv, axes[1]));
    // One over the smaller singular value of the Jacobian, texels a metre.
    const double sum = glm::dot(a, a) + glm::dot(b, b);
    const double determinant = std::abs(a.x * b.y - a.y * b.x);
    const double larger = std::sqrt(
        0.5 * (sum + std::sqrt(std::max(sum * sum - 4.0 * determinant * determinant, 0.0))));
    return larger / determinant;
}

std::optional<ProjectiveMap> planeOptimalMap(const Camera& camera, const glm::dmat3& meshAxes,
                                             const glm::dvec4& light, const ReceiverPlane& plane,
                                             const PixelRect& rect) {
    const glm::dvec4 pi(plane.normal, plane.offsetMetres);
    // Sine between light and plane; for a lamp, as the eye sees it.
    const double facing = glm::dot(pi, light);
    const double lightLength = glm::length(glm::dvec3(light));
    constexpr double kEdgeOnMetres = 1e-3; // the eye in the plane sees nothing of it
    const bool sun = light.w == 0.0;
    if (!(facing > (sun ? kMinPlaneFacing * lightLength : kEdgeOnMetres)) ||
        !(std::abs(plane.offsetMetres) > kEdgeOnMetres) || rect.width <= 0 || rect.height <= 0)
        return {};
    ProjectiveMap map;
    map.width = rect.width;
    map.height = rect.height;
    map.plane = plane;
    const CameraRows rows = cameraRows(camera, meshAxes);
    // A row times S. The sign is right as it is: on the plane w is the camera's own, and it keeps
    // its sign along every light ray up to the light.
    const auto moved = [&](const glm::dvec4& row) {
        return row - glm::dot(row, light) / facing * pi;
    };
    map.w = moved(rows.w);
    map.x = restricted(moved(rows.x), map.w, camera.widthPixels, rect.x, rect.width);
    map.y = restricted(moved(rows.y), map.w, camera.heightPixels, rect.y, rect.height);
    map.depth = sun ? pi / facing : pi; // metres along the ray; above the plane for a lamp
    return map;
}

void setDepthRange(ProjectiveMap& map, double minW, double lowestMetres, double highestMetres) {
    map.minW = minW;
    map.depth.w -= lowestMetres;
    map.depthScale = minW / std::max(highestMetres - lowestMetres, 1e-3);
    // Interpolation rounds by the largest value of the triangle it runs over: of a receiver, no
    // more than stored at the nearest of the highest receivers. A plane's stand at its tolerance.
    const double receiver = map.plane.normal == glm::dvec3(0.0)
                                ? 1.0
                                : 2.0 * std::abs(lowestMetres) / minW * map.depthScale;
    map.storedRounding = 8.0 * kUlp * receiver;
}

ProjectiveMap seenFrom(const ProjectiveMap& map, const glm::dvec3& shift) {
    ProjectiveMap out = map;
    for (glm::dvec4* row : {&out.x, &out.y, &out.w, &out.depth})
        row->w = at(*row, shift);
    out.plane.offsetMetres = map.plane.distance(shift);
    return out;
}

std::optional<ProjectiveMap> perspectiveMap(const PerspectiveInput& in) {
    const std::array<glm::dvec3, 8> corners = sliceCorners(in);
    const std::array<glm::dvec4, 4> eye = movedBackRows(in, corners);
    const glm::dvec4 sun(in.towardsSun, 0.0);
    const std::array<glm::dvec4, 3> light =
        rowsFacing({glm::dot(eye[0], sun), glm::dot(eye[1], sun), glm::dot(eye[2], sun),
                    glm::dot(eye[3], sun)});
    ProjectiveMap map;
    map.width = map.height = in.mapSize;
    map.x = through(light[0], eye);
    map.y = through(light[1], eye);
    map.w = through(light[2], eye);
    constexpr double kBorderTexels = 2.0; // for the filter's reach
    if (!fitTo(map, corners, 1.0 - 2.0 * kBorderTexels / in.mapSize))
        return {};
    map.depth = sun;
    double minW = std::numeric_limits<double>::infinity(), lowest = minW, highest = -minW;
    for (const glm::dvec3& p : corners) {
        minW = std::min(minW, at(map.w, p));
        lowest = std::min(lowest, at(map.depth, p));
        highest = std::max(highest, at(map.depth, p) + std::max(at(in.reach, p), 0.0));
    }
    // Receivers at the very rim of the slice keep a finite depth and stay above 0.
    setDepthRange(map, 0.5 * minW, lowest - 0.01 * (highest - lowest), highest);
    return map;
}

} // namespace gnomon
