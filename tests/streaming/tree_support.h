// Small tilesets made in memory, for the tests of the tile tree and its loader.
#pragma once

#include "streaming/loader.h"

#include <atomic>
#include <cstring>
#include <map>
#include <mutex>
#include <thread>

namespace gnomon::testing {

inline Bytes bytesOf(std::string_view text) {
    const auto* data = reinterpret_cast<const std::byte*>(text.data());
    return {data, data + text.size()};
}

inline std::string number(double value) {
    char text[40];
    std::snprintf(text, sizeof text, "%.17g", value);
    return text;
}

// A box from (x0, 0, 0) to (x1, 100, 100).
inline std::string box(double x0, double x1) {
    return R"("boundingVolume":{"box":[)" + number((x0 + x1) / 2) + ",50,50," +
           number((x1 - x0) / 2) + ",0,0, 0,50,0, 0,0,50]}";
}

inline std::string tile(const std::string& volume, double error, const std::string& uri,
                        const std::string& children = {}, const std::string& more = {}) {
    std::string text = "{" + volume + R"(,"geometricError":)" + number(error);
    if (!uri.empty())
        text += R"(,"content":{"uri":")" + uri + "\"}";
    if (!children.empty())
        text += R"(,"children":[)" + children + "]";
    return text + (more.empty() ? "" : "," + more) + "}";
}

inline std::string tileset(const std::string& root, const std::string& more = {}) {
    return R"({"asset":{"version":"1.1"},"geometricError":1000,)" +
           (more.empty() ? "" : more + ",") + R"("root":)" + root + "}";
}

inline Result<TileTree> parse(const std::string& json, const std::string& path = "tileset.json") {
    return TileTree::parse(bytesOf(json), path, {});
}

// Sees everything; the error of a tile is judged from `eye`.
inline View viewFrom(double x, double y, double z, double pixelsPerRadian = 1000.0) {
    View view;
    view.eye = {{x, y, z}};
    view.forward = {{1, 0, 0}};
    view.pixelsPerRadian = pixelsPerRadian;
    return view;
}

// A glb of `triangles` separate triangles near the origin.
inline Bytes glb(unsigned triangles) {
    std::vector<float> positions;
    for (unsigned i = 0; i < triangles; ++i) {
        const float x = float(i) * 2.0f;
        positions.insert(positions.end(), {x, 0, 0, x + 1, 0, 0, x, 1, 0});
    }
    const std::size_t binary = positions.size() * sizeof(float);
    std::string json =
        R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],)"
        R"("meshes":[{"primitives":[{"attributes":{"POSITION":0}}]}],"buffers":[{"byteLength":)" +
        std::to_string(binary) + R"(}],"bufferViews":[{"buffer":0,"byteLength":)" +
        std::to_string(binary) +
        R"(}],"accessors":[{"bufferView":0,"componentType":5126,"type":"VEC3","count":)" +
        std::to_string(triangles * 3) + R"(,"min":[0,0,0],"max":[)" +
        number(double(triangles) * 2 - 1) + ",1,0]}]}";
    json.resize((json.size() + 3) / 4 * 4, ' ');
    Bytes out;
    const auto put = [&](std::uint32_t value) {
        for (int i = 0; i < 4; ++i)
            out.push_back(std::byte(value >> (8 * i)));
    };
    out = bytesOf("glTF");
    put(2);
    put(std::uint32_t(12 + 8 + json.size() + 8 + binary));
    put(std::uint32_t(json.size()));
    put(0x4e4f534a);
    const Bytes text = bytesOf(json);
    out.insert(out.end(), text.begin(), text.end());
    put(std::uint32_t(binary));
    put(0x004e4942);
    const auto* data = reinterpret_cast<const std::byte*>(positions.data());
    out.insert(out.end(), data, data + binary);
    return out;
}

// Files in memory, with delays that differ from run to run when asked for.
class MemorySource : public Source {
  public:
    std::map<std::string, Bytes> files;
    std::chrono::microseconds delay{0};
    bool jitter = false;
    mutable std::atomic<unsigned> reads{0};
    mutable std::mutex mutex;
    mutable std::vector<std::string> order;

    Result<Bytes> read(const std::string& path) const override {
        const unsigned n = ++reads;
        {
            const std::lock_guard lock(mutex);
            order.push_back(path);
        }
        if (delay.count())
            std::this_thread::sleep_for(jitter ? delay * ((n * 2654435761u >> 24) % 4) : delay);
        const auto it = files.find(path);
        if (it == files.end())
            return Error{path, "no such file"};
        return it->second;
    }
    std::string describe(const std::string& path) const override { return path; }
};

inline std::unique_ptr<StreamedTileset> open(std::shared_ptr<const MemorySource> source,
                                             LoaderOptions options = {}) {
    auto opened = StreamedTileset::open(std::move(source), "tileset.json", {}, options);
    return opened ? std::move(*opened) : nullptr;
}

inline std::chrono::steady_clock::time_point soon(int seconds = 20) {
    return std::chrono::steady_clock::now() + std::chrono::seconds(seconds);
}

} // namespace gnomon::testing
