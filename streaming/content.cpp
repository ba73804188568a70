#include "streaming/content.h"

#include "streaming/batch_table.h"
#include "streaming/check_content.h"
#include "streaming/clean.h"
#include "streaming/gltf.h"
#include "streaming/i3dm.h"
#include "streaming/join_content.h"
#include "streaming/pnts.h"
#include "streaming/split.h"
#include "streaming/terrain/gzip.h"
#include "streaming/tile_headers.h"

#include <algorithm>
#include <cstring>
#include <exception>

namespace gnomon {

namespace {

using Span = std::span<const std::byte>;

constexpr int kMaxCompositeDepth = 8;

bool startsWith(Span bytes, const char* magic) {
    return bytes.size() >= 4 && std::memcmp(bytes.data(), magic, 4) == 0;
}

bool looksLikeJson(Span bytes) {
    if (bytes.size() >= 3 && std::memcmp(bytes.data(), "\xef\xbb\xbf", 3) == 0) {
        bytes = bytes.subspan(3);
    }
    const auto isSpace = [](std::byte b) {
        return b == std::byte(' ') || b == std::byte('\n') || b == std::byte('\r') ||
               b == std::byte('\t');
    };
    const auto first = std::find_if_not(bytes.begin(), bytes.end(), isSpace);
    return first != bytes.end() && *first == std::byte('{');
}

std::string describeFormat(Span bytes) {
    for (const char* known : {"vctr", "geom", "subt"}) {
        if (startsWith(bytes, known)) {
            return std::string(known) + " content is not supported";
        }
    }
    if (startsWith(bytes, "PK\x03\x04")) {
        return "a zip archive (3tz, slpk), which is not supported: unpack it first";
    }
    if (bytes.empty()) {
        return "empty file";
    }
    return "neither b3dm, i3dm, pnts, cmpt, glb nor glTF";
}

// A megabyte may not become more than half a gigabyte; large files have earned more.
std::uint64_t budgetFor(std::size_t inputBytes, std::size_t maxBytes) {
    constexpr std::uint64_t kBase = std::uint64_t(320) << 20, kEachByte = 64;
    return std::min<std::uint64_t>(maxBytes, kBase + kEachByte * inputBytes);
}

GltfContent readB3dm(const TileParts& parts, const DecodeOptions& options, ByteBudget& budget) {
    if (!startsWith(parts.body, "glTF") && !looksLikeJson(parts.body)) {
        throw BadContent{"b3dm with something other than glTF inside"};
    }
    const TileSemantics table(parts, budget);
    GltfContent out = readGltf(parts.body, options, table.vec3("RTC_CENTER"), budget);
    const std::uint32_t rows =
        parts.batchLength ? *parts.batchLength : table.count("BATCH_LENGTH").value_or(0);
    if (!out.features) { // what the glTF says itself is the newer way
        out.features =
            readBatchTable(parts.batchJson, parts.batchBinary, rows, out.warnings, budget);
    }
    return out;
}

// A vertex may name a row that its table does not have.
void dropUnknownRows(TileContent& content) {
    if (!content.features) {
        return;
    }
    const std::uint32_t rows = content.features->rows();
    for (Mesh& mesh : content.meshes) {
        std::replace_if(
            mesh.features.begin(), mesh.features.end(), [=](std::uint32_t f) { return f >= rows; },
            kNoFeature);
    }
}

// Triangles and points to meshes.
TileContent build(GltfContent read, const DecodeOptions& options, ByteBudget& budget) {
    TileContent content;
    const CleanSoup cleaned = clean(read.soup, options.ecefFromTile);
    content.meshes = split(read.soup, cleaned, options.ecefFromTile, options.meshAxes);
    content.facts = factsOf(cleaned);
    ContentFacts& facts = content.facts;
    if (!read.points.empty()) {
        PointSolids solids =
            solidsOf(std::move(read.points), options.ecefFromTile, options.meshAxes, budget);
        std::move(solids.meshes.begin(), solids.meshes.end(), std::back_inserter(content.meshes));
        facts.triangles += solids.triangles;
        facts.closedTriangles += solids.triangles;
        facts.invalid += solids.invalid;
        if (solids.leftOut > 0) {
            read.warnings.push_back(std::to_string(solids.leftOut) +
                                    " points left out: there is no memory for more in one tile");
        }
    }
    content.materials = std::move(read.materials);
    content.images = std::move(read.images);
    content.features = std::move(read.features);
    dropUnknownRows(content);
    facts.extensions = std::move(read.extensions);
    facts.copyright = std::move(read.copyright);
    facts.warnings = std::move(read.warnings);
    return content;
}

TileContent decode(Span bytes, const DecodeOptions& options, ByteBudget& budget, int depth);

TileContent decodeComposite(Span bytes, const DecodeOptions& options, ByteBudget& budget,
                            int depth) {
    if (depth >= kMaxCompositeDepth) {
        throw BadContent{"cmpt nested deeper than " + std::to_string(kMaxCompositeDepth)};
    }
    std::vector<TileContent> parts;
    for (const Span part : readComposite(bytes)) {
        budget.take(1, sizeof(TileContent) * 2, "cmpt");
        try {
            parts.push_back(decode(part, options, budget, depth + 1));
        } catch (const BadContent& bad) {
            throw BadContent{"part " + std::to_string(parts.size() + 1) +
                             " of the cmpt: " + bad.reason};
        }
    }
    return joinContents(std::move(parts), "cmpt");
}

TileContent decode(Span bytes, const DecodeOptions& options, ByteBudget& budget, int depth) {
    if (startsWith(bytes, "cmpt")) {
        return decodeComposite(bytes, options, budget, depth);
    }
    std::string format;
    GltfContent read;
    if (startsWith(bytes, "b3dm") || startsWith(bytes, "i3dm") || startsWith(bytes, "pnts")) {
        const TileParts parts = readTileParts(bytes);
        format = parts.format;
        read = format == "b3dm"   ? readB3dm(parts, options, budget)
               : format == "i3dm" ? readI3dm(parts, options, budget)
                                  : readPnts(parts, budget);
    } else if (startsWith(bytes, "glTF") || looksLikeJson(bytes)) {
        format = startsWith(bytes, "glTF") ? "glb" : "gltf";
        read = readGltf(bytes, options, {}, budget);
    } else {
        throw BadContent{describeFormat(bytes)};
    }
    TileContent content = build(std::move(read), options, budget);
    content.facts.format = format;
    return content;
}

TileContent decodeAny(Span bytes, const DecodeOptions& options) {
    ByteBudget budget(budgetFor(bytes.size(), options.maxBytes));
    if (!isGzip(bytes)) {
        return decode(bytes, options, budget, 0);
    }
    // Many a tileset lies on its disk as a web server would send it.
    const std::uint64_t most = std::min(budget.left(), mostUnpackedBytes(bytes.size()));
    const Result<Bytes> unpacked = gunzip(bytes, std::size_t(most), "");
    if (!unpacked) {
        throw BadContent{unpacked.error().reason};
    }
    budget.take(unpacked->size(), 1, "gzip");
    return decode(*unpacked, options, budget, 0);
}

// What a file calls things gets into reasons.
std::string inOneLine(std::string reason) {
    std::replace_if(
        reason.begin(), reason.end(), [](unsigned char c) { return c < ' ' || c == 0x7f; }, '?');
    constexpr std::size_t kLongest = 400;
    return reason.size() <= kLongest ? reason : reason.substr(0, kLongest) + "...";
}

} // namespace

Result<TileContent> decodeContent(std::span<const std::byte> bytes, const std::string& name,
                                  const DecodeOptions& options) {
    try {
        TileContent content = decodeAny(bytes, options);
        if (const auto broken = brokenPromise(content)) {
            return Error{name, *broken};
        }
        return content;
    } catch (const BadContent& bad) {
        return Error{name, inOneLine(bad.reason)};
    } catch (const std::bad_alloc&) {
        return Error{name, "does not fit into memory"};
    } catch (const std::exception& e) {
        return Error{name, inOneLine(std::string("cannot be decoded: ") + e.what())};
    }
}

} // namespace gnomon
