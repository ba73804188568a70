#include "viewer/place/tiles.h"

#include "viewer/place/glb.h"

#include <glm/geometric.hpp>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>

namespace gnomon::builtin {
namespace {

constexpr int kGridSquares = 32;
constexpr double kErrorOneLevelUpMetres = 4.0;
// Enough for paint on asphalt; below 80 it smears.
constexpr int kJpegQuality = 84;

template <class T>
std::vector<std::byte> toBytes(const std::vector<T>& values) {
    std::vector<std::byte> bytes(values.size() * sizeof(T));
    if (!bytes.empty())
        std::memcpy(bytes.data(), values.data(), bytes.size());
    return bytes;
}

int levelsUp(const Plan& plan, TileId id) {
    // A leaf, also one that is a leaf early, shows everything.
    return subdivided(plan, id) ? plan.levels() - id.level : 0;
}

class TerrainBuilder {
  public:
    TerrainBuilder(const Plan& plan, const Rect& tile) : plan_(plan), tile_(tile) {
        fine_ = std::int64_t(tile.width() / kGroundStepMetres);
        step_ = fine_ / kGridSquares;
        west_ = std::int64_t(tile.west / kGroundStepMetres);
        south_ = std::int64_t(tile.south / kGroundStepMetres);
        shape_.origin = {tile.centre(), 0};
    }

    Shape build() {
        std::uint32_t inner[kGridSquares - 1][kGridSquares - 1];
        for (int j = 1; j < kGridSquares; ++j)
            for (int i = 1; i < kGridSquares; ++i)
                inner[j - 1][i - 1] = vertex(i * step_, j * step_);
        constexpr int n = kGridSquares - 1;
        for (int j = 0; j + 1 < n; ++j)
            for (int i = 0; i + 1 < n; ++i) {
                const std::uint32_t a = inner[j][i], b = inner[j][i + 1];
                const std::uint32_t c = inner[j + 1][i + 1], d = inner[j + 1][i];
                shape_.indices.insert(shape_.indices.end(), {a, b, c, a, c, d});
            }
        // Counter-clockwise around the tile, from its south-western corner.
        std::vector<std::uint32_t> edge;
        for (std::int64_t k = 0; k < 4 * fine_; ++k)
            edge.push_back(edgeVertex(k));
        edge.push_back(edge.front());
        for (int side = 0; side < 4; ++side) {
            std::vector<std::uint32_t> row;
            for (int k = 0; k < n; ++k)
                row.push_back(side == 0   ? inner[0][k]
                              : side == 1 ? inner[k][n - 1]
                              : side == 2 ? inner[n - 1][n - 1 - k]
                                          : inner[n - 1 - k][0]);
            zip(std::span(edge).subspan(std::size_t(side * fine_), std::size_t(fine_ + 1)), row);
        }
        return std::move(shape_);
    }

  private:
    std::uint32_t vertex(std::int64_t i, std::int64_t j) {
        const std::int64_t gi = west_ + i, gj = south_ + j;
        const auto h = [&](int di, int dj) { return plan_.gridHeight(gi + di, gj + dj); };
        const glm::dvec3 p{double(gi) * kGroundStepMetres, double(gj) * kGroundStepMetres, h(0, 0)};
        shape_.positions.push_back(p - shape_.origin);
        const glm::dvec3 up{h(-1, 0) - h(1, 0), h(0, -1) - h(0, 1), 2 * kGroundStepMetres};
        shape_.normals.push_back(glm::vec3(glm::normalize(up)));
        shape_.uvs.push_back(
            {float(double(i) / double(fine_)), float(1 - double(j) / double(fine_))});
        return std::uint32_t(shape_.positions.size() - 1);
    }

    std::uint32_t edgeVertex(std::int64_t k) {
        const std::int64_t side = k / fine_, t = k % fine_;
        return side == 0   ? vertex(t, 0)
               : side == 1 ? vertex(fine_, t)
               : side == 2 ? vertex(fine_ - t, fine_)
                           : vertex(0, fine_ - t);
    }

    // Triangles between the edge's many corners and the row's few, which lies to its left.
    void zip(std::span<const std::uint32_t> edge, std::span<const std::uint32_t> row) {
        std::size_t e = 0, r = 0;
        while (e + 1 < edge.size() || r + 1 < row.size()) {
            const double nextEdge = double(e + 1) / double(edge.size() - 1);
            const double nextRow = (double(r) + 1.5) / kGridSquares;
            const bool alongEdge =
                r + 1 >= row.size() || (e + 1 < edge.size() && nextEdge <= nextRow);
            if (alongEdge) {
                shape_.indices.insert(shape_.indices.end(), {edge[e], edge[e + 1], row[r]});
                ++e;
            } else {
                shape_.indices.insert(shape_.indices.end(), {edge[e], row[r + 1], row[r]});
                ++r;
            }
        }
    }

    const Plan& plan_;
    Rect tile_;
    Shape shape_;
    std::int64_t fine_ = 0, step_ = 0, west_ = 0, south_ = 0; // in finest steps
};

// Every second tree, always the same ones.
bool keptInHalf(const Tree& t) {
    return hash(0, std::int64_t(t.at.x * 256), std::int64_t(t.at.y * 256), 80) & 1;
}

void addCell(TileShapes& out, const Plan& plan, const Cell& cell, std::uint32_t firstId, int up,
             double lowestMass) {
    if (up >= 4)
        return addMasses(out.houses, cell, lowestMass);
    const Detail detail = up == 0 ? Detail::Full : up < 3 ? Detail::Plain : Detail::Boxes;
    for (std::size_t i = 0; i < cell.buildings.size(); ++i) {
        const Building& b = cell.buildings[i];
        Shape& shape = b.facade == Facade::Offices ? out.offices : out.houses;
        shape.feature = std::uint16_t(out.ids.size());
        addBuilding(shape, b, detail);
        out.ids.push_back(firstId + std::uint32_t(i));
        out.heights.push_back(float(b.topMetres() - b.baseMetres - 1.5));
    }
    out.buildings += cell.buildings.size();
    if (up == 0) {
        for (const Shed& s : cell.sheds)
            addShed(out.sheds, plan, s);
        out.shedCount += cell.sheds.size();
    }
    for (const Tree& t : cell.trees)
        if (up < 2 || (up == 2 && keptInHalf(t)))
            out.trees.push_back(t);
}

Instances instancesOf(const Plan& plan, const std::vector<Tree>& trees, TreeKind kind,
                      glm::dvec3 origin, double groundStep) {
    Instances where;
    for (const Tree& t : trees) {
        if (t.kind != kind)
            continue;
        const glm::dvec3 foot(t.at, plan.ground(t.at, groundStep));
        where.translations.push_back(yUp(foot - origin));
        const double h = t.headingRadians / 2;
        where.rotations.push_back({0.0f, float(std::sin(h)), 0.0f, float(std::cos(h))});
        // Some slimmer, some broader.
        const double wide = t.heightMetres * (0.9 + 0.2 * t.headingRadians / 6.2831853);
        where.scales.push_back({float(wide), float(t.heightMetres), float(wide)});
    }
    return where;
}

} // namespace

double geometricErrorMetres(const Plan& plan, int level) {
    return std::ldexp(kErrorOneLevelUpMetres, plan.levels() - 1 - level);
}

CellRange cellsOf(const Plan& plan, TileId id) {
    const int span = 1 << (plan.levels() - id.level);
    const int west = plan.firstCell() + id.x * span, south = plan.firstCell() + id.y * span;
    return {west, south, west + span, south + span};
}

Rect tileRect(const Plan& plan, TileId id) {
    const CellRange c = cellsOf(plan, id);
    return {c.west * kCellMetres, c.south * kCellMetres, c.east * kCellMetres,
            c.north * kCellMetres};
}

bool subdivided(const Plan& plan, TileId id) {
    const int up = plan.levels() - id.level;
    if (up == 0 || up > 2)
        return up != 0;
    const CellRange c = cellsOf(plan, id);
    for (int iy = c.south; iy < c.north; ++iy)
        for (int ix = c.west; ix < c.east; ++ix)
            if (plan.detailed(ix, iy))
                return true;
    return false;
}

Shape terrainShape(const Plan& plan, const Rect& tile) {
    return TerrainBuilder(plan, tile).build();
}

TileShapes tileShapes(const Plan& plan, TileId id) {
    TileShapes out;
    const glm::dvec3 origin(tileRect(plan, id).centre(), 0);
    const int up = levelsUp(plan, id);
    out.houses.origin = out.offices.origin = out.sheds.origin = origin;
    out.houses.withFeatures = out.offices.withFeatures = up < 4;
    const CellRange range = cellsOf(plan, id);
    const double lowest = geometricErrorMetres(plan, id.level) / 4;
    for (int iy = range.south; iy < range.north; ++iy)
        for (int ix = range.west; ix < range.east; ++ix) {
            const auto index = std::uint32_t(iy - plan.firstCell()) * std::uint32_t(plan.cells()) +
                               std::uint32_t(ix - plan.firstCell());
            const Cell cell = plan.cell(ix, iy);
            addCell(out, plan, cell, index * 256, up, lowest);
            const Detail detail = up == 0 ? Detail::Full : Detail::Plain;
            if (cell.kind != CellKind::Square && (cell.kind != CellKind::Bridge || up > 3))
                continue;
            out.houses.feature = std::uint16_t(out.ids.size());
            if (cell.kind == CellKind::Square)
                addTower(out.houses, plan, detail);
            else
                addBridge(out.houses, plan, detail);
            out.ids.push_back(index * 256 + 255);
            out.heights.push_back(cell.kind == CellKind::Square ? float(plan.towerMetres())
                                                                : 12.7f);
        }
    return out;
}

Result<SharedPictures> makeSharedPictures(std::uint64_t seed) {
    auto houses = encodePng(facadePixels(Facade::Houses, seed));
    if (!houses)
        return houses.error();
    auto offices = encodePng(facadePixels(Facade::Offices, seed));
    if (!offices)
        return offices.error();
    return SharedPictures{std::move(houses).value(), std::move(offices).value()};
}

Result<TileBytes> makeTile(const Plan& plan, TileId id, const Pixels& ground,
                           const SharedPictures& pictures) {
    const Rect rect = tileRect(plan, id);
    const Shape terrain = terrainShape(plan, rect);
    const TileShapes shapes = tileShapes(plan, id);
    const auto image = encodeJpeg(ground, kJpegQuality);
    if (!image)
        return image.error();
    Glb glb;
    glb.setOrigin(terrain.origin);
    if (shapes.houses.withFeatures)
        glb.setTable(shapes.ids.size(), {{"id", "UINT32", toBytes(shapes.ids)},
                                         {"height", "FLOAT32", toBytes(shapes.heights)}});
    const int groundMaterial =
        glb.addMaterial("ground", glb.addTexture(*image, "image/jpeg", false), false);
    if (auto error = glb.addMesh("ground", terrain, groundMaterial))
        return *error;
    const auto addSolids = [&](const char* name, const Shape& shape,
                               const std::vector<std::byte>& png) {
        if (shape.indices.empty())
            return Failure();
        return glb.addMesh(name, shape,
                           glb.addMaterial(name, glb.addTexture(png, "image/png", true), false));
    };
    if (auto error = addSolids("houses", shapes.houses, pictures.houses))
        return *error;
    if (auto error = addSolids("offices", shapes.offices, pictures.offices))
        return *error;
    if (!shapes.sheds.indices.empty())
        if (auto error = glb.addMesh("sheds", shapes.sheds, glb.addMaterial("sheds", -1, true)))
            return *error;

    TileBytes out;
    if (!shapes.trees.empty()) {
        const int material = glb.addMaterial("trees", -1, false);
        // Country that ends two levels early is never seen from near.
        const bool simple = levelsUp(plan, id) > 0 || id.level + 2 <= plan.levels();
        for (const auto& [kind, name] : {std::pair{TreeKind::Broad, "broad-leaved trees"},
                                         {TreeKind::Poplar, "poplars"},
                                         {TreeKind::Conifer, "conifers"}}) {
            const Shape tree = treeShape(kind, simple);
            const Instances where =
                instancesOf(plan, shapes.trees, kind, terrain.origin, rect.width() / kGridSquares);
            glb.addInstanced(name, tree, material, where);
            out.triangles += tree.triangles() * where.translations.size();
        }
    }
    out.triangles += terrain.triangles() + shapes.houses.triangles() + shapes.offices.triangles() +
                     shapes.sheds.triangles();
    out.buildings = shapes.buildings;
    out.trees = shapes.trees.size();
    out.sheds = shapes.shedCount;
    out.glb = glb.finish();
    return out;
}

} // namespace gnomon::builtin
