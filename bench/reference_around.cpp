// What happens to the light on the surfaces around a point.
//
// Points are taken on rings in the plane normal to the light and put on the surface in the
// direction of the light. Walking there along the point's own plane, one of two things is met.
// Nothing: then the surface is where a ray from the light comes down, if it does so near the plane;
// beyond a roof's edge it does not. Or something that stands on the surface: then the surface there
// is that thing's face, as far as the point sees it. What lies behind it, or under it, is not
// around the point.
#include "bench/reference_state.h"
#include "shadows/light_basis.h"

#include <numbers>
#include <optional>

namespace gnomon::bench {

namespace {

constexpr int kRings = 3, kDirections = 12;
constexpr int kContactDirections = 24;
constexpr int kRimRays = 8;
// Walks are this much of the radius above the surface, over what no map of that texel can show.
constexpr double kWalkHeight = 1.0 / 32.0;
// A surface that falls or rises away from the point's plane no farther than this, in lengths of the
// walk along the light, still counts as the one around it: twice what a fall of 45° takes.
constexpr double kNearPlane = 2.0;
// Below this the light is as good as along the surface, and walks would never end.
constexpr double kLeastFacing = 1e-3;

enum class Share { Dark, Between, Lit };

struct Place {
    glm::dvec3 position{0.0}, normal{0.0};
};

// The light's centre and its rim.
const std::vector<glm::vec2>& rim() {
    static const std::vector<glm::vec2> points = [] {
        std::vector<glm::vec2> out{glm::vec2(0.0f)};
        for (int i = 0; i < kRimRays; ++i) {
            const double a = 2.0 * std::numbers::pi * i / kRimRays;
            out.emplace_back(float(std::cos(a)), float(std::sin(a)));
        }
        return out;
    }();
    return points;
}

} // namespace

struct Around {
    const RayScene& scene;
    const RayScene::State& state;
    const Light& light;
    const bool soft;
    const Place centre;
    const double radius;
    const Incoming incoming;
    const double facing, height;
    const glm::dmat3 axes;

    Around(const RayScene& rays, const RayScene::State& with, const Place& place, const Light& from,
           bool disc, double metres)
        : scene(rays), state(with), light(from), soft(disc), centre(place), radius(metres),
          incoming(incomingAt(place.position, from)),
          facing(std::max(glm::dot(place.normal, incoming.towards), kLeastFacing)),
          height(kWalkHeight * metres), axes(lightAxes(incoming.towards)) {}

    Share share(const Place& at) const {
        const Incoming here = incomingAt(at.position, light);
        const double value = soft && here.tangent > 0.0
                                 ? state.disc(at.position, at.normal, here, rim())
                                 : state.centre(at.position, at.normal, here);
        return value == 0.0 ? Share::Dark : value == 1.0 ? Share::Lit : Share::Between;
    }
    // From the centre to a place on its plane that is `distance` away in the light's.
    glm::dvec3 walk(double distance, double angle) const {
        const glm::dvec3 across =
            distance * (std::cos(angle) * axes[0] + std::sin(angle) * axes[1]);
        return across - (glm::dot(across, centre.normal) / facing) * incoming.towards;
    }
    glm::dvec3 raised() const { return centre.position + height * centre.normal; }
    bool free(const glm::dvec3& way) const {
        return !state.rays->any({raised(), way, centre.normal, 0.0, 1.0});
    }
    std::optional<Place> surfaceAt(const glm::dvec3& way) const {
        const double reach = kNearPlane * glm::length(way);
        const glm::dvec3 above = raised() + way;
        if (free(way)) {
            const RayHit hit = scene.first(above, -incoming.towards, reach + height / facing);
            return hit.any ? std::optional<Place>({hit.position, hit.normal}) : std::nullopt;
        }
        const RayHit hit = scene.first(above + reach * incoming.towards, -incoming.towards, reach);
        if (!hit.any || !free(hit.position + height * hit.normal - raised()))
            return {};
        return Place{hit.position, hit.normal};
    }
    // Whether any surface around answers yes.
    template <class Asked>
    bool any(const Asked& asked) const {
        for (int ring = kRings; ring >= 1; --ring)
            for (int i = 0; i < kDirections; ++i) {
                const double angle = (i + 0.5 * ring) * 2.0 * std::numbers::pi / kDirections;
                const auto place = surfaceAt(walk(radius * ring / kRings, angle));
                if (place && asked(*place))
                    return true;
            }
        return false;
    }
};

bool RayScene::changesWithin(const glm::dvec3& point, const glm::dvec3& normal, const Light& light,
                             bool soft, double radiusMetres) const {
    const Around around(*this, *state_, {point, normal}, light, soft, radiusMetres);
    if (!around.incoming.reaches(normal))
        return false; // dark by its own doing, as all of its plane
    const Share here = around.share(around.centre);
    return around.any([&](const Place& p) { return around.share(p) != here; });
}

bool RayScene::shadowWithin(const glm::dvec3& point, const glm::dvec3& normal, const Light& light,
                            bool soft, double radiusMetres) const {
    const Around around(*this, *state_, {point, normal}, light, soft, radiusMetres);
    const auto shadowed = [&](const Place& p) { return around.share(p) != Share::Lit; };
    return shadowed(around.centre) || around.any(shadowed);
}

bool RayScene::contactWithin(const glm::dvec3& point, const glm::dvec3& normal, const Light& light,
                             double radiusMetres) const {
    const Around around(*this, *state_, {point, normal}, light, false, radiusMetres);
    for (int i = 0; i < kContactDirections; ++i)
        if (!around.free(
                around.walk(radiusMetres, 2.0 * std::numbers::pi * i / kContactDirections)))
            return true;
    return false;
}

} // namespace gnomon::bench
