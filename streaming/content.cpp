#include "streaming/content.h"

#include "streaming/clean.h"
#include "streaming/gltf.h"
#include "streaming/gltf_document.h"
#include "streaming/split.h"

#include <nlohmann/json.hpp>

#include <algorithm>
#include <cstring>
#include <exception>

namespace gnomon {

namespace {

using Span = std::span<const std::byte>;
using Json = nlohmann::json;

struct B3dm {
    std::optional<glm::dvec3> rtcCenter;
    std::string batchTableJson;
    Bytes gltf; // copied: the glb inside need not be aligned
};

std::uint32_t word(Span b, std::size_t i) {
    return std::to_integer<std::uint32_t>(b[i]) | std::to_integer<std::uint32_t>(b[i + 1]) << 8 |
           std::to_integer<std::uint32_t>(b[i + 2]) << 16 |
           std::to_integer<std::uint32_t>(b[i + 3]) << 24;
}

// RTC_CENTER of a feature table: three numbers, or three floats in its binary part.
std::optional<glm::dvec3> rtcCenterOf(Span json, Span binary) {
    checkJsonDepth(json);
    const char* text = reinterpret_cast<const char*>(json.data());
    const Json table =
        json.empty() ? Json::object() : Json::parse(text, text + json.size(), nullptr, false);
    if (!table.is_object()) {
        throw BadContent{"b3dm: malformed feature table"};
    }
    const auto it = table.find("RTC_CENTER");
    if (it == table.end()) {
        return {};
    }
    const auto isNumber = [](const Json& v) { return v.is_number(); };
    if (it->is_array() && it->size() == 3 && std::all_of(it->begin(), it->end(), isNumber)) {
        return glm::dvec3((*it)[0].get<double>(), (*it)[1].get<double>(), (*it)[2].get<double>());
    }
    const auto offset = it->is_object() ? it->find("byteOffset") : it->end();
    float values[3];
    if (it->is_object() && offset != it->end() && offset->is_number_unsigned() &&
        binary.size() >= sizeof values &&
        offset->get<std::uint64_t>() <= binary.size() - sizeof values) {
        std::memcpy(values, binary.data() + offset->get<std::uint64_t>(), sizeof values);
        return glm::dvec3(values[0], values[1], values[2]);
    }
    throw BadContent{"b3dm: malformed RTC_CENTER"};
}

B3dm readB3dm(Span bytes) {
    constexpr std::size_t kHeader = 28;
    // Two older headers had 20 and 24 bytes. Read as today's, what follows them (JSON's '{"' or
    // glTF's magic) gives a length no table has: at least this.
    constexpr std::uint32_t kNoLength = 570425344;
    if (bytes.size() < kHeader) {
        throw BadContent{"b3dm header cut short"};
    }
    if (word(bytes, 4) != 1) {
        throw BadContent{"b3dm of version " + std::to_string(word(bytes, 4)) +
                         "; only 1 is supported"};
    }
    const std::uint32_t whole = word(bytes, 8);
    if (whole > bytes.size()) {
        throw BadContent{"b3dm says it has " + std::to_string(whole) + " bytes, but only " +
                         std::to_string(bytes.size()) + " are there"};
    }
    std::uint64_t header = kHeader;
    std::uint64_t lengths[4] = {word(bytes, 12), word(bytes, 16), word(bytes, 20), word(bytes, 24)};
    if (lengths[2] >= kNoLength) { // batch length, batch table JSON
        header = 20;
        lengths[2] = lengths[1];
        lengths[0] = lengths[1] = lengths[3] = 0;
    } else if (lengths[3] >= kNoLength) { // batch table JSON, batch table binary, batch length
        header = 24;
        lengths[2] = lengths[0];
        lengths[3] = lengths[1];
        lengths[0] = lengths[1] = 0;
    }
    const std::uint64_t start = header + lengths[0] + lengths[1] + lengths[2] + lengths[3];
    if (start > whole) {
        throw BadContent{"b3dm whose tables are longer than the file"};
    }
    if (start == whole) {
        throw BadContent{"b3dm without a glTF inside"};
    }
    const auto part = [&](int index) {
        std::uint64_t offset = header;
        for (int i = 0; i < index; ++i) {
            offset += lengths[i];
        }
        return bytes.subspan(std::size_t(offset), std::size_t(lengths[index]));
    };
    B3dm out;
    out.rtcCenter = rtcCenterOf(part(0), part(1));
    const Span table = part(2);
    out.batchTableJson.assign(reinterpret_cast<const char*>(table.data()), table.size());
    const Span inside = bytes.subspan(std::size_t(start), std::size_t(whole - start));
    out.gltf.assign(inside.begin(), inside.end());
    return out;
}

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
    for (const char* known : {"i3dm", "pnts", "cmpt", "vctr", "geom", "subt"}) {
        if (startsWith(bytes, known)) {
            return std::string(known) + " content is not supported";
        }
    }
    if (bytes.empty()) {
        return "empty file";
    }
    if (bytes.size() >= 2 && bytes[0] == std::byte(0x1f) && bytes[1] == std::byte(0x8b)) {
        return "compressed with gzip, which a tile's content must not be on disk";
    }
    return "neither b3dm, glb nor glTF";
}

// A megabyte may not become more than half a gigabyte; large files have earned more.
std::uint64_t budgetFor(std::size_t inputBytes, std::size_t maxBytes) {
    constexpr std::uint64_t kBase = std::uint64_t(320) << 20, kEachByte = 64;
    return std::min<std::uint64_t>(maxBytes, kBase + kEachByte * inputBytes);
}

TileContent decode(Span bytes, const DecodeOptions& options) {
    TileContent content;
    B3dm b3dm;
    Span gltf = bytes;
    if (startsWith(bytes, "b3dm")) {
        content.facts.format = "b3dm";
        b3dm = readB3dm(bytes);
        gltf = b3dm.gltf;
        if (!startsWith(gltf, "glTF") && !looksLikeJson(gltf)) {
            throw BadContent{"b3dm with something other than glTF inside"};
        }
        content.batchTableJson = std::move(b3dm.batchTableJson);
    } else if (startsWith(bytes, "glTF")) {
        content.facts.format = "glb";
    } else if (looksLikeJson(bytes)) {
        content.facts.format = "gltf";
    } else {
        throw BadContent{describeFormat(bytes)};
    }

    ByteBudget budget(budgetFor(bytes.size(), options.maxBytes));
    GltfContent read = readGltf(gltf, options, b3dm.rtcCenter, budget);
    const CleanSoup cleaned = clean(read.soup, options.ecefFromTile);
    content.meshes = split(read.soup, cleaned, options.ecefFromTile, options.meshAxes);
    content.materials = std::move(read.materials);
    content.images = std::move(read.images);

    ContentFacts& facts = content.facts;
    facts.triangles = cleaned.triangles.size();
    facts.duplicates = cleaned.duplicates;
    facts.degenerate = cleaned.degenerate;
    facts.invalid = cleaned.invalid;
    facts.closedTriangles = cleaned.closedTriangles;
    facts.components = cleaned.components;
    facts.closedComponents = cleaned.closedComponents;
    facts.extensions = std::move(read.extensions);
    facts.copyright = std::move(read.copyright);
    facts.warnings = std::move(read.warnings);
    facts.areaVector = cleaned.areaVector;
    return content;
}

} // namespace

Result<TileContent> decodeContent(std::span<const std::byte> bytes, const std::string& name,
                                  const DecodeOptions& options) {
    try {
        return decode(bytes, options);
    } catch (const BadContent& bad) {
        return Error{name, bad.reason};
    } catch (const std::bad_alloc&) {
        return Error{name, "does not fit into memory"};
    } catch (const std::exception& e) {
        return Error{name, std::string("cannot be decoded: ") + e.what()};
    }
}

} // namespace gnomon
