#include "streaming/terrain/quantized_mesh_tile.h"

#include "streaming/soup.h"
#include "streaming/terrain/gzip.h"
#include "streaming/terrain/layer_json.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <exception>

namespace gnomon {

namespace {

using Span = std::span<const std::byte>;
using Json = nlohmann::json;

static_assert(std::endian::native == std::endian::little, "tiles are little-endian");

constexpr std::size_t kHeaderBytes = 88; // before the count of vertices
constexpr std::uint32_t kMostShortIndices = 65536;
constexpr std::size_t kMostUnpackedBytes = std::size_t(128) << 20;
// Deeper than the ocean's trenches and higher than any mountain by far; what lies outside is no
// height but a mistake.
constexpr double kMostHeightMetres = 1e6;

enum ExtensionId : std::uint8_t { OctNormals = 1, WaterMask = 2, Metadata = 4 };

class Reader {
  public:
    explicit Reader(Span bytes) : bytes_(bytes) {}

    std::size_t left() const { return bytes_.size() - at_; }
    Span take(std::uint64_t count, std::uint64_t bytesEach, const char* what) {
        if (count > left() / bytesEach)
            throw BadContent{"cut short in its " + std::string(what) + ": " +
                             std::to_string(count) + " of " + std::to_string(bytesEach) +
                             " bytes each are said to follow, but only " + std::to_string(left()) +
                             " bytes do"};
        const Span out = bytes_.subspan(at_, std::size_t(count * bytesEach));
        at_ += out.size();
        return out;
    }
    template <class T>
    T number(const char* what) {
        T out;
        std::memcpy(&out, take(1, sizeof(T), what).data(), sizeof(T));
        return out;
    }
    void align(std::size_t to, const char* what) {
        if (at_ % to != 0)
            take(to - at_ % to, 1, what);
    }

  private:
    Span bytes_;
    std::size_t at_ = 0;
};

glm::dvec3 vectorOf(Reader& in) {
    const double x = in.number<double>("header"), y = in.number<double>("header");
    return {x, y, in.number<double>("header")};
}

QuantizedHeader readHeader(Reader& in) {
    if (in.left() < kHeaderBytes)
        throw BadContent{"is no tile of a quantized mesh: shorter than its header"};
    QuantizedHeader h;
    h.centre = vectorOf(in);
    h.minHeightMetres = double(in.number<float>("header"));
    h.maxHeightMetres = double(in.number<float>("header"));
    h.sphereCentre = vectorOf(in);
    h.sphereRadiusMetres = in.number<double>("header");
    vectorOf(in); // where the horizon hides it: for a culling of another kind
    const bool heights = std::abs(h.minHeightMetres) <= kMostHeightMetres &&
                         std::abs(h.maxHeightMetres) <= kMostHeightMetres;
    if (!heights || h.minHeightMetres > h.maxHeightMetres)
        throw BadContent{"is no tile of a quantized mesh: heights from " +
                         std::to_string(h.minHeightMetres) + " to " +
                         std::to_string(h.maxHeightMetres)};
    return h;
}

// Differences to the vertex before, the sign in the lowest bit.
void readCoordinate(Reader& in, std::uint32_t count, std::vector<std::uint16_t>& out) {
    const Span bytes = in.take(count, 2, "vertices");
    out.resize(count);
    std::int32_t value = 0;
    std::int32_t outside = 0;
    for (std::size_t i = 0; i < count; ++i) {
        std::uint16_t code;
        std::memcpy(&code, bytes.data() + 2 * i, 2);
        value += (code >> 1) ^ -(code & 1);
        // A sum over millions of vertices could overflow; what is outside is refused below.
        outside |= value & ~kQuantizedMost;
        value &= 0xffff;
        out[i] = std::uint16_t(value);
    }
    if (outside != 0)
        throw BadContent{"has a vertex outside of its own extent"};
}

// Each code counts down from the highest index so far: 0 is the next new vertex.
template <class Index>
void readIndices(Reader& in, std::uint64_t count, std::uint32_t vertices,
                 std::vector<std::uint32_t>& out) {
    const Span bytes = in.take(count, sizeof(Index), "triangles");
    out.resize(std::size_t(count));
    std::uint32_t highest = 0;
    bool wrong = false;
    for (std::size_t i = 0; i < count; ++i) {
        Index code;
        std::memcpy(&code, bytes.data() + sizeof(Index) * i, sizeof(Index));
        const std::uint32_t index = highest - code; // wraps around for codes too large
        wrong = wrong || index >= vertices;
        highest += code == 0;
        out[i] = index;
    }
    if (wrong)
        throw BadContent{"has a triangle of a vertex that is not there (of " +
                         std::to_string(vertices) + ")"};
}

template <class Index>
std::size_t readEdges(Reader& in, std::uint32_t vertices) {
    std::size_t all = 0;
    for (int side = 0; side < 4; ++side) {
        const std::uint32_t count = in.number<std::uint32_t>("edges");
        const Span bytes = in.take(count, sizeof(Index), "edges");
        for (std::size_t i = 0; i < count; ++i) {
            Index index;
            std::memcpy(&index, bytes.data() + sizeof(Index) * i, sizeof(Index));
            if (index >= vertices)
                throw BadContent{"has an edge of a vertex that is not there (" +
                                 std::to_string(index) + " of " + std::to_string(vertices) + ")"};
        }
        all += count;
    }
    return all;
}

// Its length once more, then JSON.
void readMetadata(Span bytes, QuantizedTile& tile) {
    Reader in(bytes);
    const Span text = in.take(in.number<std::uint32_t>("metadata"), 1, "metadata");
    const Json json = parsedJson(text);
    if (!json.is_object()) {
        tile.warnings.push_back("its metadata is no JSON object and was not read");
        return;
    }
    if (const auto it = json.find("available"); it != json.end() && it->is_array()) {
        std::size_t wrong = 0;
        tile.availableBelow = tileRanges(*it, wrong);
        if (wrong > 0)
            tile.warnings.push_back(std::to_string(wrong) +
                                    " ranges of tiles in its metadata are wrong and left out");
    }
    if (const auto it = json.find("geometricerror"); it != json.end() && it->is_number()) {
        const double error = it->get<double>();
        if (std::isfinite(error) && error >= 0.0)
            tile.geometricErrorMetres = error;
    }
}

void readExtension(std::uint8_t id, Span bytes, std::size_t vertices, QuantizedTile& tile) {
    if (id == OctNormals) {
        if (bytes.size() != 2 * vertices) {
            tile.warnings.push_back("its normals are " + std::to_string(bytes.size()) +
                                    " bytes for " + std::to_string(vertices) +
                                    " vertices and were made from its triangles");
            return;
        }
        tile.extensions.push_back("octvertexnormals");
        tile.normals.resize(vertices);
        if (vertices > 0)
            std::memcpy(tile.normals.data(), bytes.data(), bytes.size());
    } else if (id == WaterMask) {
        tile.extensions.push_back("watermask");
        tile.waterMaskBytes = bytes.size();
    } else if (id == Metadata) {
        tile.extensions.push_back("metadata");
        readMetadata(bytes, tile);
    } else {
        tile.extensions.push_back("unknown extension " + std::to_string(id));
    }
}

void readExtensions(Reader& in, std::size_t vertices, QuantizedTile& tile) {
    while (in.left() > 0) {
        const std::uint8_t id = in.number<std::uint8_t>("extensions");
        std::uint32_t length = in.number<std::uint32_t>("extensions");
        // An early server wrote lengths with the highest byte first.
        const std::uint32_t turned = __builtin_bswap32(length);
        if (length > in.left() && turned <= in.left()) {
            length = turned;
            tile.warnings.push_back("an extension's length has its bytes in the wrong order");
        }
        readExtension(id, in.take(length, 1, "extensions"), vertices, tile);
    }
}

// Triangles that face down, in tiles that are heights above a plane, are wound wrongly.
void turnTriangles(QuantizedTile& tile) {
    std::size_t turned = 0;
    for (std::size_t i = 0; i + 2 < tile.indices.size(); i += 3) {
        const std::uint32_t a = tile.indices[i], b = tile.indices[i + 1], c = tile.indices[i + 2];
        const std::int64_t ux = tile.u[b] - tile.u[a], uy = tile.v[b] - tile.v[a];
        const std::int64_t vx = tile.u[c] - tile.u[a], vy = tile.v[c] - tile.v[a];
        if (ux * vy < uy * vx) {
            std::swap(tile.indices[i + 1], tile.indices[i + 2]);
            ++turned;
        }
    }
    if (turned > 0)
        tile.warnings.push_back(std::to_string(turned) + " triangles faced down and were turned");
}

struct Counts {
    std::uint32_t vertices = 0, triangles = 0;
    bool longIndices = false;
};

// Of a megabyte no more than half a gigabyte may come: from the file to meshes a vertex takes
// about 200 bytes, a triangle 120.
void checkSize(const Counts& counts, std::size_t bytes) {
    constexpr std::uint64_t kBase = std::uint64_t(320) << 20, kEachByte = 64;
    ByteBudget budget(kBase + kEachByte * bytes);
    budget.take(counts.vertices, 200, "its vertices");
    budget.take(counts.triangles, 120, "its triangles");
}

// `fileBytes`: as many as the file has, packed or not.
QuantizedTile decode(Span bytes, std::size_t fileBytes, bool summaryOnly) {
    QuantizedTile tile;
    Reader in(bytes);
    tile.header = readHeader(in);
    Counts counts;
    counts.vertices = in.number<std::uint32_t>("vertices");
    counts.longIndices = counts.vertices > kMostShortIndices;
    const std::uint64_t indexBytes = counts.longIndices ? 4 : 2;
    if (summaryOnly) {
        in.take(counts.vertices, 6, "vertices");
    } else {
        checkSize(counts, fileBytes);
        readCoordinate(in, counts.vertices, tile.u);
        readCoordinate(in, counts.vertices, tile.v);
        readCoordinate(in, counts.vertices, tile.height);
    }
    in.align(std::size_t(indexBytes), "triangles");
    counts.triangles = in.number<std::uint32_t>("triangles");
    const std::uint64_t corners = std::uint64_t(counts.triangles) * 3;
    if (summaryOnly) {
        in.take(corners, indexBytes, "triangles");
        for (int side = 0; side < 4; ++side)
            in.take(in.number<std::uint32_t>("edges"), indexBytes, "edges");
    } else {
        checkSize(counts, fileBytes);
        if (counts.longIndices) {
            readIndices<std::uint32_t>(in, corners, counts.vertices, tile.indices);
            tile.edgeVertices = readEdges<std::uint32_t>(in, counts.vertices);
        } else {
            readIndices<std::uint16_t>(in, corners, counts.vertices, tile.indices);
            tile.edgeVertices = readEdges<std::uint16_t>(in, counts.vertices);
        }
        turnTriangles(tile);
    }
    readExtensions(in, counts.vertices, tile);
    return tile;
}

Result<QuantizedTile> read(Span bytes, const std::string& name, bool summaryOnly) {
    try {
        if (!isGzip(bytes))
            return decode(bytes, bytes.size(), summaryOnly);
        const Result<Bytes> unpacked = gunzip(bytes, kMostUnpackedBytes, name);
        if (!unpacked)
            return unpacked.error();
        return decode(*unpacked, bytes.size(), summaryOnly);
    } catch (const BadContent& bad) {
        return Error{name, bad.reason};
    } catch (const std::bad_alloc&) {
        return Error{name, "does not fit into memory"};
    } catch (const std::exception& e) {
        return Error{name, std::string("cannot be decoded: ") + e.what()};
    }
}

} // namespace

Result<QuantizedTile> decodeQuantizedTile(std::span<const std::byte> bytes,
                                          const std::string& name) {
    return read(bytes, name, false);
}

Result<QuantizedSummary> readQuantizedSummary(std::span<const std::byte> bytes,
                                              const std::string& name) {
    Result<QuantizedTile> tile = read(bytes, name, true);
    if (!tile)
        return tile.error();
    return QuantizedSummary{tile->header, std::move(tile->availableBelow),
                            tile->geometricErrorMetres};
}

} // namespace gnomon
