#include "bench/streaming_tree.h"

#include "bench/scenes.h"
#include "shadows/cascades.h"
#include "shadows/light_basis.h"

#include <algorithm>
#include <cmath>

namespace gnomon::bench {
namespace {

constexpr double kLeafMetres = 128.0;
constexpr double kLowestErrorMetres = 4.0; // of a leaf's parent
constexpr double kTopMetres = 40.0;        // of the city's houses
constexpr int kWidth = 1280, kHeight = 720;

// A square of the city, metres east and north of its middle.
struct Square {
    double east = 0, north = 0, side = 0;
};

BoundingVolume boxOf(const Square& square, const Transform<Ecef, Enu>& ecefFromCity) {
    const glm::dvec3 half(square.side / 2, square.side / 2, kTopMetres / 2);
    const glm::dvec3 centre(square.east + half.x, square.north + half.y, half.z);
    const glm::dmat3 axes = ecefFromCity.axes();
    return OrientedBox{ecefFromCity(Point<Enu>{centre}),
                       glm::dmat3(half.x * axes[0], half.y * axes[1], half.z * axes[2])};
}

BoundingVolume regionOf(const Square& square) {
    const double perNorth = kRadiansPerDegree * kEquatorialRadiusMetres;
    const double perEast = perNorth * std::cos(kDefaultPlace.latitudeDegrees * kRadiansPerDegree);
    const double west = kDefaultPlace.longitudeDegrees + square.east / perEast;
    const double south = kDefaultPlace.latitudeDegrees + square.north / perNorth;
    return makeRegion(west, south, west + square.side / perEast, south + square.side / perNorth,
                      kDefaultPlace.heightMetres, kDefaultPlace.heightMetres + kTopMetres);
}

// The levels that a full quadtree of as many tiles would have.
int levelsFor(std::size_t tiles) {
    int levels = 1;
    for (std::size_t full = 1; full < tiles; full = 4 * full + 1)
        ++levels;
    return levels;
}

Camera cameraAt(const glm::dvec3& eastNorthUp, double heading, double pitch, double fovDegrees) {
    const Transform<Ecef, Enu> ecefFromCity = ecefFromEnu(kDefaultPlace);
    Camera camera;
    camera.widthPixels = kWidth;
    camera.heightPixels = kHeight;
    camera.verticalFovRadians = fovDegrees * kRadiansPerDegree;
    place(camera, geodeticOf(ecefFromCity(Point<Enu>{eastNorthUp})), {heading, pitch, 0.0});
    return camera;
}

FrameViews frameViews(const char* name, const Camera& camera, double error, double farMetres) {
    const Transform<Ecef, Enu> ecefFromCity = ecefFromEnu(kDefaultPlace);
    // A low sun in the south-west: the light's views reach far beyond the picture.
    const Vector<Ecef> towardsSun = normalize(ecefFromCity(Vector<Enu>{{-0.6, -0.5, 0.5}}));
    CascadeInput input;
    input.camera = camera;
    input.lightFromEcef = lightFromEcef(ecefFromCity, towardsSun);
    input.farMetres = input.rangeMetres = farMetres;
    input.fadeMetres = farMetres / 10.0;
    ShadowSettings settings;
    settings.fit = ShadowFit::Stable;
    const CascadeSet set = fitCascades(input, settings);
    FrameViews frame{name, {perspectiveView(camera)}, error};
    for (const Cascade& cascade : set.cascades)
        frame.views.push_back(casterView(set, cascade));
    return frame;
}

} // namespace

const char* nameOf(VolumeKind kind) {
    return kind == VolumeKind::Boxes ? "boxes" : "regions";
}

Result<TileTree> cityTree(std::size_t tiles, VolumeKind kind) {
    const Transform<Ecef, Enu> ecefFromCity = ecefFromEnu(kDefaultPlace);
    const int levels = levelsFor(tiles);
    const double side = std::ldexp(kLeafMetres, levels - 1);
    std::vector<MadeTile> made;
    std::vector<Square> squares;
    const auto add = [&](TileIndex parent, const Square& square) {
        MadeTile tile;
        tile.parent = parent;
        tile.volume = kind == VolumeKind::Boxes ? boxOf(square, ecefFromCity) : regionOf(square);
        // What a tile of its place in a real tileset carries; never read.
        tile.path = "content/" + std::to_string(made.size()) + ".glb";
        made.push_back(std::move(tile));
        squares.push_back(square);
    };
    add(kNoTile, {-side / 2, -side / 2, side});
    for (std::size_t i = 0; made.size() < tiles; ++i) {
        const Square square = squares[i];
        const double half = square.side / 2;
        made[i].geometricErrorMetres = kLowestErrorMetres * half / kLeafMetres;
        for (const double north : {0.0, half})
            for (const double east : {0.0, half})
                add(TileIndex(i), {square.east + east, square.north + north, half});
    }
    Result<TileTree> tree = TileTree::ofTiles("city", made);
    if (tree)
        for (TileIndex i = 0; i < tree->size(); ++i)
            tree->setState(i, LoadState::Ready);
    return tree;
}

std::vector<FrameViews> cityViews(const TileTree& tree) {
    const double radius = boundingSphere(tree.node(TileTree::root()).volume).radiusMetres;
    std::vector<FrameViews> out;
    out.push_back(frameViews("street", cameraAt({20, 10, 2}, 30, 2, 60), 8.0, 2000.0));
    out.push_back(frameViews("oblique", cameraAt({0, 0, 300}, 30, -25, 45), 2.0, 4000.0));
    // From so high that all of it is in sight, at an error that only leaves satisfy.
    out.push_back(
        frameViews("whole", cameraAt({0, 0, 3.0 * radius}, 0, -89.9, 45), 1e-6, 4.0 * radius));
    return out;
}

} // namespace gnomon::bench
