// Files, buildings and checks for the tests of features and buildings.
#pragma once

#include "plants_support.h"
#include "streaming/features/buildings.h"

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <string>
#include <vector>

namespace gnomon::test {

// A folder that is gone with the test.
class Folder {
  public:
    Folder() {
        std::string name = (std::filesystem::temp_directory_path() / "gnomon-XXXXXX").string();
        path_ = ::mkdtemp(name.data());
    }
    ~Folder() { std::filesystem::remove_all(path_); }
    Folder(const Folder&) = delete;
    Folder& operator=(const Folder&) = delete;

    std::string path() const { return path_.string(); }
    std::string file(const std::string& name) const { return (path_ / name).string(); }
    std::string write(const std::string& name, const std::string& text) const {
        std::ofstream(path_ / name, std::ios::binary) << text;
        return file(name);
    }

  private:
    std::filesystem::path path_;
};

inline std::string dataFolder() {
    const char* given = std::getenv("GNOMON_DATA");
    return given != nullptr ? given : std::string(GNOMON_SOURCE_DIR) + "/../shared/data";
}
#define NEEDS_DATA(path)                                                                           \
    if (!std::filesystem::exists(path))                                                            \
    GTEST_SKIP() << path << " is not there"

inline std::shared_ptr<const Buildings>
buildingsOf(std::vector<Feature> features, const std::shared_ptr<const GroundHeights>& ground,
            const BuildingOptions& options = {}) {
    auto made = Buildings::of(fileOf(std::move(features)), "test", options, ground);
    EXPECT_TRUE(made) << (made ? "" : made.error().message());
    return made ? *made : nullptr;
}

// A ring about a centre, metres east and north of kHere.
inline FeatureRing box(double east, double north, double width, double depth, double z = NAN) {
    return {at(east, north, z), at(east + width, north, z), at(east + width, north + depth, z),
            at(east, north + depth, z)};
}

struct Measured {
    double volume = 0.0;
    std::size_t triangles = 0, closed = 0;
    std::map<std::uint32_t, std::size_t> features; // triangles of each
    double lowest = 1e9, highest = -1e9;           // above the ellipsoid
};

inline Measured measured(const Buildings& buildings) {
    Measured out;
    const MadeTileset made = buildings.tiles();
    const Point<Ecef> centre = boundingSphere(made.tiles.front().volume).centre;
    for (const MadeTile& tile : made.tiles) {
        const auto content = made.maker->make(tile.path, {});
        EXPECT_TRUE(content);
        if (!content)
            continue;
        out.volume += signedVolume(soupOf(*content, glm::dmat3(1.0), centre));
        for (const Mesh& mesh : content->meshes) {
            out.triangles += mesh.triangles();
            out.closed += mesh.closedTriangles;
            for (std::size_t i = 0; i < mesh.indices.size(); i += 3)
                ++out.features[mesh.features[mesh.indices[i]]];
            for (const glm::vec3& p : mesh.positions) {
                const Point<Ecef> there{mesh.origin.xyz + glm::dvec3(p)};
                const double height = geodeticOf(there).heightMetres;
                out.lowest = std::min(out.lowest, height);
                out.highest = std::max(out.highest, height);
            }
        }
    }
    return out;
}

} // namespace gnomon::test
