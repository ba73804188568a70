#include "bench/streaming_made.h"

#include "bench/scenes.h"
#include "viewer/place/glb.h"
#include "viewer/place/tiles.h"

#include <meshoptimizer.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <span>

namespace gnomon::bench {
namespace {

using builtin::Shape;
using Json = nlohmann::json;

// Little-endian, as all of these formats are, and as are the machines this runs on.
template <class T>
void put(Bytes& out, const T& value) {
    const auto* from = reinterpret_cast<const std::byte*>(&value);
    out.insert(out.end(), from, from + sizeof(T));
}
template <class T>
void putAll(Bytes& out, const std::vector<T>& values) {
    const auto* from = reinterpret_cast<const std::byte*>(values.data());
    out.insert(out.end(), from, from + values.size() * sizeof(T));
}
void putText(Bytes& out, const std::string& text) {
    const auto* from = reinterpret_cast<const std::byte*>(text.data());
    out.insert(out.end(), from, from + text.size());
}
void pad(Bytes& out, std::size_t to, char with) {
    while (out.size() % to != 0)
        out.push_back(std::byte(with));
}
std::string padded(std::string text, std::size_t to) {
    text.resize((text.size() + to - 1) / to * to, ' ');
    return text;
}

// b3dm, i3dm and pnts: a header, a feature table, no batch table, a body.
Bytes tileFile(const char* magic, const Json& features, const Bytes& binary, const Bytes& body,
               std::optional<std::uint32_t> gltfFormat = {}) {
    const std::size_t header = gltfFormat ? 32 : 28;
    const std::string table =
        padded(features.dump(), 8) + (gltfFormat ? "" : "    "); // the body starts 8-aligned
    Bytes out;
    putText(out, magic);
    put(out, std::uint32_t(1));
    put(out, std::uint32_t(header + table.size() + binary.size() + body.size()));
    put(out, std::uint32_t(table.size()));
    put(out, std::uint32_t(binary.size()));
    put(out, std::uint32_t(0));
    put(out, std::uint32_t(0));
    if (gltfFormat)
        put(out, *gltfFormat);
    putText(out, table);
    out.insert(out.end(), binary.begin(), binary.end());
    out.insert(out.end(), body.begin(), body.end());
    return out;
}

Bytes asB3dm(const Bytes& glb) {
    return tileFile("b3dm", {{"BATCH_LENGTH", 0}}, {}, glb);
}

Bytes asComposite(const std::vector<const Bytes*>& parts) {
    std::size_t bytes = 16;
    for (const Bytes* part : parts)
        bytes += part->size();
    Bytes out;
    putText(out, "cmpt");
    put(out, std::uint32_t(1));
    put(out, std::uint32_t(bytes));
    put(out, std::uint32_t(parts.size()));
    for (const Bytes* part : parts)
        out.insert(out.end(), part->begin(), part->end());
    return out;
}

Bytes asPoints(const Shape& shape) {
    Bytes binary;
    for (const glm::dvec3& p : shape.positions)
        put(binary, glm::vec3(p));
    const Json features = {{"POINTS_LENGTH", shape.positions.size()},
                           {"POSITION", {{"byteOffset", 0}}},
                           {"CONSTANT_RGBA", {200, 180, 160, 255}}};
    return tileFile("pnts", features, binary, {});
}

Bytes asInstances(const std::vector<builtin::Tree>& trees) {
    builtin::Glb glb;
    const int bark = glb.addMaterial("tree", -1, false);
    glb.addPlainMesh("tree", builtin::treeShape(builtin::TreeKind::Broad, false), bark);
    Bytes positions, scales;
    for (const builtin::Tree& tree : trees) {
        put(positions, glm::vec3(tree.at.x, tree.at.y, 0.0f));
        put(scales, float(tree.heightMetres));
    }
    const Json features = {{"INSTANCES_LENGTH", trees.size()},
                           {"POSITION", {{"byteOffset", 0}}},
                           {"SCALE", {{"byteOffset", positions.size()}}}};
    positions.insert(positions.end(), scales.begin(), scales.end());
    pad(positions, 8, 0);
    return tileFile("i3dm", features, positions, glb.finish(), 1);
}

// ------------------------------------------------------------------------------------------------
// EXT_meshopt_compression.

class MeshoptGlb {
  public:
    explicit MeshoptGlb(const Shape& shape) {
        std::vector<glm::vec3> positions;
        for (const glm::dvec3& p : shape.positions)
            positions.push_back(builtin::yUp(shape.origin + p));
        std::vector<glm::vec3> normals;
        for (const glm::vec3& n : shape.normals)
            normals.push_back(builtin::yUp(glm::dvec3(n)));
        const int position = attribute(positions), normal = attribute(normals);
        glm::vec3 low = positions.front(), high = low;
        for (const glm::vec3& p : positions) {
            low = glm::min(low, p);
            high = glm::max(high, p);
        }
        root_["accessors"][std::size_t(position)]["min"] = {low.x, low.y, low.z};
        root_["accessors"][std::size_t(position)]["max"] = {high.x, high.y, high.z};
        const int index = triangles(shape.indices, positions.size());
        root_["meshes"] = Json::array(
            {{{"primitives",
               Json::array({{{"attributes", {{"POSITION", position}, {"NORMAL", normal}}},
                             {"indices", index}}})}}});
    }

    Bytes finish() {
        root_["asset"] = {{"version", "2.0"}};
        root_["scene"] = 0;
        root_["scenes"] = Json::array({{{"nodes", {0}}}});
        root_["nodes"] = Json::array({{{"mesh", 0}}});
        root_["extensionsUsed"] = root_["extensionsRequired"] = {kExtension};
        pad(binary_, 4, 0);
        root_["buffers"] = Json::array(
            {{{"byteLength", binary_.size()}},
             {{"byteLength", unpacked_}, {"extensions", {{kExtension, {{"fallback", true}}}}}}});
        const std::string json = padded(root_.dump(), 4);
        Bytes out;
        putText(out, "glTF");
        put(out, std::uint32_t(2));
        put(out, std::uint32_t(12 + 8 + json.size() + 8 + binary_.size()));
        put(out, std::uint32_t(json.size()));
        putText(out, "JSON" + json);
        put(out, std::uint32_t(binary_.size()));
        putText(out, std::string("BIN\0", 4));
        putAll(out, binary_);
        return out;
    }

  private:
    static constexpr const char* kExtension = "EXT_meshopt_compression";

    int view(const std::vector<unsigned char>& packed, std::size_t count, std::size_t stride,
             const char* mode) {
        pad(binary_, 4, 0);
        Json entry = {{"buffer", 1}, {"byteOffset", unpacked_}, {"byteLength", count * stride}};
        if (std::string(mode) == "ATTRIBUTES")
            entry["byteStride"] = stride;
        entry["extensions"][kExtension] = {{"buffer", 0},
                                           {"byteOffset", binary_.size()},
                                           {"byteLength", packed.size()},
                                           {"byteStride", stride},
                                           {"count", count},
                                           {"mode", mode}};
        root_["bufferViews"].push_back(std::move(entry));
        putAll(binary_, packed);
        unpacked_ += count * stride;
        return int(root_["bufferViews"].size()) - 1;
    }
    int accessor(int bufferView, int componentType, std::size_t count, const char* type) {
        root_["accessors"].push_back({{"bufferView", bufferView},
                                      {"componentType", componentType},
                                      {"count", count},
                                      {"type", type}});
        return int(root_["accessors"].size()) - 1;
    }
    int attribute(const std::vector<glm::vec3>& values) {
        constexpr std::size_t kStride = sizeof(glm::vec3);
        std::vector<unsigned char> packed(meshopt_encodeVertexBufferBound(values.size(), kStride));
        packed.resize(meshopt_encodeVertexBuffer(packed.data(), packed.size(), values.data(),
                                                 values.size(), kStride));
        constexpr int kFloat = 5126;
        return accessor(view(packed, values.size(), kStride, "ATTRIBUTES"), kFloat, values.size(),
                        "VEC3");
    }
    int triangles(const std::vector<std::uint32_t>& indices, std::size_t vertices) {
        std::vector<unsigned char> packed(meshopt_encodeIndexBufferBound(indices.size(), vertices));
        packed.resize(meshopt_encodeIndexBuffer(packed.data(), packed.size(), indices.data(),
                                                indices.size()));
        constexpr int kUnsignedInt = 5125;
        return accessor(view(packed, indices.size(), sizeof(std::uint32_t), "TRIANGLES"),
                        kUnsignedInt, indices.size(), "SCALAR");
    }

    Json root_;
    Bytes binary_;
    std::size_t unpacked_ = 0;
};

// ------------------------------------------------------------------------------------------------
// Quantized mesh 1.0.

constexpr int kMostUnits = 32767; // of u, v and height

void putDeltas(Bytes& out, const std::vector<int>& values) {
    int before = 0;
    for (const int value : values) {
        const int delta = value - before;
        put(out, std::uint16_t((delta << 1) ^ (delta >> 31)));
        before = value;
    }
}

// Vertices renumbered by their first use, as high-water coding needs them.
struct Grid {
    std::vector<std::uint32_t> indices;
    std::vector<std::uint32_t> order; // of each vertex, its place in the grid
    std::vector<std::uint32_t> now;   // and the other way round
};

Grid gridOf(int side) {
    constexpr std::uint32_t kNone = 0xffffffffu;
    Grid grid;
    grid.now.assign(std::size_t(side + 1) * std::size_t(side + 1), kNone);
    const auto at = [&](int i, int j) { return std::uint32_t(j * (side + 1) + i); };
    for (int j = 0; j < side; ++j)
        for (int i = 0; i < side; ++i)
            for (const std::uint32_t v : {at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j),
                                          at(i + 1, j + 1), at(i, j + 1)}) {
                if (grid.now[v] == kNone) {
                    grid.now[v] = std::uint32_t(grid.order.size());
                    grid.order.push_back(v);
                }
                grid.indices.push_back(grid.now[v]);
            }
    return grid;
}

struct Extent {
    double west = 0, south = 0, side = 0; // degrees
    Point<Ecef> at(double u, double v, double height) const {
        return ecefOf({west + side * u, south + side * v, height});
    }
};

void putHeader(Bytes& out, const Extent& extent, float lowest, float highest) {
    const Point<Ecef> centre = extent.at(0.5, 0.5, 0.0);
    double radius = 0.0;
    for (const double u : {0.0, 1.0})
        for (const double v : {0.0, 1.0})
            radius = std::max(radius, length(extent.at(u, v, double(highest)) - centre));
    for (const double part : {centre.xyz.x, centre.xyz.y, centre.xyz.z})
        put(out, part);
    put(out, lowest);
    put(out, highest);
    for (const double part : {centre.xyz.x, centre.xyz.y, centre.xyz.z, radius})
        put(out, part);
    // Where the tile is hidden by the horizon; nobody here asks.
    for (const double part : {centre.xyz.x, centre.xyz.y, centre.xyz.z})
        put(out, part / kEquatorialRadiusMetres);
}

} // namespace

Result<std::vector<MadeFiles>> makeTiles(std::size_t tiles) {
    const builtin::Plan plan(1, 400);
    std::vector<MadeFiles> out = {{"glb", {}},  {"glb, Draco", {}}, {"glb, meshopt", {}},
                                  {"b3dm", {}}, {"i3dm", {}},       {"pnts", {}},
                                  {"cmpt", {}}};
    enum { Plain, Draco, Meshopt, B3dm, I3dm, Pnts, Cmpt };
    const int level = plan.levels(), across = 1 << level;
    for (int n = 0; n < across * across && out[Plain].files.size() < tiles; ++n) {
        const builtin::TileShapes shapes =
            builtin::tileShapes(plan, {level, n % across, n / across});
        if (shapes.houses.indices.empty() || shapes.trees.empty())
            continue;
        builtin::Glb plain, draco;
        plain.addPlainMesh("houses", shapes.houses, plain.addMaterial("wall", -1, false));
        if (Failure wrong =
                draco.addMesh("houses", shapes.houses, draco.addMaterial("wall", -1, false)))
            return *wrong;
        out[Plain].files.push_back(plain.finish());
        out[Draco].files.push_back(draco.finish());
        out[Meshopt].files.push_back(MeshoptGlb(shapes.houses).finish());
        out[B3dm].files.push_back(asB3dm(out[Plain].files.back()));
        out[I3dm].files.push_back(asInstances(shapes.trees));
        out[Pnts].files.push_back(asPoints(shapes.houses));
        out[Cmpt].files.push_back(asComposite({&out[B3dm].files.back(), &out[I3dm].files.back()}));
    }
    return out;
}

MadeTerrain makeTerrainTile() {
    constexpr int kSide = 256, kLevel = 12;
    const double degrees = 180.0 / (1 << kLevel);
    const auto x = int((kDefaultPlace.longitudeDegrees + 180.0) / degrees);
    const auto y = int((kDefaultPlace.latitudeDegrees + 90.0) / degrees);
    const Extent extent{x * degrees - 180.0, y * degrees - 90.0, degrees};
    const Grid grid = gridOf(kSide);
    std::vector<int> u, v, height;
    for (const std::uint32_t place : grid.order) {
        const int i = int(place) % (kSide + 1), j = int(place) / (kSide + 1);
        u.push_back(kMostUnits * i / kSide);
        v.push_back(kMostUnits * j / kSide);
        const double hills = std::sin(i * 0.07) * std::cos(j * 0.05) + 0.2 * std::sin(i * 0.9 + j);
        height.push_back(int(kMostUnits * (0.5 + 0.4 * hills)));
    }
    Bytes out;
    putHeader(out, extent, 100.0f, 400.0f);
    put(out, std::uint32_t(u.size()));
    for (const auto* values : {&u, &v, &height})
        putDeltas(out, *values);
    pad(out, 4, 0); // more than 65,536 vertices: indices of 32 bits
    put(out, std::uint32_t(grid.indices.size() / 3));
    std::uint32_t highest = 0;
    for (const std::uint32_t i : grid.indices) {
        put(out, highest - i);
        highest += i == highest;
    }
    for (const int side : {0, 1, 2, 3}) { // west, south, east, north
        put(out, std::uint32_t(kSide + 1));
        for (int k = 0; k <= kSide; ++k) {
            const int i = side == 0 ? 0 : side == 2 ? kSide : k;
            const int j = side == 1 ? 0 : side == 3 ? kSide : k;
            put(out, grid.now[std::size_t(j * (kSide + 1) + i)]);
        }
    }
    return {std::to_string(kLevel) + "/" + std::to_string(x) + "/" + std::to_string(y) + ".terrain",
            std::move(out)};
}

} // namespace gnomon::bench
