// Features, grounds and checks for the tests of trees and barriers.
#pragma once

#include "streaming/clean.h"
#include "streaming/content_maker.h"
#include "streaming/features/features.h"
#include "streaming/terrain/ground_heights.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <string>
#include <vector>

namespace gnomon::test {

inline constexpr Geodetic kHere{6.96, 50.94, 0.0};

// Metres to the east and north of kHere, to some millimetres.
inline glm::dvec2 metresPerDegree() {
    const Point<Ecef> o = ecefOf(kHere);
    return {1e4 * length(ecefOf({kHere.longitudeDegrees + 1e-4, kHere.latitudeDegrees, 0}) - o),
            1e4 * length(ecefOf({kHere.longitudeDegrees, kHere.latitudeDegrees + 1e-4, 0}) - o)};
}
inline glm::dvec3 at(double east, double north, double z = NAN) {
    static const glm::dvec2 perDegree = metresPerDegree();
    return {kHere.longitudeDegrees + east / perDegree.x,
            kHere.latitudeDegrees + north / perDegree.y, z};
}
inline glm::dvec2 metres(glm::dvec2 lonLat) {
    static const glm::dvec2 perDegree = metresPerDegree();
    return (lonLat - glm::dvec2(kHere.longitudeDegrees, kHere.latitudeDegrees)) * perDegree;
}

// A ground whose height is told by a function of metres east and north.
class Ground : public GroundHeights {
  public:
    explicit Ground(std::function<double(glm::dvec2)> height) : height_(std::move(height)) {}
    void sample(std::span<const glm::dvec2> lonLat, std::span<double> heights) const override {
        for (std::size_t i = 0; i < lonLat.size(); ++i)
            heights[i] = height_(metres(lonLat[i]));
    }

  private:
    std::function<double(glm::dvec2)> height_;
};
inline std::shared_ptr<const GroundHeights> ground(std::function<double(glm::dvec2)> height) {
    return std::make_shared<Ground>(std::move(height));
}
inline double slope(glm::dvec2 p) {
    return 60.0 + 0.2 * p.x - 0.1 * p.y;
}

// A file of its own, gone with the test.
class File {
  public:
    File(const std::string& ending, const std::string& text) {
        std::string folder = (std::filesystem::temp_directory_path() / "gnomon-XXXXXX").string();
        folder_ = ::mkdtemp(folder.data());
        path_ = (folder_ / ("plants" + ending)).string();
        std::ofstream(path_, std::ios::binary) << text;
    }
    ~File() { std::filesystem::remove_all(folder_); }
    File(const File&) = delete;
    File& operator=(const File&) = delete;
    const std::string& path() const { return path_; }

  private:
    std::filesystem::path folder_;
    std::string path_;
};

// GeoJSON in UTM zone 32.
inline std::string utmCollection(const std::string& features) {
    return R"({"type":"FeatureCollection",
        "crs":{"type":"name","properties":{"name":"urn:ogc:def:crs:EPSG::25832"}},
        "features":[)" +
           features + "]}";
}

using Attributes = std::vector<std::pair<std::string, AttributeValue>>;

inline Feature feature(FeatureShape shape, FeaturePart part, Attributes attributes = {}) {
    Feature made;
    made.shape = shape;
    made.parts = {std::move(part)};
    made.attributes = std::move(attributes);
    return made;
}
inline FeatureFile fileOf(std::vector<Feature> features) {
    FeatureFile file;
    file.features = std::move(features);
    for (std::size_t i = 0; i < file.features.size(); ++i)
        file.features[i].id = std::to_string(i);
    return file;
}

inline bool says(const std::vector<std::string>& notes, const std::string& text) {
    return std::ranges::any_of(
        notes, [&](const std::string& note) { return note.find(text) != std::string::npos; });
}
inline bool says(const std::vector<Error>& errors, const std::string& text) {
    return std::ranges::any_of(errors, [&](const Error& error) {
        return error.message().find(text) != std::string::npos &&
               error.message().find('\n') == std::string::npos;
    });
}

// All of a content's triangles, metres from `centre`, ECEF's axes.
inline Soup soupOf(const TileContent& content, const glm::dmat3& meshAxes, Point<Ecef> centre) {
    Soup soup;
    for (const Mesh& mesh : content.meshes) {
        const auto first = std::uint32_t(soup.positions.size());
        for (const glm::vec3& p : mesh.positions)
            soup.positions.push_back((mesh.origin - centre).xyz + meshAxes * glm::dvec3(p));
        for (std::size_t i = 0; i < mesh.indices.size(); i += 3)
            soup.triangles.push_back({{first + mesh.indices[i], first + mesh.indices[i + 1],
                                       first + mesh.indices[i + 2]},
                                      0,
                                      0});
    }
    soup.normals.resize(soup.positions.size());
    soup.uvs.resize(soup.positions.size());
    soup.colors.resize(soup.positions.size());
    soup.features.resize(soup.positions.size());
    return soup;
}

inline double signedVolume(const Soup& soup) {
    double volume = 0.0;
    for (const Soup::Triangle& t : soup.triangles)
        volume += glm::dot(soup.positions[t.vertex[0]],
                           glm::cross(soup.positions[t.vertex[1]], soup.positions[t.vertex[2]])) /
                  6.0;
    return volume;
}

// Where the ellipsoid's east, north, up are at kHere.
inline glm::dmat3 hereAxes() {
    return ecefFromEnu(kHere).axes();
}

inline TileContent made(const MadeTileset& tiles, const std::string& path) {
    DecodeOptions options;
    options.meshAxes = hereAxes();
    Result<TileContent> content = tiles.maker->make(path, options);
    EXPECT_TRUE(bool(content)) << path;
    return content ? std::move(*content) : TileContent{};
}

// What every mesh promises (streaming/mesh.h).
inline void expectSound(const TileContent& content, const MadeTile& tile) {
    std::uint64_t triangles = 0;
    for (const Mesh& mesh : content.meshes) {
        triangles += mesh.triangles();
        ASSERT_EQ(mesh.normals.size(), mesh.positions.size());
        ASSERT_EQ(mesh.colors.size(), mesh.positions.size());
        ASSERT_EQ(mesh.faceNormals.size(), mesh.triangles());
        EXPECT_EQ(mesh.closedTriangles, mesh.triangles());
        EXPECT_EQ(mesh.skirtTriangles, 0u);
        for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
            const glm::dvec3 p(mesh.positions[i]);
            ASSERT_LE(glm::length(p), mesh.radiusMetres * (1 + 1e-6));
            const Point<Ecef> place{mesh.origin.xyz + hereAxes() * p};
            ASSERT_LE(distanceTo(tile.volume, place), 1e-3);
            ASSERT_LE(distanceTo(BoundingVolume(mesh.box), place), 1e-3);
        }
        for (const std::uint32_t i : mesh.indices)
            ASSERT_LT(i, mesh.positions.size());
    }
    EXPECT_EQ(content.facts.triangles, triangles);
    EXPECT_EQ(content.facts.closedTriangles, triangles);
    EXPECT_EQ(content.materials.size(), 1u);
}

inline bool sameBytes(const TileContent& a, const TileContent& b) {
    const auto same = [](const auto& x, const auto& y) {
        return x.size() == y.size() &&
               std::memcmp(x.data(), y.data(), x.size() * sizeof(x[0])) == 0;
    };
    if (a.meshes.size() != b.meshes.size())
        return false;
    for (std::size_t i = 0; i < a.meshes.size(); ++i) {
        const Mesh &x = a.meshes[i], &y = b.meshes[i];
        if (!same(x.positions, y.positions) || !same(x.normals, y.normals) ||
            !same(x.colors, y.colors) || !same(x.indices, y.indices) ||
            !same(x.faceNormals, y.faceNormals) || x.origin.xyz != y.origin.xyz)
            return false;
    }
    return true;
}

} // namespace gnomon::test
