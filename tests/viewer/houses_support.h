// Houses in b3dm with a batch table, for the tests of what tiles tell of a place or a pixel.
#pragma once

#include "geo/ellipsoid.h"
#include "tests/streaming/glb_builder.h"

#include <string>
#include <vector>

namespace gnomon::test {

inline constexpr Geodetic kHousesPlace{6.96, 50.94, 55.0};

// A box; east, north, up in metres from the place. `feature` below 0: it has none.
struct House {
    glm::vec3 low, high;
    float feature = 0.0f;
};

// z is up: for a tileset that says so.
inline GlbBuilder housesGlb(const std::vector<House>& houses) {
    std::vector<float> positions, ids;
    std::vector<std::uint32_t> indices;
    for (const House& house : houses) {
        indices = joined(indices, boxTriangles(std::uint32_t(positions.size() / 3)));
        positions = joined(positions, boxCorners(house.low, house.high));
        ids.resize(positions.size() / 3, house.feature);
    }
    GlbBuilder builder;
    Json& primitive = builder.triangles(positions, indices);
    primitive["attributes"]["_BATCHID"] = builder.floats(ids, "SCALAR");
    return builder;
}

inline std::string housesB3dm(const std::vector<House>& houses,
                              const std::vector<std::string>& names) {
    return b3dmOf(housesGlb(houses).text(), Json{{"BATCH_LENGTH", names.size()}}.dump(),
                  Json{{"gml_id", names}}.dump());
}

inline Json boxVolume(const glm::vec3& low, const glm::vec3& high) {
    const glm::vec3 c = 0.5f * (low + high), h = 0.5f * (high - low);
    return {{"box", {c.x, c.y, c.z, h.x, 0, 0, 0, h.y, 0, 0, 0, h.z}}};
}

inline Json transformAt(const Geodetic& place) {
    const glm::dmat4 m = ecefFromEnu(place).matrix;
    Json out = Json::array();
    for (int i = 0; i < 16; ++i) {
        out.push_back(m[i / 4][i % 4]);
    }
    return out;
}

// Where a point of the place's frame is on the map.
inline glm::dvec2 lonLatOf(double east, double north, const Geodetic& place = kHousesPlace) {
    const Geodetic at = geodeticOf(ecefFromEnu(place)(Point<Enu>{{east, north, 0.0}}));
    return {at.longitudeDegrees, at.latitudeDegrees};
}

} // namespace gnomon::test
