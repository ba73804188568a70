#include "streaming/terrain/terrain_surface.h"

#include "streaming/terrain/terrain_data.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace gnomon {

namespace {

constexpr std::uint32_t kNone = 0xffffffffu;
// Fewer are not worth a mesh of their own; see kMaxMeshExtentMetres.
constexpr std::size_t kTrianglesAMesh = 1024;

// As encodeOct, of a vector of any length but zero, much faster: which of the four lattice points
// around it is nearest is told by the map's own metric there, not by trying all four.
OctNormal octOf(const glm::dvec3& v) {
    constexpr double kSnorm = 32767.0;
    const double ax = std::abs(v.x), ay = std::abs(v.y), az = std::abs(v.z);
    const double scale = kSnorm / (ax + ay + az);
    const double sx = std::copysign(1.0, v.x), sy = std::copysign(1.0, v.y);
    const bool below = v.z < 0.0;
    const double x = sx * (below ? kSnorm - ay * scale : ax * scale);
    const double y = sy * (below ? kSnorm - ax * scale : ay * scale);
    // Rounded down: of what is positive the fraction is cut off, which needs no call.
    const auto floored = [](double c) { return std::min(int(c + 32768.0) - 32768, 32766); };
    const int columnBefore = floored(x), rowBefore = floored(y);
    const double baseX = columnBefore, baseY = rowBefore;
    // Derivatives of the vector by x and by y; what of them lies along it changes no direction.
    const glm::dvec3 byX = below ? glm::dvec3(0.0, -sx * sy, -sx) : glm::dvec3(1.0, 0.0, -sx);
    const glm::dvec3 byY = below ? glm::dvec3(-sx * sy, 0.0, -sy) : glm::dvec3(0.0, 1.0, -sy);
    const double alongX = glm::dot(byX, v), alongY = glm::dot(byY, v);
    const double length2 = glm::dot(v, v);
    const double xx = 2.0 * length2 - alongX * alongX, yy = 2.0 * length2 - alongY * alongY;
    const double xy = sx * sy * length2 - alongX * alongY;
    const double fx = x - baseX, fy = y - baseY;
    const auto off = [&](double dx, double dy) {
        return xx * dx * dx + 2.0 * xy * dx * dy + yy * dy * dy;
    };
    const double o00 = off(fx, fy), o10 = off(fx - 1.0, fy);
    const double o01 = off(fx, fy - 1.0), o11 = off(fx - 1.0, fy - 1.0);
    const bool right0 = o10 < o00, right1 = o11 < o01;
    const bool up = (right1 ? o11 : o01) < (right0 ? o10 : o00);
    return {std::int16_t(columnBefore + ((up ? right1 : right0) ? 1 : 0)),
            std::int16_t(rowBefore + (up ? 1 : 0))};
}

struct Bounds {
    glm::dvec3 min{std::numeric_limits<double>::infinity()};
    glm::dvec3 max{-std::numeric_limits<double>::infinity()};
    void add(const glm::dvec3& p) {
        min = glm::min(min, p);
        max = glm::max(max, p);
    }
};

class Cutter {
  public:
    Cutter(const TerrainSurface& surface, const std::optional<glm::dmat3>& meshAxes)
        : surface_(surface), axes_(meshAxes.value_or(glm::dmat3(1.0))) {
        assert(surface.places.size() == surface.positions.size());
    }

    void run(TileContent& out) {
        turn();
        measureTriangles(out.facts);
        findCells();
        findSkirts();
        sort();
        inMesh_.assign(stored_.size(), kNone);
        lowered_.assign(stored_.size(), kNone);
        for (std::size_t cell = 0; cell + 1 < starts_.size(); ++cell)
            if (starts_[cell] < starts_[cell + 1])
                out.meshes.push_back(build(cell));
    }

  private:
    struct SkirtEdge {
        std::uint32_t a, b, cell;
    };

    // Positions from here on along the stored axes.
    void turn() {
        const glm::dmat3 storedFromEcef = glm::transpose(axes_);
        stored_.resize(surface_.positions.size());
        for (std::size_t i = 0; i < stored_.size(); ++i)
            stored_[i] = storedFromEcef * surface_.positions[i];
        normals_.resize(surface_.normals.empty() ? stored_.size() : 0, glm::dvec3(0.0));
    }

    void measureTriangles(ContentFacts& facts) {
        const bool makeNormals = surface_.normals.empty();
        const std::size_t count = surface_.indices.size() / 3;
        faces_.resize(count);
        cells_.assign(count, 0);
        glm::dvec3 sum(0.0);
        for (std::size_t t = 0; t < count; ++t) {
            const std::uint32_t a = corner(t, 0), b = corner(t, 1), c = corner(t, 2);
            const glm::dvec3 n = glm::cross(stored_[b] - stored_[a], stored_[c] - stored_[a]);
            if (!(glm::dot(n, n) > 0.0)) {
                ++facts.degenerate;
                cells_[t] = kNone;
                continue;
            }
            faces_[t] = octOf(n);
            ++triangles_;
            sum += n;
            if (makeNormals) {
                normals_[a] += n;
                normals_[b] += n;
                normals_[c] += n;
            }
        }
        facts.triangles += triangles_;
        facts.closedTriangles += triangles_;
        facts.areaVector += axes_ * (0.5 * sum);
    }

    // A grid over the tile, as fine as kMaxMeshExtentMetres where triangles are dense enough.
    void findCells() {
        constexpr double kMostCells = 64.0; // a side
        glm::dvec2 cells = glm::clamp(glm::ceil(surface_.sizeMetres / kMaxMeshExtentMetres),
                                      glm::dvec2(1.0), glm::dvec2(kMostCells));
        while (cells.x * cells.y > 1.0 &&
               cells.x * cells.y * double(kTrianglesAMesh) > double(triangles_)) {
            double& longer = cells.x >= cells.y ? cells.x : cells.y;
            longer = std::ceil(0.5 * longer);
        }
        columns_ = std::uint32_t(cells.x);
        rows_ = std::uint32_t(cells.y);
        if (columns_ * rows_ == 1)
            return;
        const glm::vec2 scale = glm::vec2(cells) / 3.0f;
        for (std::size_t t = 0; t < cells_.size(); ++t) {
            const glm::vec2 middle =
                scale * (surface_.places[corner(t, 0)] + surface_.places[corner(t, 1)] +
                         surface_.places[corner(t, 2)]);
            const auto cell = [](float at, std::uint32_t count) {
                return std::min(std::uint32_t(std::max(at, 0.0f)), count - 1);
            };
            if (cells_[t] != kNone)
                cells_[t] = cell(middle.y, rows_) * columns_ + cell(middle.x, columns_);
        }
    }

    // A border's edge hangs from the mesh of the triangle it belongs to. Most vertices begin no
    // edge or one.
    void findSkirts() {
        if (!(surface_.skirtMetres > 0.0))
            return;
        std::vector<std::uint32_t> next(stored_.size(), kNone);
        std::vector<std::array<std::uint32_t, 2>> more;
        for (const auto& [a, b] : surface_.borders)
            if (next[a] == kNone)
                next[a] = b;
            else
                more.push_back({a, b});
        std::sort(more.begin(), more.end());
        const auto hang = [&](std::uint32_t a, std::uint32_t b, std::uint32_t cell) {
            if (next[a] == kNone)
                return;
            if (next[a] == b || std::binary_search(more.begin(), more.end(), std::array{a, b}))
                skirts_.push_back({a, b, cell});
        };
        for (std::size_t t = 0; t < cells_.size(); ++t) {
            if (cells_[t] == kNone)
                continue;
            for (std::size_t k = 0; k < 3; ++k)
                hang(corner(t, k), corner(t, (k + 1) % 3), cells_[t]);
        }
    }

    // Triangles and skirts by cell, else in their order.
    void sort() {
        starts_.assign(std::size_t(columns_) * rows_ + 1, 0);
        for (const std::uint32_t cell : cells_)
            if (cell != kNone)
                ++starts_[cell + 1];
        for (std::size_t i = 1; i < starts_.size(); ++i)
            starts_[i] += starts_[i - 1];
        order_.resize(triangles_);
        std::vector<std::uint32_t> at(starts_.begin(), starts_.end() - 1);
        for (std::uint32_t t = 0; t < cells_.size(); ++t)
            if (cells_[t] != kNone)
                order_[at[cells_[t]]++] = t;
        std::stable_sort(skirts_.begin(), skirts_.end(),
                         [](const SkirtEdge& a, const SkirtEdge& b) { return a.cell < b.cell; });
    }

    std::uint32_t corner(std::size_t triangle, std::size_t k) const {
        return surface_.indices[3 * triangle + k];
    }
    OctNormal octNormal(std::uint32_t v) const {
        const glm::dvec3 n = surface_.normals.empty()
                                 ? normals_[v]
                                 : glm::transpose(axes_) * glm::dvec3(surface_.normals[v]);
        return glm::dot(n, n) > 0.0 ? octOf(n) : OctNormal{};
    }
    Mesh build(std::size_t cell);
    std::uint32_t vertex(std::uint32_t v) {
        std::uint32_t& in = inMesh_[v];
        if (in == kNone) {
            in = std::uint32_t(used_.size());
            used_.push_back(v);
        }
        return in;
    }
    void addSkirts(Mesh& mesh, std::size_t cell);
    void place(Mesh& mesh) const;

    const TerrainSurface& surface_;
    glm::dmat3 axes_;
    std::vector<glm::dvec3> stored_, normals_;
    std::size_t triangles_ = 0;        // that have an area
    std::vector<OctNormal> faces_;     // of each triangle
    std::vector<std::uint32_t> cells_; // likewise; kNone: dropped
    std::vector<std::uint32_t> order_; // triangles by cell
    std::vector<SkirtEdge> skirts_;
    std::size_t skirtsDone_ = 0;
    std::uint32_t columns_ = 1, rows_ = 1;
    std::vector<std::uint32_t> starts_;           // a cell's first in the order
    std::vector<std::uint32_t> inMesh_, lowered_; // a vertex's number in the mesh being built
    std::vector<std::uint32_t> used_, hung_;      // the mesh's vertices; those of skirts, above
    std::vector<glm::dvec3> below_;               // and the places they hang down to
};

Mesh Cutter::build(std::size_t cell) {
    Mesh mesh;
    used_.clear();
    hung_.clear();
    below_.clear();
    const std::size_t count = starts_[cell + 1] - starts_[cell];
    mesh.indices.resize(3 * count);
    mesh.faceNormals.resize(count);
    for (std::size_t i = 0; i < count; ++i) {
        const std::uint32_t t = order_[starts_[cell] + i];
        for (std::size_t k = 0; k < 3; ++k)
            mesh.indices[3 * i + k] = vertex(corner(t, k));
        mesh.faceNormals[i] = faces_[t];
    }
    mesh.closedTriangles = mesh.triangles(); // the Earth has an inside
    addSkirts(mesh, cell);
    place(mesh);
    for (const std::uint32_t v : used_)
        inMesh_[v] = kNone;
    for (const std::uint32_t v : hung_)
        lowered_[v] = kNone;
    return mesh;
}

void Cutter::addSkirts(Mesh& mesh, std::size_t cell) {
    const std::uint32_t top = std::uint32_t(used_.size());
    // Straight down the ellipsoid's normal, which is along (x, y, z a²/b²) of a place on it.
    constexpr double kFlat = (kEquatorialRadiusMetres * kEquatorialRadiusMetres) /
                             (kPolarRadiusMetres * kPolarRadiusMetres);
    const auto lower = [&](std::uint32_t v) {
        std::uint32_t& in = lowered_[v];
        if (in == kNone) {
            in = top + std::uint32_t(hung_.size());
            hung_.push_back(v);
            glm::dvec3 up = surface_.origin.xyz + surface_.positions[v];
            up.z *= kFlat;
            const glm::dvec3 down = -surface_.skirtMetres * glm::normalize(up);
            below_.push_back(stored_[v] + glm::transpose(axes_) * down);
        }
        return in;
    };
    const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c, OctNormal n) {
        mesh.indices.insert(mesh.indices.end(), {a, b, c});
        mesh.faceNormals.push_back(n);
        ++mesh.skirtTriangles;
    };
    for (; skirtsDone_ < skirts_.size() && skirts_[skirtsDone_].cell == cell; ++skirtsDone_) {
        const SkirtEdge& e = skirts_[skirtsDone_];
        const std::uint32_t a = inMesh_[e.a], b = inMesh_[e.b];
        const std::uint32_t lowA = lower(e.a), lowB = lower(e.b);
        const glm::dvec3 outward =
            glm::cross(stored_[e.b] - stored_[e.a], stored_[e.a] - below_[lowA - top]);
        const OctNormal n = glm::dot(outward, outward) > 0.0 ? octOf(outward) : OctNormal{};
        add(lowA, lowB, b, n);
        add(lowA, b, a, n);
    }
}

// Its vertices, about its middle, and its bounds.
void Cutter::place(Mesh& mesh) const {
    Bounds all;
    for (const std::uint32_t v : used_)
        all.add(stored_[v]);
    for (const glm::dvec3& p : below_)
        all.add(p);
    const glm::dvec3 middle = 0.5 * (all.min + all.max);
    mesh.origin = Point<Ecef>{surface_.origin.xyz + axes_ * middle};
    const std::size_t count = used_.size() + hung_.size();
    mesh.positions.reserve(count);
    mesh.normals.reserve(count);
    mesh.uvs.reserve(surface_.uvs.empty() ? 0 : count);
    for (const std::uint32_t v : used_)
        mesh.positions.push_back(glm::vec3(stored_[v] - middle));
    for (const glm::dvec3& p : below_)
        mesh.positions.push_back(glm::vec3(p - middle));
    for (const std::uint32_t v : used_)
        mesh.normals.push_back(octNormal(v));
    for (const std::uint32_t v : hung_) // seen, if at all, as part of the ground above
        mesh.normals.push_back(octNormal(v));
    if (!surface_.uvs.empty()) {
        for (const std::uint32_t v : used_)
            mesh.uvs.push_back(surface_.uvs[v]);
        for (const std::uint32_t v : hung_)
            mesh.uvs.push_back(surface_.uvs[v]);
    }
    const glm::dmat3 local = ecefFromEnu(geodeticOf(mesh.origin)).axes();
    const glm::dmat3 localFromStored = glm::transpose(local) * axes_;
    Bounds tight; // of the floats, not of what they were rounded from
    double farthest = 0.0;
    for (const glm::vec3& f : mesh.positions) {
        const glm::dvec3 p(f);
        tight.add(localFromStored * p);
        farthest = std::max(farthest, glm::dot(p, p));
    }
    const glm::dvec3 half = 0.5 * (tight.max - tight.min);
    mesh.box.centre = Point<Ecef>{mesh.origin.xyz + local * (0.5 * (tight.min + tight.max))};
    mesh.box.halfAxes = glm::dmat3(local[0] * half.x, local[1] * half.y, local[2] * half.z);
    mesh.radiusMetres = std::sqrt(farthest);
}

} // namespace

void addMeshes(TileContent& content, const TerrainSurface& surface, const DecodeOptions& options) {
    Cutter(surface, options.meshAxes).run(content);
    if (!content.meshes.empty())
        content.facts.components = content.facts.closedComponents = 1;
}

PictureNeed pictureNeed(std::span<const std::shared_ptr<const Drape>> drapes,
                        const std::array<double, 4>& extent, glm::dvec2 sizeMetres) {
    constexpr double kMostTexels = 1024.0; // a side: 4 MB a tile
    constexpr double kFewestTexels = 4.0;
    // Polygons have no texels of their own; this is what a kerb needs to be seen.
    constexpr double kPolygonTexelMetres = 0.25;
    // A tile is refined while its error covers more than --sse pixels, 8 to 16: so a texel that
    // stands for an error of so many of its own size is not seen much larger than a pixel.
    constexpr double kErrorATexel = 8.0;
    PictureNeed need;
    double finest = std::numeric_limits<double>::infinity();
    for (const auto& drape : drapes)
        if (overlap(drape->extent(), extent)) {
            need.drapes.push_back(drape);
            const double own = drape->texelMetres();
            finest = std::min(finest, std::isfinite(own) ? own : kPolygonTexelMetres);
        }
    if (need.drapes.empty())
        return need;
    const glm::dvec2 wanted = glm::ceil(sizeMetres / finest) + 1.0;
    const glm::dvec2 texels =
        glm::clamp(wanted, glm::dvec2(kFewestTexels), glm::dvec2(kMostTexels));
    need.texels = glm::ivec2(texels);
    constexpr double kGenerous = 1.25; // a texel this much larger than the drape's shows all
    const double coarse = std::max(sizeMetres.x / texels.x, sizeMetres.y / texels.y);
    if (coarse > kGenerous * finest)
        need.errorMetres = kErrorATexel * coarse;
    return need;
}

} // namespace gnomon
