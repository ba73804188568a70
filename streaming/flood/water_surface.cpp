#include "streaming/flood/water_surface.h"

#include "geo/ellipsoid.h"
#include "streaming/flood/water_surface_moment.h"

#include <cmath>
#include <limits>
#include <unordered_map>

namespace gnomon {

namespace {

constexpr std::uint32_t kNone = 0xffffffffu;

// One mesh: vertices are made as triangles ask for them, each once.
class PatchBuilder {
  public:
    PatchBuilder(const WaterMoments& moments, const WaterMoment& moment,
                 std::vector<std::uint32_t>& vertexOf)
        : nodes_(moments.nodes()), moment_(moment), wet_(moments.wetTriangles(moment)),
          vertexOf_(vertexOf) {}

    void add(const NodeTriangle& triangle) {
        const int corners = wet_.wetCorners(triangle);
        if (corners == 0)
            return;
        if (corners == 3) { // most: no need to be cut
            for (const std::uint32_t node : triangle)
                indices_.push_back(atNode(node));
            return;
        }
        const WaterPieces parts = wet_.piecesOf(triangle, moment_.rule);
        for (int i = 0; i < parts.count; ++i)
            for (const WaterCorner& corner : parts.pieces[std::size_t(i)])
                indices_.push_back(corner.isNode() ? atNode(corner.wet) : onEdge(corner));
    }

    WaterMesh mesh(const glm::dmat3& meshAxes) {
        for (const std::uint32_t node : used_)
            vertexOf_[node] = kNone;
        WaterMesh mesh;
        glm::dvec3 low(points_.front().xyz), high(low);
        for (const Point<Ecef>& p : points_) {
            low = glm::min(low, p.xyz);
            high = glm::max(high, p.xyz);
        }
        mesh.origin = {0.5 * (low + high)};
        mesh.box = boxAround(points_, ecefFromEnu(geodeticOf(mesh.origin)).axes());
        const glm::dmat3 stored = glm::transpose(meshAxes);
        mesh.vertices.reserve(points_.size());
        for (std::size_t i = 0; i < points_.size(); ++i) {
            const Vector<Ecef> from = points_[i] - mesh.origin;
            mesh.radiusMetres = std::max(mesh.radiusMetres, length(from));
            mesh.vertices.push_back({glm::vec3(stored * from.xyz), depths_[i], velocities_[i]});
        }
        mesh.indices = std::move(indices_);
        return mesh;
    }

    bool empty() const { return indices_.empty(); }

  private:
    std::uint32_t put(glm::dvec2 lonLat, double level, double depth, glm::vec2 velocity) {
        points_.push_back(ecefOf({lonLat.x, lonLat.y, level}));
        depths_.push_back(float(depth));
        velocities_.push_back(velocity);
        return std::uint32_t(points_.size() - 1);
    }

    glm::vec2 velocity(std::uint32_t node) const {
        return moment_.velocities.empty() ? glm::vec2(0.0f) : moment_.velocities[node];
    }

    std::uint32_t atNode(std::uint32_t node) {
        std::uint32_t& vertex = vertexOf_[node];
        if (vertex == kNone) {
            vertex =
                put(nodes_.lonLat(node), wet_.level(node), moment_.depths[node], velocity(node));
            used_.push_back(node);
        }
        return vertex;
    }

    std::uint32_t onEdge(const WaterCorner& corner) {
        auto& ends = onEdge_[std::uint64_t(corner.wet) << 32 | corner.dry];
        std::uint32_t& vertex = ends[corner.isFoot ? 0 : 1];
        if (vertex == 0) { // one more than its number
            const glm::dvec2 a = nodes_.lonLat(corner.wet), b = nodes_.lonLat(corner.dry);
            const glm::dvec2 way(std::remainder(b.x - a.x, 360.0), b.y - a.y);
            vertex = 1 + put(a + corner.share * way, wet_.level(corner.wet), corner.depth,
                             velocity(corner.wet));
        }
        return vertex - 1;
    }

    const WaterNodes& nodes_;
    const WaterMoment& moment_;
    WetTriangles wet_;
    std::vector<std::uint32_t>& vertexOf_; // of all nodes; kNone but while this mesh is made
    std::vector<std::uint32_t> used_;
    std::unordered_map<std::uint64_t, std::array<std::uint32_t, 2>> onEdge_;
    std::vector<Point<Ecef>> points_;
    std::vector<float> depths_;
    std::vector<glm::vec2> velocities_;
    std::vector<std::uint32_t> indices_;
};

class Surface final : public WaterSurface {
  public:
    Surface(std::shared_ptr<const FloodData> data, std::shared_ptr<const GroundHeights> ground,
            const WaterSurfaceOptions& options)
        : moments_(std::move(data), options.dryMetres), ground_(std::move(ground)) {}

    Failure prepare() {
        if (const Failure failed = moments_.setBed(ground_.get()))
            return failed;
        return survey();
    }

    const FloodData& data() const override { return moments_.data(); }
    std::array<double, 4> extent() const override { return extent_; }
    Sphere bounds() const override { return bounds_; }
    double deepestMetres() const override { return deepest_; }
    double fastest() const override { return fastest_; }

    Result<std::vector<WaterMesh>> meshes(double seconds,
                                          const glm::dmat3& meshAxes) const override;
    Result<std::optional<WaterAt>> at(double seconds, glm::dvec2 lonLat) const override;
    Result<WaterTotals> totals(double seconds) const override;

  private:
    Failure survey();
    void setBounds(const std::vector<char>& everWet, double low, double high);
    std::optional<WaterAt> inPiece(const WaterMoment& moment, const NodeTriangle& triangle,
                                   const WaterPieces& parts, glm::dvec3 weights) const;

    WaterMoments moments_;
    std::shared_ptr<const GroundHeights> ground_;
    std::array<double, 4> extent_{};
    Sphere bounds_;
    double deepest_ = 0.0, fastest_ = 0.0;
    mutable std::vector<std::uint32_t> vertexOf_;
};

// All steps are looked at; of very many values only some steps, evenly.
Failure Surface::survey() {
    constexpr std::size_t kMostValues = 40'000'000;
    const std::size_t steps = data().stepSeconds().size(), nodes = moments_.nodes().size();
    const std::size_t most =
        std::max<std::size_t>(kMostValues / std::max<std::size_t>(nodes, 1), 3);
    const std::size_t looked = std::min(steps, most);
    std::vector<char> everWet(nodes, 0);
    double low = std::numeric_limits<double>::infinity(), high = -low;
    bool any = false;
    Failure wrong;
    for (std::size_t k = 0; k < looked; ++k) {
        const std::size_t index = looked == 1 ? 0 : k * (steps - 1) / (looked - 1);
        const auto step = moments_.step(index);
        if (!step) {
            wrong = step.error(); // told when this step is to be shown
            continue;
        }
        const std::vector<float>& depths = (*step)->depths;
        for (std::size_t i = 0; i < nodes; ++i) {
            if (!(double(depths[i]) > moments_.dryMetres()))
                continue;
            any = true;
            everWet[i] = 1;
            const double level = double(moments_.beds()[i]) + depths[i];
            low = std::min(low, level);
            high = std::max(high, level);
            deepest_ = std::max(deepest_, double(depths[i]));
            if (!(*step)->velocities.empty())
                fastest_ = std::max(fastest_, double(glm::length((*step)->velocities[i])));
        }
    }
    if (!any)
        return wrong ? *wrong
                     : Error{data().path, "has no water at any of its " + std::to_string(steps) +
                                              (steps == 1 ? " step" : " steps")};
    if (looked < steps)
        std::fill(everWet.begin(), everWet.end(), 1);
    setBounds(everWet, low, high);
    return {};
}

void Surface::setBounds(const std::vector<char>& everWet, double low, double high) {
    const WaterNodes& nodes = moments_.nodes();
    // About one of them, so that the antimeridian is no edge.
    const auto isEverWet = [&](std::uint32_t node) { return everWet[node] != 0; };
    std::optional<glm::dvec2> start;
    glm::dvec2 west(0.0), east(0.0);
    for (const WaterNodes::Patch& patch : nodes.patches())
        nodes.eachTriangle(patch, isEverWet, [&](const NodeTriangle& t) {
            if (!everWet[t[0]] && !everWet[t[1]] && !everWet[t[2]])
                return;
            for (const std::uint32_t node : t) {
                const glm::dvec2 p = nodes.lonLat(node);
                if (!start)
                    start = p;
                const glm::dvec2 off(std::remainder(p.x - start->x, 360.0), p.y - start->y);
                west = {std::min(west.x, off.x), std::min(west.y, off.y)};
                east = {std::max(east.x, off.x), std::max(east.y, off.y)};
            }
        });
    if (!start)
        start = glm::dvec2(0.0);
    extent_ = {std::remainder(start->x + west.x, 360.0), start->y + west.y,
               std::remainder(start->x + east.x, 360.0), start->y + east.y};
    bounds_ = boundingSphere(
        BoundingVolume(makeRegion(extent_[0], extent_[1], extent_[2], extent_[3], low, high)));
}

Result<std::vector<WaterMesh>> Surface::meshes(double seconds, const glm::dmat3& meshAxes) const {
    const auto moment = moments_.at(seconds);
    if (!moment)
        return moment.error();
    const WaterNodes& nodes = moments_.nodes();
    const WetTriangles wet = moments_.wetTriangles(**moment);
    const auto isWet = [&](std::uint32_t node) { return wet.isWet(node); };
    vertexOf_.resize(nodes.size(), kNone);
    std::vector<WaterMesh> meshes;
    for (std::size_t p = 0; p < nodes.patches().size(); ++p) {
        if (!(*moment)->patchIsWet[p])
            continue;
        PatchBuilder builder(moments_, **moment, vertexOf_);
        nodes.eachTriangle(nodes.patches()[p], isWet,
                           [&](const NodeTriangle& t) { builder.add(t); });
        if (!builder.empty())
            meshes.push_back(builder.mesh(meshAxes));
    }
    return meshes;
}

// Of a place among three: what each has to say; none outside of them.
std::optional<glm::dvec3> weightsOf(glm::dvec2 p, const std::array<glm::dvec2, 3>& corners) {
    const auto [south, north] = std::minmax({corners[0].y, corners[1].y, corners[2].y});
    if (p.y < south || p.y > north) // most, when all triangles are asked
        return std::nullopt;
    const auto from = [&](std::size_t i) {
        return glm::dvec2(std::remainder(corners[i].x - p.x, 360.0), corners[i].y - p.y);
    };
    const glm::dvec2 a = from(0), b = from(1), c = from(2);
    const auto cross = [](glm::dvec2 u, glm::dvec2 v) { return u.x * v.y - u.y * v.x; };
    const glm::dvec3 areas(cross(b, c), cross(c, a), cross(a, b));
    const double sum = areas.x + areas.y + areas.z;
    const double least = -1e-9 * sum; // a place on an edge must lie in one of both
    if (!(sum > 0.0) || areas.x < least || areas.y < least || areas.z < least)
        return std::nullopt;
    return areas / sum;
}

std::optional<WaterAt> Surface::inPiece(const WaterMoment& moment, const NodeTriangle&,
                                        const WaterPieces& parts, glm::dvec3 weights) const {
    const WetTriangles wet = moments_.wetTriangles(moment);
    for (int i = 0; i < parts.count; ++i) {
        const WaterPiece& piece = parts.pieces[std::size_t(i)];
        const glm::dmat3 corners(piece[0].weights, piece[1].weights, piece[2].weights);
        if (std::abs(glm::determinant(corners)) < 1e-12)
            continue;
        const glm::dvec3 shares = glm::inverse(corners) * weights;
        if (shares.x < -1e-9 || shares.y < -1e-9 || shares.z < -1e-9)
            continue;
        WaterAt at;
        glm::dvec2 velocity(0.0);
        for (int k = 0; k < 3; ++k) {
            const WaterCorner& corner = piece[std::size_t(k)];
            at.levelMetres += shares[k] * wet.level(corner.wet);
            at.depthMetres += shares[k] * corner.depth;
            if (!moment.velocities.empty())
                velocity += shares[k] * glm::dvec2(moment.velocities[corner.wet]);
        }
        if (!moment.velocities.empty())
            at.velocity = glm::vec2(velocity);
        if (at.depthMetres > 0.0)
            return at;
    }
    return std::nullopt;
}

Result<std::optional<WaterAt>> Surface::at(double seconds, glm::dvec2 lonLat) const {
    const auto moment = moments_.at(seconds);
    if (!moment)
        return moment.error();
    const WaterNodes& nodes = moments_.nodes();
    const WetTriangles wet = moments_.wetTriangles(**moment);
    const auto isWet = [&](std::uint32_t node) { return wet.isWet(node); };
    std::optional<WaterAt> found;
    for (std::size_t p = 0; p < nodes.patches().size() && !found; ++p) {
        const WaterNodes::Patch& patch = nodes.patches()[p];
        if (!(*moment)->patchIsWet[p] ||
            !(std::abs(std::remainder(lonLat.x - patch.middle.x, 360.0)) <= patch.reach.x + 1e-9) ||
            !(std::abs(lonLat.y - patch.middle.y) <= patch.reach.y + 1e-9))
            continue;
        nodes.eachTriangle(patch, isWet, [&](const NodeTriangle& t) {
            if (found || wet.wetCorners(t) == 0)
                return;
            const auto weights =
                weightsOf(lonLat, {nodes.lonLat(t[0]), nodes.lonLat(t[1]), nodes.lonLat(t[2])});
            if (weights)
                found = inPiece(**moment, t, wet.piecesOf(t, (*moment)->rule), *weights);
        });
    }
    if (found && data().isInterpolated()) {
        found->interpolated = true;
        // Its bed is the ground, which is known better than at the nodes.
        if (const double ground = ground_ ? ground_->at(lonLat) : std::nan("");
            std::isfinite(ground)) {
            found->depthMetres = found->levelMetres - ground;
            if (!(found->depthMetres > 0.0))
                found.reset();
        }
    }
    return found;
}

Result<WaterTotals> Surface::totals(double seconds) const {
    const auto moment = moments_.at(seconds);
    if (!moment)
        return moment.error();
    WaterTotals totals;
    totals.wetAreaSquareMetres = (*moment)->byNodes.area;
    totals.volumeCubicMetres = (*moment)->byNodes.volume;
    totals.shownAreaSquareMetres = (*moment)->shown.area;
    totals.shownVolumeCubicMetres = (*moment)->shown.volume;
    totals.maxDepthMetres = (*moment)->deepest;
    totals.maxSpeed = (*moment)->fastest;
    return totals;
}

} // namespace

Result<std::shared_ptr<WaterSurface>>
WaterSurface::create(std::shared_ptr<const FloodData> data,
                     const std::shared_ptr<const GroundHeights>& ground,
                     const WaterSurfaceOptions& options) {
    if (ground) {
        Result<std::shared_ptr<const FloodData>> madeOut = data->on(*ground);
        if (!madeOut)
            return madeOut.error();
        if (*madeOut)
            data = std::move(*madeOut);
    }
    auto surface = std::make_shared<Surface>(std::move(data), ground, options);
    if (const Failure failed = surface->prepare())
        return *failed;
    return std::shared_ptr<WaterSurface>(std::move(surface));
}

} // namespace gnomon
