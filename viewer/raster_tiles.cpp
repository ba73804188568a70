#include "viewer/raster_tiles.h"

#include "streaming/memory_source.h"
#include "streaming/terrain/raster.h"
#include "viewer/place/glb.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <limits>

namespace gnomon {

namespace {

using builtin::Shape;
using nlohmann::json;

// Cells along a block's side: 256 m, the extent of a mesh, where a cell is a metre.
constexpr int kBlockCells = 256;
constexpr glm::vec3 kTerrainColor{0.52f, 0.53f, 0.45f}; // sRGB; a calm grey-green

// Every n-th pixel of a raster, its places in the frame east, north, up at `origin`.
struct Grid {
    int columns = 0, rows = 0, step = 1;
    Geodetic origin;
    std::vector<glm::dvec3> points; // x is NaN where there is no data
    std::vector<glm::vec3> normals;

    std::size_t index(int column, int row) const {
        return std::size_t(row) * std::size_t(columns) + std::size_t(column);
    }
    bool has(std::size_t i) const { return !std::isnan(points[i].x); }
};

std::uint64_t trianglesOf(std::uint64_t columns, std::uint64_t rows) {
    return 2 * (columns - 1) * (rows - 1);
}

int countOf(int pixels, int step) {
    return (pixels - 1) / step + 1;
}

int stepFor(const Raster& raster, std::uint64_t most) {
    int step = 1;
    while (trianglesOf(std::uint64_t(countOf(raster.width(), step)),
                       std::uint64_t(countOf(raster.height(), step))) > most)
        ++step;
    return step;
}

// The middle of the raster on its lowest height: the frame's origin.
Result<Geodetic> originOf(const Raster& raster, const CrsToEcef& crs, float lowest) {
    const glm::dvec2 middle = raster.at(0.5 * raster.width(), 0.5 * raster.height());
    return crs.geodetic({middle, double(lowest)});
}

Result<std::vector<float>> readHeights(const Raster& raster, const Grid& grid) {
    std::vector<float> heights;
    heights.reserve(std::size_t(grid.columns) * std::size_t(grid.rows));
    for (int row = 0; row < grid.rows; ++row) {
        const Result<std::vector<float>> line = raster.read(0, row * grid.step, raster.width(), 1);
        if (!line)
            return line.error();
        for (int column = 0; column < grid.columns; ++column)
            heights.push_back((*line)[std::size_t(column * grid.step)]);
    }
    return heights;
}

Failure placePoints(const Raster& raster, const CrsToEcef& crs, const std::vector<float>& heights,
                    double raiseMetres, Grid& grid) {
    const Transform<Enu, Ecef> enuFromEcef = rigidInverse(ecefFromEnu(grid.origin));
    grid.points.reserve(heights.size());
    for (int row = 0; row < grid.rows; ++row)
        for (int column = 0; column < grid.columns; ++column) {
            const double height = double(heights[grid.points.size()]);
            if (std::isnan(height)) {
                grid.points.emplace_back(std::numeric_limits<double>::quiet_NaN());
                continue;
            }
            const glm::dvec2 p = raster.at(column * grid.step + 0.5, row * grid.step + 0.5);
            const Result<Point<Ecef>> place = crs({p, height + raiseMetres});
            if (!place)
                return place.error();
            grid.points.push_back(enuFromEcef(*place).xyz);
        }
    return {};
}

// Three corners of a cell's triangles each, counter-clockwise from above whichever way rows run.
template <class Visit>
void forTriangles(const Grid& grid, bool rowsRunSouth, int column0, int row0, int column1, int row1,
                  const Visit& visit) {
    for (int row = row0; row < row1; ++row)
        for (int column = column0; column < column1; ++column) {
            std::size_t a = grid.index(column, row), b = a + 1;
            std::size_t c = grid.index(column, row + 1), d = c + 1;
            if (!rowsRunSouth)
                std::swap(a, c), std::swap(b, d);
            // a b: the northern pair. The diagonal runs from c to b.
            if (grid.has(a) && grid.has(c) && grid.has(b))
                visit(a, c, b);
            if (grid.has(b) && grid.has(c) && grid.has(d))
                visit(b, c, d);
        }
}

void findNormals(Grid& grid, bool rowsRunSouth) {
    std::vector<glm::dvec3> sums(grid.points.size(), glm::dvec3(0.0));
    forTriangles(grid, rowsRunSouth, 0, 0, grid.columns - 1, grid.rows - 1,
                 [&](std::size_t a, std::size_t b, std::size_t c) {
                     const glm::dvec3 n = glm::cross(grid.points[b] - grid.points[a],
                                                     grid.points[c] - grid.points[a]);
                     for (const std::size_t i : {a, b, c})
                         sums[i] += n;
                 });
    for (const glm::dvec3& n : sums) {
        const double length = glm::length(n);
        grid.normals.push_back(length > 0.0 ? glm::vec3(n / length) : glm::vec3(0, 0, 1));
    }
}

// One block's triangles, about an origin so near and on a lattice so coarse that floats hold all
// its positions exactly: blocks meet without cracks.
struct Block {
    Shape shape;
    glm::dvec3 low{0.0}, high{0.0};
};

Block makeBlock(const Grid& grid, bool rowsRunSouth, int column0, int row0) {
    const int column1 = std::min(column0 + kBlockCells, grid.columns - 1);
    const int row1 = std::min(row0 + kBlockCells, grid.rows - 1);
    Block block;
    std::vector<std::uint32_t> vertexOf(
        std::size_t(column1 - column0 + 1) * std::size_t(row1 - row0 + 1), 0xffffffffu);
    const auto local = [&](std::size_t i) {
        const auto columns = std::size_t(grid.columns);
        return (i / columns - std::size_t(row0)) * std::size_t(column1 - column0 + 1) +
               (i % columns - std::size_t(column0));
    };
    Shape& shape = block.shape;
    shape.setColor(kTerrainColor);
    forTriangles(grid, rowsRunSouth, column0, row0, column1, row1,
                 [&](std::size_t a, std::size_t b, std::size_t c) {
                     for (const std::size_t i : {a, b, c}) {
                         std::uint32_t& vertex = vertexOf[local(i)];
                         if (vertex == 0xffffffffu) {
                             vertex = std::uint32_t(shape.positions.size());
                             shape.positions.push_back(grid.points[i]);
                             shape.normals.push_back(grid.normals[i]);
                             shape.colors.push_back(shape.color);
                         }
                         shape.indices.push_back(vertex);
                     }
                 });
    if (shape.positions.empty())
        return block;
    block.low = block.high = shape.positions.front();
    for (const glm::dvec3& p : shape.positions) {
        block.low = glm::min(block.low, p);
        block.high = glm::max(block.high, p);
    }
    return block;
}

// The finest power of two in metres that a float's 24 bits hold over `reach` to either side.
double latticeFor(double reach) {
    return std::ldexp(1.0, std::ilogb(std::max(reach, 1.0)) + 1 - 24);
}

json boxOf(const glm::dvec3& low, const glm::dvec3& high) {
    const glm::dvec3 c = 0.5 * (low + high);
    const glm::dvec3 h = glm::max(0.5 * (high - low), glm::dvec3(0.01)); // a lattice's rounding
    return {{"box", {c.x, c.y, c.z, h.x, 0, 0, 0, h.y, 0, 0, 0, h.z}}};
}

Bytes glbOf(Block& block, double lattice) {
    const glm::dvec3 origin = glm::round(0.5 * (block.low + block.high));
    for (glm::dvec3& p : block.shape.positions)
        p = glm::round((p - origin) / lattice) * lattice;
    builtin::Glb glb;
    glb.setOrigin(origin);
    glb.addPlainMesh("terrain", block.shape, glb.addMaterial("terrain", -1, false));
    return glb.finish();
}

Bytes bytesOf(const std::string& text) {
    Bytes bytes(text.size());
    std::memcpy(bytes.data(), text.data(), text.size());
    return bytes;
}

Result<std::shared_ptr<MemorySource>> makeSource(const std::string& name, Grid& grid,
                                                 bool rowsRunSouth) {
    std::vector<Block> blocks;
    double reach = 1.0;
    glm::dvec3 low(std::numeric_limits<double>::infinity()), high = -low;
    for (int row = 0; row + 1 < grid.rows; row += kBlockCells)
        for (int column = 0; column + 1 < grid.columns; column += kBlockCells) {
            Block block = makeBlock(grid, rowsRunSouth, column, row);
            if (block.shape.indices.empty())
                continue;
            low = glm::min(low, block.low);
            high = glm::max(high, block.high);
            const glm::dvec3 half = 0.5 * (block.high - block.low);
            reach = std::max({reach, half.x + 1.0, half.y + 1.0, half.z + 1.0});
            blocks.push_back(std::move(block));
        }
    if (blocks.empty())
        return Error{name, "has no data anywhere"};
    auto source = std::make_shared<MemorySource>(name);
    json root{{"refine", "ADD"}, {"boundingVolume", boxOf(low, high)}};
    root["geometricError"] = glm::length(high - low); // a root without content is always refined
    const glm::dmat4 m = ecefFromEnu(grid.origin).matrix;
    for (int i = 0; i < 16; ++i)
        root["transform"].push_back(m[i / 4][i % 4]);
    for (std::size_t i = 0; i < blocks.size(); ++i) {
        const std::string uri = "block" + std::to_string(i) + ".glb";
        root["children"].push_back({{"boundingVolume", boxOf(blocks[i].low, blocks[i].high)},
                                    {"geometricError", 0},
                                    {"content", {{"uri", uri}}}});
        source->add(uri, glbOf(blocks[i], latticeFor(reach)));
        blocks[i] = {}; // twice in memory is enough
    }
    const json tileset{{"asset", {{"version", "1.1"}}},
                       {"geometricError", root["geometricError"]},
                       {"root", root}};
    source->add("tileset.json", bytesOf(tileset.dump()));
    return source;
}

struct Described {
    CrsToEcef toEcef;
    std::string name;
};

Result<Described> systemOf(const Raster& raster, const std::string& path,
                           const PlacingOptions& placing) {
    if (!raster.crs() && !placing.crs)
        return Error{path, "does not name its coordinate reference system; give it with --crs "
                           "EPSG:n"};
    const std::string& text = raster.crs() ? *raster.crs() : *placing.crs;
    Result<CrsToEcef> crs = CrsToEcef::create(text, placing.heights);
    if (!crs)
        return Error{raster.crs() ? path : "--crs", crs.error().message(),
                     raster.crs() ? ErrorKind::Input : ErrorKind::Usage};
    return Described{std::move(*crs), raster.crs() ? raster.crsName() : *placing.crs};
}

Result<Grid> gridOf(const Raster& raster, const std::string& path, const CrsToEcef& crs,
                    double raiseMetres, std::uint64_t mostTriangles) {
    Grid grid;
    grid.step = stepFor(raster, mostTriangles);
    grid.columns = countOf(raster.width(), grid.step);
    grid.rows = countOf(raster.height(), grid.step);
    if (grid.columns < 2 || grid.rows < 2)
        return Error{path, "is too narrow for a surface, or far longer than wide"};
    const Result<std::vector<float>> heights = readHeights(raster, grid);
    if (!heights)
        return heights.error();
    float lowest = std::numeric_limits<float>::infinity();
    for (const float h : *heights)
        lowest = std::min(lowest, std::isnan(h) ? lowest : h);
    if (std::isinf(lowest))
        return Error{path, "has no data anywhere"};
    const Result<Geodetic> origin = originOf(raster, crs, lowest);
    if (!origin)
        return Error{path, origin.error().message()};
    grid.origin = *origin;
    grid.origin.heightMetres += raiseMetres;
    if (const Failure wrong = placePoints(raster, crs, *heights, raiseMetres, grid))
        return Error{path, wrong->message()};
    return grid;
}

// What was taken for granted, and what is not shown.
std::vector<Problem> notesOn(const Raster& raster, const std::string& path, Heights heights,
                             int step, std::uint64_t mostTriangles) {
    const bool egm96 = heights == Heights::Egm96;
    std::vector<Problem> notes;
    notes.push_back(
        {Problem::Severity::Note, path,
         std::string("taken for terrain: heights in metres above ") +
             (egm96 ? "sea level (EGM96)" : "the ellipsoid (--heights egm96 where it is the sea)") +
             ", unless its own system says otherwise"});
    if (step > 1) {
        char text[200];
        std::snprintf(text, sizeof text,
                      "shown by one pixel in %d x %d of its %d x %d: not more than %.3g million "
                      "triangles of a raster are drawn yet",
                      step, step, raster.width(), raster.height(), double(mostTriangles) / 1e6);
        notes.push_back({Problem::Severity::Note, path, text});
    }
    return notes;
}

} // namespace

Result<RasterTiles> rasterTiles(const std::string& path, const PlacingOptions& placing,
                                std::uint64_t mostTriangles) {
    const Result<Raster> raster = Raster::open(path);
    if (!raster)
        return raster.error();
    const Result<Described> system = systemOf(*raster, path, placing);
    if (!system)
        return system.error();
    Result<Grid> grid = gridOf(*raster, path, system->toEcef, placing.raiseMetres, mostTriangles);
    if (!grid)
        return grid.error();
    const glm::dvec2 across = raster->at(1, 0) - raster->at(0, 0);
    const glm::dvec2 down = raster->at(0, 1) - raster->at(0, 0);
    const bool rowsRunSouth = across.x * down.y - across.y * down.x < 0.0;
    findNormals(*grid, rowsRunSouth);
    const auto source = makeSource(path, *grid, rowsRunSouth);
    if (!source)
        return source.error();
    return RasterTiles{
        *source,          "tileset.json",
        system->name,     raster->width(),
        raster->height(), notesOn(*raster, path, placing.heights, grid->step, mostTriangles)};
}

} // namespace gnomon
