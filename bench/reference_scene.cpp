#include "bench/reference_disc.h"
#include "bench/reference_state.h"
#include "shadows/light_basis.h"

#include <new>

namespace gnomon::bench {

RayScene::RayScene(std::unique_ptr<State> state) : state_(std::move(state)) {}
RayScene::~RayScene() = default;
RayScene::RayScene(RayScene&&) noexcept = default;

Result<RayScene> RayScene::build(std::span<const ResidentTile> tiles, Point<Ecef> origin,
                                 const glm::dmat3& meshAxes) {
    try {
        Result<std::unique_ptr<Rays>> rays = Rays::build(tiles, origin, meshAxes);
        if (!rays)
            return rays.error();
        return RayScene(std::make_unique<State>(State{std::move(rays).value()}));
    } catch (const std::bad_alloc&) {
        return Error{"reference", "not enough memory for the rays' scene", ErrorKind::Transient};
    }
}

Point<Ecef> RayScene::origin() const {
    return state_->rays->origin();
}

glm::dvec3 RayScene::stored(Point<Ecef> p) const {
    return stored(p - origin());
}

glm::dvec3 RayScene::stored(Vector<Ecef> v) const {
    return glm::transpose(state_->rays->meshAxes()) * v.xyz;
}

std::uint64_t RayScene::triangles() const {
    return state_->rays->triangles();
}

std::size_t RayScene::bytes() const {
    return state_->rays->bytes();
}

RayHit RayScene::first(const glm::dvec3& from, const glm::dvec3& direction,
                       double maximumMetres) const {
    return state_->rays->nearest(
        {from, glm::normalize(direction), glm::dvec3(0.0), 0.0, maximumMetres});
}

RayHit RayScene::blocker(const glm::dvec3& point, const glm::dvec3& normal,
                         const glm::dvec3& towards, double maximumMetres) const {
    return state_->rays->nearest({point, glm::normalize(towards), normal, 0.0, maximumMetres});
}

bool RayScene::blocked(const glm::dvec3& point, const glm::dvec3& normal, const glm::dvec3& towards,
                       double maximumMetres) const {
    return state_->rays->any({point, glm::normalize(towards), normal, 0.0, maximumMetres});
}

double RayScene::visibility(const glm::dvec3& point, const glm::dvec3& normal, const Light& light,
                            int rays, std::uint32_t seed) const {
    const Incoming incoming = incomingAt(point, light);
    if (rays <= 1 || incoming.tangent == 0.0)
        return state_->centre(point, normal, incoming);
    std::vector<glm::vec2> offsets{std::size_t(rays)};
    discPoints(patternOf(seed), offsets);
    return state_->disc(point, normal, incoming, offsets);
}

double RayScene::State::centre(const glm::dvec3& point, const glm::dvec3& normal,
                               const Incoming& incoming) const {
    if (!incoming.reaches(normal))
        return 0.0;
    return rays->any({point, incoming.towards, normal, 0.0, incoming.distanceMetres}) ? 0.0 : 1.0;
}

double RayScene::State::disc(const glm::dvec3& point, const glm::dvec3& normal,
                             const Incoming& incoming, std::span<const glm::vec2> offsets) const {
    if (!incoming.reaches(normal))
        return 0.0;
    const glm::dmat3 axes = lightAxes(incoming.towards);
    const int free = rays->escaping(point, normal, incoming.towards, incoming.tangent * axes[0],
                                    incoming.tangent * axes[1], offsets);
    return double(free) / double(offsets.size());
}

} // namespace gnomon::bench
