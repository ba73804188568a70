// Builds small GLBs, b3dms and PNGs for the tests, byte by byte.
#pragma once

#include "streaming/content.h"

#include <nlohmann/json.hpp>

#include <array>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace gnomon::test {

using Json = nlohmann::json;

inline void put(std::string& out, std::uint32_t word) {
    for (int i = 0; i < 4; ++i) {
        out.push_back(char(word >> (8 * i) & 0xffu));
    }
}

inline Bytes bytesOf(const std::string& text) {
    const auto bytes = std::as_bytes(std::span(text));
    return Bytes(bytes.begin(), bytes.end());
}

class GlbBuilder {
  public:
    Json root = {{"asset", {{"version", "2.0"}}}};
    std::string bin;

    int view(const void* data, std::size_t bytes) {
        bin.resize((bin.size() + 3) / 4 * 4);
        const std::size_t offset = bin.size();
        bin.append(static_cast<const char*>(data), bytes);
        root["bufferViews"].push_back(
            {{"buffer", 0}, {"byteOffset", offset}, {"byteLength", bytes}});
        return int(root["bufferViews"].size()) - 1;
    }

    template <class T>
    int accessor(const std::vector<T>& values, int componentType, const std::string& type,
                 bool normalized = false) {
        const std::size_t components = type == "SCALAR" ? 1 : std::size_t(type.back() - '0');
        Json accessor = {{"bufferView", view(values.data(), values.size() * sizeof(T))},
                         {"componentType", componentType},
                         {"count", values.size() / components},
                         {"type", type}};
        if (normalized) {
            accessor["normalized"] = true;
        }
        root["accessors"].push_back(accessor);
        return int(root["accessors"].size()) - 1;
    }
    int floats(const std::vector<float>& values, const std::string& type) {
        return accessor(values, 5126, type);
    }
    int indices(const std::vector<std::uint32_t>& values) {
        return accessor(values, 5125, "SCALAR");
    }

    // A mesh of one primitive, and a node that shows it.
    int mesh(const Json& primitive) {
        root["meshes"].push_back({{"primitives", Json::array({primitive})}});
        return int(root["meshes"].size()) - 1;
    }
    void node(Json node) { root["nodes"].push_back(std::move(node)); }
    // Both for triangles given plainly.
    Json& triangles(const std::vector<float>& positions, const std::vector<std::uint32_t>& index) {
        const int position = floats(positions, "VEC3");
        const int m = mesh({{"attributes", {{"POSITION", position}}}, {"indices", indices(index)}});
        node({{"mesh", m}});
        return root["meshes"][std::size_t(m)]["primitives"][0];
    }

    std::string json() const {
        Json whole = root;
        if (!bin.empty()) {
            whole["buffers"] = Json::array({{{"byteLength", bin.size()}}});
        }
        return whole.dump();
    }
    std::string text() const { return glbOf(json(), bin); }
    Bytes glb() const { return bytesOf(text()); }

    static std::string glbOf(std::string json, std::string bin) {
        json.resize((json.size() + 3) / 4 * 4, ' ');
        bin.resize((bin.size() + 3) / 4 * 4);
        std::string out = "glTF";
        put(out, 2);
        put(out, std::uint32_t(20 + json.size() + (bin.empty() ? 0 : 8 + bin.size())));
        put(out, std::uint32_t(json.size()));
        out += "JSON" + json;
        if (!bin.empty()) {
            put(out, std::uint32_t(bin.size()));
            out += std::string("BIN\0", 4) + bin;
        }
        return out;
    }
};

inline std::string b3dmOf(const std::string& glb, const std::string& featureTable = "",
                          const std::string& batchTable = "",
                          const std::string& featureBinary = "") {
    std::string out = "b3dm";
    put(out, 1);
    put(out, std::uint32_t(28 + featureTable.size() + featureBinary.size() + batchTable.size() +
                           glb.size()));
    put(out, std::uint32_t(featureTable.size()));
    put(out, std::uint32_t(featureBinary.size()));
    put(out, std::uint32_t(batchTable.size()));
    put(out, 0);
    return out + featureTable + featureBinary + batchTable + glb;
}

// The corners of an axis-aligned box, and its 12 triangles wound outward.
inline std::vector<float> boxCorners(glm::vec3 from, glm::vec3 to) {
    std::vector<float> out;
    for (int i = 0; i < 8; ++i) {
        out.push_back(i & 1 ? to.x : from.x);
        out.push_back(i & 2 ? to.y : from.y);
        out.push_back(i & 4 ? to.z : from.z);
    }
    return out;
}
inline std::vector<std::uint32_t> boxTriangles(std::uint32_t first = 0) {
    std::vector<std::uint32_t> out = {0, 2, 3, 0, 3, 1, 4, 5, 7, 4, 7, 6, 0, 1, 5, 0, 5, 4,
                                      2, 6, 7, 2, 7, 3, 0, 4, 6, 0, 6, 2, 1, 3, 7, 1, 7, 5};
    for (std::uint32_t& i : out) {
        i += first;
    }
    return out;
}

template <class T>
std::vector<T> joined(std::vector<T> a, const std::vector<T>& b) {
    a.insert(a.end(), b.begin(), b.end());
    return a;
}

inline std::uint32_t crc32(const std::string& data) {
    std::uint32_t crc = 0xffffffffu;
    for (const char c : data) {
        crc ^= static_cast<unsigned char>(c);
        for (int k = 0; k < 8; ++k) {
            crc = crc & 1u ? 0xedb88320u ^ (crc >> 1) : crc >> 1;
        }
    }
    return ~crc;
}

inline void putBig(std::string& out, std::uint32_t word) {
    for (int shift = 24; shift >= 0; shift -= 8) {
        out.push_back(char(word >> shift & 0xffu));
    }
}

inline std::string pngChunk(const std::string& type, const std::string& data) {
    std::string out;
    putBig(out, std::uint32_t(data.size()));
    out += type + data;
    putBig(out, crc32(type + data));
    return out;
}

// 8-bit PNG, its data stored rather than deflated. `pixels` has `channels` bytes a pixel;
// `claimedWidth` is what the header says.
inline std::string pngOf(int width, int height, int channels, const std::string& pixels,
                         std::optional<int> claimedWidth = {}) {
    std::string raw;
    const std::size_t row = std::size_t(width) * std::size_t(channels);
    for (int y = 0; y < height; ++y) {
        raw.push_back(0);
        raw += pixels.substr(std::size_t(y) * row, row);
    }
    std::string data("\x78\x01\x01", 3); // one stored block: at most 65535 bytes
    data.push_back(char(raw.size() & 0xff));
    data.push_back(char(raw.size() >> 8));
    data.push_back(char(~raw.size() & 0xff));
    data.push_back(char(~raw.size() >> 8 & 0xff));
    data += raw;
    std::uint32_t a = 1, b = 0;
    for (const char c : raw) {
        a = (a + static_cast<unsigned char>(c)) % 65521;
        b = (b + a) % 65521;
    }
    putBig(data, b << 16 | a);
    std::string header;
    putBig(header, std::uint32_t(claimedWidth.value_or(width)));
    putBig(header, std::uint32_t(height));
    const std::array<char, 5> kinds{0, 0, 4, 2, 6};
    header += {8, kinds[std::size_t(channels)], 0, 0, 0};
    return "\x89PNG\r\n\x1a\n" + pngChunk("IHDR", header) + pngChunk("IDAT", data) +
           pngChunk("IEND", "");
}

// Content in ECEF's own axes, z up, no transform: what comes out is what went in.
inline DecodeOptions plain() {
    DecodeOptions options;
    options.gltfUpAxis = UpAxis::Z;
    return options;
}

inline Result<TileContent> decode(const std::string& text, const DecodeOptions& options = plain()) {
    return decodeContent(bytesOf(text), "tile", options);
}
inline Result<TileContent> decode(const GlbBuilder& builder,
                                  const DecodeOptions& options = plain()) {
    return decode(builder.text(), options);
}

inline glm::dvec3 vertex(const Mesh& mesh, std::size_t i) {
    return mesh.origin.xyz + glm::dvec3(mesh.positions[i]);
}

inline std::string dataFolder() {
    const char* given = std::getenv("GNOMON_DATA");
    return given ? given : std::string(GNOMON_SOURCE_DIR) + "/../shared/data";
}

inline std::optional<std::string> readData(const std::string& path) {
    std::ifstream file(dataFolder() + "/" + path, std::ios::binary);
    if (!file) {
        return {};
    }
    return std::string(std::istreambuf_iterator<char>(file), {});
}

} // namespace gnomon::test
