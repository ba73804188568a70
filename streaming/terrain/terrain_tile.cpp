#include "streaming/terrain/terrain_patch.h"
#include "streaming/terrain/terrain_texture.h"

#include <glm/common.hpp>

#include <cmath>
#include <limits>

namespace gnomon {

namespace {

constexpr std::uint32_t kNone = 0xffffffffu;
// Meshes are not cut below this many cells a side: 2048 triangles are worth a draw.
constexpr int kSmallestMeshCells = 32;

// sRGB to linear.
glm::vec4 linear(const glm::vec3& color) {
    const auto one = [](float c) {
        return c <= 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f);
    };
    return {one(color.r), one(color.g), one(color.b), 1.0f};
}

// Corners of a cell; a b above, c d below, the diagonal from b to c.
struct Corners {
    glm::ivec2 a, b, c, d;
    Corners(int column, int row)
        : a(column, row), b(column + 1, row), c(column, row + 1), d(column + 1, row + 1) {}
};

enum class Side { Left, Right, Above, Below };

class TileMaker {
  public:
    TileMaker(const TerrainScene& scene, const TileName& name, const TerrainPatch& patch,
              const DecodeOptions& options)
        : scene_(scene), data_(*scene.data), name_(name), patch_(patch),
          axes_(options.meshAxes.value_or(glm::dmat3(1.0))), stored_(glm::transpose(axes_)),
          clockwise_(!data_.raster.rowsRunSouth()),
          lattice_(scene.lattice[std::size_t(std::max(name.level, 0))]) {}

    Result<TileContent> make() {
        TileContent content;
        if (const Failure wrong = setLook(content))
            return *wrong;
        for (const Side side : {Side::Left, Side::Right, Side::Above, Side::Below})
            hangs_[std::size_t(side)] = hangs(side);
        const int cells = meshCells();
        for (int row = 0; row < patch_.cells.y; row += cells)
            for (int column = 0; column < patch_.cells.x; column += cells)
                if (Mesh mesh = makeMesh({column, row},
                                         glm::min(glm::ivec2(column, row) + cells, patch_.cells),
                                         content.facts);
                    !mesh.indices.empty())
                    content.meshes.push_back(std::move(mesh));
        content.facts.format = "terrain";
        content.facts.triangles = triangles_;
        return content;
    }

  private:
    Failure setLook(TileContent& content) {
        Material material;
        material.unlit = data_.look == TerrainLook::RampUnlit;
        material.wrapS = material.wrapT = Wrap::ClampToEdge;
        const bool draped =
            !scene_.drapes.empty() && scene_.isDraped(scene_.boxOf(name_.level, name_.tile));
        if (draped) {
            texels_ = scene_.texelsOf(name_.level, name_.tile).count;
            Result<Image> image = paintTile(scene_, name_, patch_, texels_);
            if (!image)
                return image.error();
            content.images.push_back(std::move(*image));
        } else if (data_.look != TerrainLook::Plain) {
            content.images.push_back(rampImage());
            rampTexels_ = content.images.back().width;
        } else {
            material.baseColor = linear(kTerrainColor);
        }
        material.image = content.images.empty() ? -1 : 0;
        content.materials.push_back(material);
        return {};
    }

    int meshCells() const {
        int cells = TerrainScene::cellsOf(name_.level);
        while (cells > kSmallestMeshCells &&
               cells * data_.cellMetres(std::max(name_.level, 0)) > kMaxMeshExtentMetres)
            cells /= 2;
        return cells;
    }

    glm::dvec3 onLattice(const glm::dvec3& ecef) const {
        return glm::round(stored_ * ecef / lattice_) * lattice_;
    }

    glm::vec2 uvOf(int column, int row) const {
        if (texels_.x > 0) {
            const auto share = [](const std::vector<double>& lines, int before, int cells, int i) {
                const double first = lines[std::size_t(before)];
                const double last = lines[std::size_t(before + cells)];
                return (lines[std::size_t(before + i)] - first) / (last - first);
            };
            return {
                texelShare(share(patch_.columns, patch_.before.x, patch_.cells.x, column),
                           texels_.x),
                texelShare(share(patch_.rows, patch_.before.y, patch_.cells.y, row), texels_.y)};
        }
        const double range = std::max(data_.highest - data_.lowest, 1e-9);
        const double h = double(patch_.heights[patch_.index(column, row)]);
        return {texelShare(std::clamp((h - data_.lowest) / range, 0.0, 1.0), rampTexels_), 0.5f};
    }

    // How far below a side the skirt hangs: to where the tile next to it can be, be it drawn at
    // its own level or, while the camera is far from it, at that of one above it. A tile so much
    // coarser is as far off as the error it may show allows: not worse than about twice our
    // parent's, which was too bad here, or this share of the way to it.
    double skirtDepth(Side side) const {
        constexpr double kErrorShare = 0.02;
        const int level = std::max(name_.level, 0);
        glm::ivec2 own = name_.tile, step(0);
        step[side == Side::Above || side == Side::Below ? 1 : 0] =
            side == Side::Left || side == Side::Above ? -1 : 1;
        glm::ivec2 next = own + step;
        if (name_.level < 0) {
            own = own / (1 << -name_.level);
            next = glm::ivec2(glm::floor(glm::dvec2(next) / double(1 << -name_.level)));
        }
        const double least = 4.0 * lattice_;
        if (own == next)
            return least;
        const glm::ivec2 count = data_.levels.tiles(level);
        if (next.x < 0 || next.y < 0 || next.x >= count.x || next.y >= count.y)
            return least; // the raster ends there
        const double nextError = data_.heightError(level, next);
        double worst = nextError;
        const int top = data_.levels.top();
        glm::ivec2 a = own / 2, b = next / 2;
        for (int l = level + 1; l <= top && a != b; ++l, a = a / 2, b = b / 2)
            worst = std::max(worst, data_.heightError(l, b));
        double limit = nextError;
        if (level < top)
            limit = std::max({limit, 2.0 * data_.heightError(level + 1, own / 2),
                              kErrorShare * kTileCells * data_.cellMetres(level + 1)});
        return least + data_.heightError(level, own) + std::min(worst, limit);
    }

    // A mesh in the making: vertices of the grid are shared within it.
    struct Building {
        Mesh mesh;
        glm::ivec2 first, last;
        std::vector<std::uint32_t> vertexOf;
        std::vector<glm::dvec3> positions; // on the lattice
    };

    std::uint32_t vertex(Building& b, glm::ivec2 at) const {
        std::uint32_t& v =
            b.vertexOf[std::size_t(at.y - b.first.y) * std::size_t(b.last.x - b.first.x + 1) +
                       std::size_t(at.x - b.first.x)];
        if (v == kNone) {
            v = std::uint32_t(b.positions.size());
            b.positions.push_back(onLattice(patch_.positions[patch_.index(at.x, at.y)]));
            b.mesh.normals.push_back(encodeOct(stored_ * patch_.normal(at.x, at.y)));
            if (texels_.x > 0 || rampTexels_ > 0)
                b.mesh.uvs.push_back(uvOf(at.x, at.y));
        }
        return v;
    }

    void addTriangle(Building& b, glm::ivec2 p, glm::ivec2 q, glm::ivec2 r,
                     glm::dvec3& areaVector) {
        if (!patch_.draws(p, q, r))
            return;
        if (clockwise_)
            std::swap(q, r);
        const std::uint32_t i = vertex(b, p), j = vertex(b, q), k = vertex(b, r);
        const glm::dvec3 area =
            0.5 * glm::cross(b.positions[j] - b.positions[i], b.positions[k] - b.positions[i]);
        const double size = glm::length(area);
        if (!(size > 0.0))
            return;
        b.mesh.indices.insert(b.mesh.indices.end(), {i, j, k});
        b.mesh.faceNormals.push_back(encodeOct(area / size));
        areaVector += axes_ * area;
        ++triangles_;
    }

    // The tile's two vertices p, q on a side, the third corner of its own triangle there, and of
    // the one on the other side, in the next tile.
    struct Edge {
        glm::ivec2 p, q, own, beyond;
    };
    static Edge edgeOf(Side side, glm::ivec2 cells, int i) {
        switch (side) {
        case Side::Above: { // a b of the cell's upper triangle; beyond: d's neighbour up
            return {{i, 0}, {i + 1, 0}, {i, 1}, {i + 1, -1}};
        }
        case Side::Below:
            return {{i, cells.y}, {i + 1, cells.y}, {i + 1, cells.y - 1}, {i, cells.y + 1}};
        case Side::Left:
            return {{0, i}, {0, i + 1}, {1, i}, {-1, i + 1}};
        case Side::Right:
            break;
        }
        return {{cells.x, i}, {cells.x, i + 1}, {cells.x - 1, i + 1}, {cells.x + 1, i}};
    }

    bool meetsNext(Side side, int i) const {
        const Edge edge = edgeOf(side, patch_.cells, i);
        return patch_.draws(edge.p, edge.q, edge.own) && patch_.draws(edge.p, edge.q, edge.beyond);
    }

    // How far the skirt hangs at each of a side's vertices. Towards the end of the ground, where
    // one could look under it from outside, it rises.
    std::vector<double> hangs(Side side) const {
        constexpr double kSlope = 0.25; // nothing shows from more than 14° above the horizon
        const bool across = side == Side::Above || side == Side::Below;
        const int cells = across ? patch_.cells.x : patch_.cells.y;
        const double step = kSlope * data_.cellMetres(std::max(name_.level, 0));
        std::vector<double> out(std::size_t(cells) + 1, skirtDepth(side));
        double room = out[0];
        // Segment i lies between vertices i and i + 1; those beyond the corners are the next
        // tiles'.
        const auto limit = [&](int vertex) {
            const bool ends = !meetsNext(side, vertex - 1) || !meetsNext(side, vertex);
            room = ends ? 0.0 : room + step;
            double& hang = out[std::size_t(vertex)];
            hang = std::max(std::min(hang, room), 4.0 * lattice_);
        };
        for (int i = 0; i <= cells; ++i)
            limit(i);
        room = out.back();
        for (int i = cells; i >= 0; --i)
            limit(i);
        return out;
    }

    void addSkirts(Building& b) {
        for (const Side side : {Side::Left, Side::Right, Side::Above, Side::Below}) {
            const bool across = side == Side::Above || side == Side::Below;
            const int axis = across ? 1 : 0, along = across ? 0 : 1;
            const bool near = side == Side::Left || side == Side::Above;
            const bool atSide = near ? b.first[axis] == 0 : b.last[axis] == patch_.cells[axis];
            if (!atSide)
                continue;
            std::vector<std::uint32_t> hanging(std::size_t(b.last[along] - b.first[along] + 1),
                                               kNone);
            for (int i = b.first[along]; i < b.last[along]; ++i)
                if (meetsNext(side, i)) // the rim of a hole, or of the raster, hides nothing
                    addSkirt(b, side, i, &hanging[std::size_t(i - b.first[along])]);
        }
    }

    // Two triangles below segment i of a side; `hanging`: the lower vertices at its ends.
    void addSkirt(Building& b, Side side, int i, std::uint32_t* hanging) {
        const Edge edge = edgeOf(side, patch_.cells, i);
        const auto below = [&](glm::ivec2 p, int end) {
            std::uint32_t& v = hanging[end];
            if (v == kNone) {
                const std::uint32_t top = vertex(b, p);
                const PlacedPixel& place = patch_.places[patch_.index(p.x, p.y)];
                const double hang = hangs_[std::size_t(side)][std::size_t(i + end)];
                v = std::uint32_t(b.positions.size());
                b.positions.push_back(onLattice(place.ecefAt(place.heightMetres - hang).xyz));
                b.mesh.normals.push_back(b.mesh.normals[top]);
                if (!b.mesh.uvs.empty())
                    b.mesh.uvs.push_back(b.mesh.uvs[top]);
            }
            return v;
        };
        const std::uint32_t p = vertex(b, edge.p), q = vertex(b, edge.q), r = vertex(b, edge.own);
        glm::dvec3 face =
            glm::cross(b.positions[q] - b.positions[p], b.positions[r] - b.positions[p]);
        const glm::dvec3 up = stored_ * patch_.places[patch_.index(edge.p.x, edge.p.y)].up;
        face = glm::normalize(glm::dot(face, up) < 0.0 ? -face : face);
        const std::uint32_t p2 = below(edge.p, 0), q2 = below(edge.q, 1);
        b.mesh.indices.insert(b.mesh.indices.end(), {p, q, q2, p, q2, p2});
        b.mesh.faceNormals.insert(b.mesh.faceNormals.end(), 2, encodeOct(face));
        b.mesh.skirtTriangles += 2;
    }

    Mesh makeMesh(glm::ivec2 first, glm::ivec2 last, ContentFacts& facts) {
        Building b;
        b.first = first;
        b.last = last;
        b.vertexOf.assign(std::size_t(last.x - first.x + 1) * std::size_t(last.y - first.y + 1),
                          kNone);
        for (int row = first.y; row < last.y; ++row)
            for (int column = first.x; column < last.x; ++column) {
                const Corners at(column, row);
                addTriangle(b, at.a, at.c, at.b, facts.areaVector);
                addTriangle(b, at.b, at.c, at.d, facts.areaVector);
            }
        if (b.mesh.indices.empty())
            return {};
        addSkirts(b);
        finish(b);
        return std::move(b.mesh);
    }

    // Box and floats, about an origin on the lattice: what is subtracted there is exact.
    void finish(Building& b) const {
        const glm::dvec3 middle = b.positions.front();
        const glm::dmat3 enu =
            stored_ * ecefFromEnu(geodeticOf(Point<Ecef>{axes_ * middle})).axes();
        glm::dvec3 low(std::numeric_limits<double>::infinity()), high = -low;
        for (const glm::dvec3& p : b.positions) {
            const glm::dvec3 local = glm::transpose(enu) * (p - middle);
            low = glm::min(low, local);
            high = glm::max(high, local);
        }
        const glm::dvec3 centre = middle + enu * (0.5 * (low + high));
        const glm::dvec3 origin = glm::round(centre / lattice_) * lattice_;
        Mesh& mesh = b.mesh;
        mesh.origin = Point<Ecef>{axes_ * origin};
        for (const glm::dvec3& p : b.positions) {
            mesh.positions.emplace_back(p - origin);
            mesh.radiusMetres = std::max(mesh.radiusMetres, glm::length(p - origin));
        }
        const glm::dmat3 ecef = axes_ * enu;
        const glm::dvec3 half = 0.5 * (high - low) + lattice_;
        mesh.box = {Point<Ecef>{axes_ * centre},
                    glm::dmat3(ecef[0] * half.x, ecef[1] * half.y, ecef[2] * half.z)};
        mesh.material = 0;
        mesh.indices.shrink_to_fit();
        mesh.faceNormals.shrink_to_fit();
        mesh.normals.shrink_to_fit();
        mesh.uvs.shrink_to_fit();
        mesh.positions.shrink_to_fit();
    }

    const TerrainScene& scene_;
    const TerrainData& data_;
    const TileName& name_;
    const TerrainPatch& patch_;
    glm::dmat3 axes_, stored_;
    bool clockwise_; // of columns and rows: the raster is stored from the south
    double lattice_;
    glm::ivec2 texels_{0, 0};
    int rampTexels_ = 0;
    std::array<std::vector<double>, 4> hangs_; // by side and vertex
    std::uint64_t triangles_ = 0;
};

} // namespace

Result<TileContent> makeTerrainTile(const TerrainScene& scene, const TileName& name,
                                    const DecodeOptions& options) {
    const Result<TerrainPatch> patch = makePatch(scene, name);
    if (!patch)
        return patch.error();
    return TileMaker(scene, name, *patch, options).make();
}

} // namespace gnomon
