// Quantized meshes to read: a writer of tiles over a function of heights, a reader as plain as can
// be to hold the real one against, and folders of tiles.
#pragma once

#include "geo/ellipsoid.h"
#include "streaming/source.h"
#include "tests/streaming/drape_support.h"
#include "tests/streaming/gzipped.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <string>
#include <vector>

namespace gnomon {

inline std::string qmeshData(const std::string& name) {
    const char* folder = std::getenv("GNOMON_DATA");
    return (folder != nullptr ? std::string(folder)
                              : std::string(GNOMON_SOURCE_DIR) + "/../shared/data") +
           "/qmesh-cesium/" + name;
}

inline Bytes fileBytes(const std::string& path) {
    std::ifstream in(path, std::ios::binary);
    const std::string text((std::istreambuf_iterator<char>(in)), {});
    Bytes out(text.size());
    if (!text.empty())
        std::memcpy(out.data(), text.data(), text.size());
    return out;
}

inline void writeFile(const std::string& path, const Bytes& bytes) {
    std::filesystem::create_directories(std::filesystem::path(path).parent_path());
    std::ofstream(path, std::ios::binary)
        .write(reinterpret_cast<const char*>(bytes.data()), std::streamsize(bytes.size()));
}

inline void writeText(const std::string& path, const std::string& text) {
    std::filesystem::create_directories(std::filesystem::path(path).parent_path());
    std::ofstream(path) << text;
}

// A tile as it will be written; anything may be spoilt before that.
struct PlainTile {
    double centre[3] = {}, sphere[4] = {}, horizon[3] = {};
    float minHeight = 0, maxHeight = 0;
    std::vector<int> u, v, h;
    std::vector<std::uint32_t> indices;
    std::vector<std::uint32_t> edges[4]; // west, south, east, north
    struct Extension {
        std::uint8_t id;
        Bytes bytes;
    };
    std::vector<Extension> extensions;
};

class TileWriter {
  public:
    template <class T>
    TileWriter& put(const T& value) {
        const auto* from = reinterpret_cast<const std::byte*>(&value);
        out.insert(out.end(), from, from + sizeof(T));
        return *this;
    }
    Bytes out;
};

inline Bytes written(const PlainTile& tile) {
    TileWriter w;
    w.put(tile.centre).put(tile.minHeight).put(tile.maxHeight).put(tile.sphere).put(tile.horizon);
    w.put(std::uint32_t(tile.u.size()));
    for (const std::vector<int>* values : {&tile.u, &tile.v, &tile.h}) {
        int before = 0;
        for (const int value : *values) {
            const int d = value - before;
            w.put(std::uint16_t((d << 1) ^ (d >> 31)));
            before = value;
        }
    }
    const bool wide = tile.u.size() > 65536;
    while (wide && w.out.size() % 4 != 0)
        w.put(std::uint8_t(0));
    const auto index = [&](std::uint32_t i) {
        if (wide)
            w.put(i);
        else
            w.put(std::uint16_t(i));
    };
    w.put(std::uint32_t(tile.indices.size() / 3));
    std::uint32_t highest = 0;
    for (const std::uint32_t i : tile.indices) {
        index(highest - i);
        highest += i == highest;
    }
    for (const auto& edge : tile.edges) {
        w.put(std::uint32_t(edge.size()));
        for (const std::uint32_t i : edge)
            index(i);
    }
    for (const PlainTile::Extension& e : tile.extensions) {
        w.put(e.id).put(std::uint32_t(e.bytes.size()));
        w.out.insert(w.out.end(), e.bytes.begin(), e.bytes.end());
    }
    return w.out;
}

// High-water coding needs every vertex named in order first: renumbers them by their first use.
inline void renumber(PlainTile& tile) {
    std::vector<std::uint32_t> now(tile.u.size(), 0xffffffffu), order;
    for (std::uint32_t& i : tile.indices) {
        if (now[i] == 0xffffffffu) {
            now[i] = std::uint32_t(order.size());
            order.push_back(i);
        }
        i = now[i];
    }
    for (std::vector<int>* values : {&tile.u, &tile.v, &tile.h}) {
        std::vector<int> turned;
        for (const std::uint32_t i : order)
            turned.push_back((*values)[i]);
        *values = turned;
    }
    for (auto& edge : tile.edges)
        for (std::uint32_t& i : edge)
            i = now[i];
}

using HeightOf = std::function<double(double lon, double lat)>;

// A grid of (side + 1)² vertices over an extent of west, south, east, north degrees.
inline PlainTile gridTile(const std::array<double, 4>& extent, int side, const HeightOf& height) {
    PlainTile tile;
    std::vector<double> heights;
    for (int j = 0; j <= side; ++j)
        for (int i = 0; i <= side; ++i) {
            tile.u.push_back(32767 * i / side);
            tile.v.push_back(32767 * j / side);
            heights.push_back(
                height(extent[0] + (extent[2] - extent[0]) * tile.u.back() / 32767.0,
                       extent[1] + (extent[3] - extent[1]) * tile.v.back() / 32767.0));
        }
    tile.minHeight = float(*std::min_element(heights.begin(), heights.end())) - 1.0f;
    tile.maxHeight = float(*std::max_element(heights.begin(), heights.end())) + 1.0f;
    for (const double h : heights)
        tile.h.push_back(
            int(std::lround((h - double(tile.minHeight)) /
                            (double(tile.maxHeight) - double(tile.minHeight)) * 32767.0)));
    const auto at = [&](int i, int j) { return std::uint32_t(j * (side + 1) + i); };
    for (int j = 0; j < side; ++j)
        for (int i = 0; i < side; ++i)
            for (const std::uint32_t k : {at(i, j), at(i + 1, j), at(i, j + 1), at(i + 1, j),
                                          at(i + 1, j + 1), at(i, j + 1)})
                tile.indices.push_back(k);
    for (int k = 0; k <= side; ++k) {
        tile.edges[0].push_back(at(0, k));
        tile.edges[1].push_back(at(k, 0));
        tile.edges[2].push_back(at(side, k));
        tile.edges[3].push_back(at(k, side));
    }
    renumber(tile);
    const Point<Ecef> middle =
        ecefOf({0.5 * (extent[0] + extent[2]), 0.5 * (extent[1] + extent[3]), heights[0]});
    double radius = 0.0;
    for (std::size_t i = 0; i < tile.u.size(); ++i)
        radius = std::max(radius,
                          length(ecefOf({extent[0] + (extent[2] - extent[0]) * tile.u[i] / 32767.0,
                                         extent[1] + (extent[3] - extent[1]) * tile.v[i] / 32767.0,
                                         double(tile.minHeight) +
                                             (double(tile.maxHeight) - double(tile.minHeight)) *
                                                 tile.h[i] / 32767.0}) -
                                 middle));
    for (int axis = 0; axis < 3; ++axis)
        tile.centre[axis] = tile.sphere[axis] = middle.xyz[axis];
    tile.sphere[3] = radius;
    return tile;
}

inline Bytes textBytes(const std::string& text, bool withLength) {
    TileWriter w;
    if (withLength)
        w.put(std::uint32_t(text.size()));
    for (const char c : text)
        w.put(c);
    return w.out;
}

// As plain as can be, trusting every byte.
struct PlainlyRead {
    std::vector<int> u, v, h;
    std::vector<std::uint32_t> indices;
    std::vector<std::array<std::uint8_t, 2>> normals;
    std::size_t waterMask = 0;
    float minHeight = 0, maxHeight = 0;
};

inline PlainlyRead plainlyRead(const Bytes& bytes) {
    PlainlyRead out;
    std::size_t at = 0;
    const auto get = [&]<class T>(T) {
        T value;
        std::memcpy(&value, bytes.data() + at, sizeof(T));
        at += sizeof(T);
        return value;
    };
    at = 24;
    out.minHeight = get(0.0f);
    out.maxHeight = get(0.0f);
    at = 88;
    const std::uint32_t n = get(std::uint32_t(0));
    for (std::vector<int>* values : {&out.u, &out.v, &out.h}) {
        int value = 0;
        for (std::uint32_t i = 0; i < n; ++i) {
            const int code = get(std::uint16_t(0));
            value += code % 2 == 0 ? code / 2 : -(code + 1) / 2;
            values->push_back(value);
        }
    }
    if (n > 65536)
        at = (at + 3) / 4 * 4;
    const auto index = [&] {
        return n > 65536 ? get(std::uint32_t(0)) : std::uint32_t(get(std::uint16_t(0)));
    };
    const std::uint32_t triangles = get(std::uint32_t(0));
    std::uint32_t highest = 0;
    for (std::uint32_t i = 0; i < 3 * triangles; ++i) {
        const std::uint32_t code = index();
        out.indices.push_back(highest - code);
        if (code == 0)
            ++highest;
    }
    for (int side = 0; side < 4; ++side)
        for (std::uint32_t left = get(std::uint32_t(0)); left > 0; --left)
            index();
    while (at < bytes.size()) {
        const std::uint8_t id = get(std::uint8_t(0));
        const std::uint32_t length = get(std::uint32_t(0));
        if (length > bytes.size() - at)
            break; // the old server's lengths
        if (id == 1)
            for (std::uint32_t i = 0; i < n; ++i)
                out.normals.push_back(
                    {std::uint8_t(bytes[at + 2 * i]), std::uint8_t(bytes[at + 2 * i + 1])});
        if (id == 2)
            out.waterMask = length;
        at += length;
    }
    return out;
}

} // namespace gnomon
