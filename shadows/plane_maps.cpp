#include "shadows/plane_maps.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gnomon {

namespace {

// A penumbra is wider than this only close to the eye; beyond it, its outer part is taken to be
// like the map's rim.
constexpr int kWidestMarginTexels = 64;

int marginTexels(const ShadowSettings& settings) {
    switch (settings.filter) {
    case ShadowFilter::None:
        return 1;
    case ShadowFilter::Pcss:
    case ShadowFilter::PcssRatio:
        return kWidestMarginTexels;
    default:
        return int(std::ceil(filterRadiusTexels(settings))) + 1;
    }
}

// What the picture's receivers ask of a map: their texels and how deep they lie.
struct Receivers {
    int left = std::numeric_limits<int>::max(), bottom = left;
    int right = std::numeric_limits<int>::min(), top = right;
    double minW = std::numeric_limits<double>::infinity(), lowest = minW, highest = -minW;
    bool any() const { return right >= left; }
};

double at(const glm::dvec4& row, const glm::dvec3& p) {
    return glm::dot(row, glm::dvec4(p, 1.0));
}

// Of the pixels that no earlier map took. `map` spans the whole picture.
Receivers receiversOf(const PlaneMapsInput& in, const ProjectiveMap& map,
                      std::vector<bool>& taken) {
    const Camera& eye = in.seen.camera;
    const glm::dvec3 shift =
        glm::transpose(in.seen.meshAxes) * (eye.position - in.camera.position).xyz;
    const SurfaceReader read(in.seen);
    Receivers out;
    for (int y = 0; y < eye.heightPixels; ++y)
        for (int x = 0; x < eye.widthPixels; ++x) {
            const std::size_t i = std::size_t(y) * std::size_t(eye.widthPixels) + std::size_t(x);
            if (taken[i] || read.sky(x, y))
                continue;
            const glm::dvec3 p = read.position(x, y) + shift;
            // Most pixels are far off the plane: the cheap question first.
            const double allowed =
                2.0 * (map.plane.toleranceMetres + map.plane.tolerancePerW * read.viewDepth(x, y));
            if (std::abs(map.plane.distance(p)) > allowed ||
                glm::dot(p, p) > in.rangeMetres * in.rangeMetres ||
                !answersFor(map, p, read.normal(x, y)))
                continue;
            taken[i] = true;
            const glm::dvec3 texel = texelOf(map, p);
            out.left = std::min(out.left, int(texel.x));
            out.right = std::max(out.right, int(texel.x));
            out.bottom = std::min(out.bottom, int(texel.y));
            out.top = std::max(out.top, int(texel.y));
            out.minW = std::min(out.minW, texel.z);
            const double depth = at(map.depth, p);
            out.lowest = std::min(out.lowest, depth);
            out.highest = std::max(out.highest, depth + std::max(at(in.reach, p), 0.0));
        }
    return out;
}

} // namespace

std::vector<ProjectiveMap> planeOptimalMaps(const PlaneMapsInput& in,
                                            const ShadowSettings& settings) {
    const glm::dvec4 sun(in.towardsSun, 0.0);
    const glm::dvec3 shift =
        glm::transpose(in.seen.meshAxes) * (in.seen.camera.position - in.camera.position).xyz;
    const int margin = marginTexels(settings);
    std::vector<bool> taken(in.seen.pixels(), false);
    std::vector<ProjectiveMap> maps;
    for (FoundPlane& found : findPlanes(in.seen, in.towardsSun, settings.planes)) {
        found.plane.offsetMetres -= glm::dot(found.plane.normal, shift);
        const PixelRect all{0, 0, in.camera.widthPixels, in.camera.heightPixels};
        const auto whole = planeOptimalMap(in.camera, in.seen.meshAxes, sun, found.plane, all);
        if (!whole)
            continue;
        const Receivers seen = receiversOf(in, *whole, taken);
        if (!seen.any())
            continue;
        const PixelRect rect{seen.left - margin, seen.bottom - margin,
                             seen.right - seen.left + 1 + 2 * margin,
                             seen.top - seen.bottom + 1 + 2 * margin};
        auto map = planeOptimalMap(in.camera, in.seen.meshAxes, sun, found.plane, rect);
        constexpr double kBelowMetres = 1e-3; // the lowest receiver stays above 0
        setDepthRange(*map, 0.5 * seen.minW, seen.lowest - kBelowMetres, seen.highest);
        maps.push_back(*map);
    }
    return maps;
}

} // namespace gnomon
