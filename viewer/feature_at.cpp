#include "viewer/feature_at.h"

#include "geo/ellipsoid.h"
#include "streaming/raycast.h"

#include <algorithm>
#include <limits>

namespace gnomon {

namespace {

// No surface of the Earth is as high, and no tile that matters lies as deep.
constexpr double kAboveMetres = 20e3, kBelowMetres = 20e3;

// A vertical is no volume, and a box may be thin.
constexpr double kColumnMetres = 0.01;
// Boxes that do not hold all of their tile's buildings are published (Amsterdam's miss 50 m). Where
// the column meets nothing, this one is tried.
constexpr double kWideColumnMetres = 100.0;

// What the vertical through the place meets, down to the smallest error there is.
View columnView(const Geodetic& place, double halfWidthMetres) {
    const Transform<Ecef, Enu> ecefFromEnu = gnomon::ecefFromEnu(place);
    const Point<Ecef> at = ecefFromEnu.origin();
    const glm::dmat3 axes = ecefFromEnu.axes();
    View view;
    for (const int axis : {0, 1}) {
        for (const double side : {1.0, -1.0}) {
            const Vector<Ecef> outwards{side * axes[axis]};
            view.planes.push_back({-outwards, at + halfWidthMetres * outwards});
        }
    }
    const Vector<Ecef> up{axes[2]};
    view.planes.push_back({up, at - kBelowMetres * up}); // not the other side of the Earth
    view.eye = at;
    view.forward = -up;
    constexpr double kFinestMetres = 1e-9;
    view.pixelMetres = kFinestMetres;
    return view;
}

Selection loadOver(StreamedTileset& tileset, const View& view,
                   std::chrono::steady_clock::time_point deadline) {
    constexpr std::chrono::milliseconds kPoll{50};
    SelectOptions options;
    options.maximumScreenSpaceError = 1.0;
    for (;;) {
        Selection selection = select(tileset.tree(), {&view, 1}, options);
        if (selection.complete() || std::chrono::steady_clock::now() >= deadline) {
            return selection;
        }
        tileset.request(selection.load);
        const bool underWay = tileset.wait(kPoll);
        if (tileset.poll() == 0 && !underWay) {
            return selection; // there is no room for it
        }
    }
}

// The lowest of a feature's vertices in the content.
double lowestOf(const TileContent& content, std::uint32_t feature, const glm::dmat3& meshAxes) {
    double lowest = std::numeric_limits<double>::infinity();
    for (const Mesh& mesh : content.meshes) {
        for (std::size_t i = 0; i < mesh.features.size(); ++i) {
            if (mesh.features[i] == feature) {
                const Point<Ecef> p{mesh.origin.xyz + meshAxes * glm::dvec3(mesh.positions[i])};
                lowest = std::min(lowest, geodeticOf(p).heightMetres);
            }
        }
    }
    return lowest;
}

std::optional<TileFeature> featureIn(StreamedTileset& tileset, const View& view,
                                     const Selection& selection, const glm::dmat3& meshAxes) {
    const Vector<Ecef> down = view.forward;
    const Point<Ecef> from = view.eye - kAboveMetres * down;
    std::optional<RayHit> highest;
    TileIndex in = kNoTile;
    for (const TileIndex tile : selection.draw) {
        const auto content = tileset.content(tile);
        if (!content || !content->features) {
            continue;
        }
        const auto hits = castRay(*content, meshAxes, from, down);
        const auto first = std::find_if(hits.begin(), hits.end(), [&](const RayHit& hit) {
            return hit.feature < content->features->rows();
        });
        if (first != hits.end() && (!highest || first->metres < highest->metres)) {
            highest = *first;
            in = tile;
        }
    }
    if (!highest) {
        return {};
    }
    const auto content = tileset.content(in);
    TileFeature found;
    found.feature = highest->feature;
    found.properties = content->features->row(found.feature);
    found.id = idOf(found.properties, found.feature);
    found.tile = tileset.tree().name(in);
    found.topMetres = geodeticOf(from + highest->metres * down).heightMetres;
    found.baseMetres = lowestOf(*content, found.feature, meshAxes);
    return found;
}

} // namespace

std::optional<TileFeature> featureAt(StreamedTileset& tileset, glm::dvec2 lonLat,
                                     const glm::dmat3& meshAxes,
                                     std::chrono::steady_clock::time_point deadline,
                                     bool* complete) {
    std::optional<TileFeature> found;
    for (const double halfWidth : {kColumnMetres, kWideColumnMetres}) {
        const View view = columnView({lonLat.x, lonLat.y, 0.0}, halfWidth);
        const Selection selection = loadOver(tileset, view, deadline);
        if (complete) {
            *complete = selection.complete() && selection.failed.empty();
        }
        found = featureIn(tileset, view, selection, meshAxes);
        if (found) {
            break;
        }
    }
    return found;
}

} // namespace gnomon
