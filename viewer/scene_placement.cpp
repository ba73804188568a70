#include "viewer/scene_placement.h"

#include <algorithm>
#include <cmath>
#include <deque>

namespace gnomon {

namespace {

// What may stand on the Earth: from below the deepest sea floor or mine to above any building,
// tower or mountain. Projected coordinates taken for ECEF miss this shell by far (UTM: 700 km too
// deep).
constexpr double kDeepestMetres = -20e3;
constexpr double kHighestMetres = 20e3;
// Volumes this large are country- or globe-wide: their centre may lie deep below the surface.
constexpr double kWideMetres = 500e3;
constexpr std::chrono::milliseconds kPoll{50};

using Clock = std::chrono::steady_clock;

Failure loadOne(StreamedTileset& tileset, TileIndex tile,
                std::optional<Clock::time_point> deadline) {
    const LoadRequest wanted{tile, 0.0};
    tileset.request({&wanted, 1});
    while (tileset.tree().node(tile).state == LoadState::Unloaded ||
           tileset.tree().node(tile).state == LoadState::Loading) {
        // A disk that is slow is no fault.
        if (const Error* fault = tileset.lastFault(tile);
            fault && deadline && Clock::now() >= *deadline)
            return *fault;
        const bool underWay = tileset.wait(kPoll);
        if (tileset.poll() == 0 && !underWay)
            break;
    }
    return {};
}

} // namespace

namespace {

// Such coordinates lie near the plane of the equator, and what they hold is flat along z and wide
// along what would be up. A real place at the equator is the other way round.
bool looksProjected(const BoundingVolume& volume) {
    constexpr double kLowestMetres = -1e3, kHighestGroundMetres = 1e4;
    const auto* box = std::get_if<OrientedBox>(&volume);
    if (!box)
        return false;
    const auto extent = [&](const Vector<Ecef>& direction) {
        return extentAlong(volume, Point<Ecef>{}, direction);
    };
    const Interval z = extent({{0, 0, 1}});
    const Interval up = extent(ellipsoidNormal(box->centre));
    return z.min > kLowestMetres && z.max < kHighestGroundMetres &&
           2.0 * (z.max - z.min) < up.max - up.min;
}

} // namespace

bool standsOnEarth(const BoundingVolume& volume) {
    if (std::holds_alternative<Region>(volume))
        return true;
    if (looksProjected(volume))
        return false;
    const Sphere sphere = boundingSphere(volume);
    const double fromCentre = length(sphere.centre - Point<Ecef>{});
    if (!std::isfinite(fromCentre) || !std::isfinite(sphere.radiusMetres))
        return false;
    const bool reachesSurface = std::abs(fromCentre - kEquatorialRadiusMetres) <=
                                sphere.radiusMetres + kEquatorialRadiusMetres - kPolarRadiusMetres;
    if (sphere.radiusMetres > kWideMetres)
        return reachesSurface;
    const Result<Geodetic> centre = geodeticFromEcef(sphere.centre);
    return centre && centre->heightMetres > kDeepestMetres - sphere.radiusMetres &&
           centre->heightMetres < kHighestMetres + sphere.radiusMetres;
}

Transform<Ecef, Tile> placedFrame(const Placement& placement, double raiseMetres, FrameUp which) {
    Geodetic origin = placement.origin;
    origin.heightMetres += raiseMetres;
    const double heading = placement.headingDegrees * kRadiansPerDegree;
    const double s = std::sin(heading), c = std::cos(heading);
    // Columns: where the frame's right, forward and up point in east, north, up.
    const glm::dvec3 right(c, -s, 0), forward(s, c, 0), up(0, 0, 1);
    glm::dmat3 axes(right, forward, up);
    if (which == FrameUp::Y)
        axes = glm::dmat3(right, up, -forward);
    else if (which == FrameUp::MinusY)
        axes = glm::dmat3(right, -up, forward);
    return ecefFromEnu(origin) * Transform<Enu, Tile>{glm::dmat4(axes)};
}

std::optional<Geodetic> uprightOrigin(const Transform<Ecef, Tile>& frame) {
    constexpr double kRounding = 1e-9; // of matrices written with ten digits or more
    const glm::dmat3 axes = frame.axes(), square = glm::transpose(axes) * axes;
    const Result<Geodetic> origin = geodeticFromEcef(frame.origin());
    if (!origin || origin->heightMetres < kDeepestMetres || origin->heightMetres > kHighestMetres)
        return std::nullopt;
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j)
            if (!(std::abs(square[i][j] - (i == j ? 1.0 : 0.0)) <= kRounding))
                return std::nullopt;
    if (!(glm::length(axes[2] - ellipsoidNormal(frame.origin()).xyz) <= kRounding))
        return std::nullopt;
    Geodetic place = *origin;
    constexpr double kAtPoleMetres = 1.0; // nearer, a longitude is worth less than the axis
    const glm::dvec3 p = frame.origin().xyz;
    if (std::hypot(p.x, p.y) < kAtPoleMetres)
        place.longitudeDegrees = std::atan2(-axes[0].x, axes[0].y) / kRadiansPerDegree;
    return place;
}

Result<FirstContents> firstContents(StreamedTileset& tileset, std::size_t count,
                                    std::optional<Clock::time_point> deadline) {
    // Broken tilesets may name thousands of contents that are not there.
    constexpr std::size_t kMostTried = 64;
    FirstContents found;
    std::deque<TileIndex> queue{TileTree::root()};
    std::size_t tried = 0;
    while (!queue.empty() && found.size() < count && tried < kMostTried) {
        const TileIndex tile = queue.front();
        queue.pop_front();
        if (tileset.tree().node(tile).content != ContentKind::None) {
            ++tried;
            if (Failure late = loadOne(tileset, tile, deadline))
                return *late;
            if (auto content = tileset.content(tile); content && !content->meshes.empty())
                found.push_back(std::move(content));
        }
        const TileNode& node = tileset.tree().node(tile);
        for (std::uint32_t i = 0; i < node.childCount; ++i)
            queue.push_back(node.firstChild + i);
    }
    return found;
}

std::optional<ModelUp> upFromGeometry(const FirstContents& some) {
    glm::dvec3 areaVector(0.0);
    double area = 0.0;
    for (const auto& content : some)
        for (const Mesh& mesh : content->meshes)
            for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
                const glm::dvec3 a(mesh.positions[mesh.indices[i]]);
                const glm::dvec3 b(mesh.positions[mesh.indices[i + 1]]);
                const glm::dvec3 c(mesh.positions[mesh.indices[i + 2]]);
                const glm::dvec3 twice = glm::cross(b - a, c - a);
                areaVector += 0.5 * twice;
                area += 0.5 * glm::length(twice);
            }
    // A sheet whose mean slope is below 60° keeps more than cos 60° of its area in the sum; closed
    // bodies keep nothing, whichever way they stand.
    if (!(glm::length(areaVector) > 0.5 * area))
        return std::nullopt;
    // The sheet faces an axis when it is nearer to it than to the others: within 45°.
    const glm::dvec3 facing = glm::abs(glm::normalize(areaVector));
    const double nearest = std::sqrt(0.5);
    if (facing.y > nearest)
        return ModelUp::Y;
    if (facing.z > nearest)
        return ModelUp::Z;
    return std::nullopt;
}

} // namespace gnomon
