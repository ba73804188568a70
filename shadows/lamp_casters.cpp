#include "shadows/lamp_casters.h"

#include <glm/common.hpp>

#include <algorithm>
#include <array>
#include <cmath>

namespace gnomon {

namespace {

// A hemisphere cut to half a texel at 1024² takes some 10,000 triangles a layer of surfaces; two
// hundred layers are no lamp's surroundings. What exceeds this is drawn uncut.
constexpr std::size_t kMostTriangles = std::size_t(1) << 21;
// A plane this near to the lamp is seen edge on: it covers nothing.
constexpr double kEdgeOnMetres = 1e-7;

bool withinReach(const LampTriangle& t, const Lamp& lamp) {
    const glm::dvec3 low = glm::min(t[0], glm::min(t[1], t[2]));
    const glm::dvec3 high = glm::max(t[0], glm::max(t[1], t[2]));
    const glm::dvec3 nearest = glm::max(low, glm::max(-high, glm::dvec3(0.0)));
    const double farthest2 =
        std::max({glm::dot(t[0], t[0]), glm::dot(t[1], t[1]), glm::dot(t[2], t[2])});
    return glm::dot(nearest, nearest) <= lamp.rangeMetres * lamp.rangeMetres &&
           farthest2 >= lamp.nearMetres * lamp.nearMetres;
}

// u or v at a place on the triangle's plane: dot(xyz, p) + w.
glm::vec4 gradientOf(const LampTriangle& t, const glm::dvec3& normal, const glm::dvec3& values) {
    const double area2 = glm::dot(normal, normal);
    const glm::dvec3 g =
        (glm::cross(normal, t[2] - t[1]) * values[0] + glm::cross(normal, t[0] - t[2]) * values[1] +
         glm::cross(normal, t[1] - t[0]) * values[2]) /
        area2;
    return glm::vec4(glm::dvec4(g, values[0] - glm::dot(g, t[0])));
}

// The first four of LampMapTriangles::planes.
std::array<glm::vec4, 6> planesOf(const LampTriangle& t, const glm::dvec3& normal,
                                  double offPlane) {
    std::array<glm::vec4, 6> record{};
    const double farthest = std::max({glm::length(t[0]), glm::length(t[1]), glm::length(t[2])});
    record[0] = glm::vec4(glm::dvec4(normal / offPlane, farthest));
    for (std::size_t i = 0; i < 3; ++i) {
        const glm::dvec3 side = glm::cross(t[i], t[(i + 1) % 3]) * (offPlane < 0.0 ? -1.0 : 1.0);
        record[1 + i] =
            glm::vec4(glm::dvec4(side / std::max(glm::length(side), kEdgeOnMetres), 0.0));
    }
    return record;
}

// The triangle's image on one map, appended.
class MapWriter {
  public:
    MapWriter(const LampMaps& maps, double bendTexels)
        : maps_(maps), units_(maps.unitsAcross()), bend_(bendTexels * units_ / maps.texels) {}

    // Into how many pieces.
    std::uint32_t write(int map, const LampTriangle& t, std::vector<glm::vec3>& corners) {
        const std::size_t before = corners.size();
        if (maps_.method == LampMethod::Cube)
            writeFace(map, t, corners);
        else
            writeHemisphere(map, t, corners);
        return std::uint32_t((corners.size() - before) / 3);
    }

  private:
    void writeHemisphere(int map, LampTriangle t, std::vector<glm::vec3>& corners) {
        if (map == 1)
            for (glm::dvec3& p : t)
                p.z = -p.z;
        const std::size_t there = corners.size() / 3;
        pieces_.clear();
        cutTriangle(t, bend_, maps_, kMostTriangles - std::min(kMostTriangles, there), pieces_);
        for (const LampTriangle& piece : pieces_)
            for (const glm::dvec3& p : piece)
                corners.emplace_back(
                    glm::dvec3(paraboloidPoint(glm::normalize(p)) * (2.0 / units_), 1.0));
    }

    // As the clipping wants it: nothing in front of the face at all, or all outside one side.
    void writeFace(int map, const LampTriangle& t, std::vector<glm::vec3>& corners) {
        LampTriangle clip;
        for (std::size_t i = 0; i < 3; ++i)
            clip[i] = faceClip(maps_, map, t[i]);
        const auto all = [&](auto outside) {
            return outside(clip[0]) && outside(clip[1]) && outside(clip[2]);
        };
        if (all([](const glm::dvec3& c) { return c.x > c.z; }) ||
            all([](const glm::dvec3& c) { return c.x < -c.z; }) ||
            all([](const glm::dvec3& c) { return c.y > c.z; }) ||
            all([](const glm::dvec3& c) { return c.y < -c.z; }) ||
            all([](const glm::dvec3& c) { return c.z <= 0.0; }))
            return;
        for (const glm::dvec3& c : clip)
            corners.emplace_back(c);
    }

    const LampMaps& maps_;
    double units_, bend_;
    std::vector<LampTriangle> pieces_;
};

struct Writer {
    const Lamp& lamp;
    const glm::dmat3 rotation;
    const Transform<LampFrame, Ecef>& lampFromEcef;
    MapWriter images;
    LampGeometry& out;
    std::vector<glm::dvec3> positions;

    void add(const LampCaster& caster, std::size_t index, bool alpha) {
        const Mesh& mesh = caster.geometry();
        const glm::dvec3 offset = lampFromEcef(mesh.origin).xyz;
        positions.clear();
        for (const glm::vec3& p : mesh.positions)
            positions.push_back(rotation * glm::dvec3(p) + offset);
        for (LampMapTriangles& map : out.maps)
            if (alpha)
                map.alpha.push_back({std::uint32_t(map.corners.size() / 3), 0, index});
        for (std::uint32_t i = 0; i < mesh.castingTriangles(); ++i)
            addTriangle(mesh, &mesh.indices[std::size_t(i) * 3], alpha);
    }

    void addTriangle(const Mesh& mesh, const std::uint32_t* corner, bool alpha) {
        const LampTriangle t{positions[corner[0]], positions[corner[1]], positions[corner[2]]};
        if (!withinReach(t, lamp))
            return;
        const glm::dvec3 normal = glm::cross(t[1] - t[0], t[2] - t[0]);
        const double offPlane = glm::dot(normal, t[0]);
        if (!(std::abs(offPlane) > kEdgeOnMetres * glm::length(normal)))
            return;
        ++out.sourceTriangles;
        std::array<glm::vec4, 6> record = planesOf(t, normal, offPlane);
        if (alpha && !mesh.uvs.empty()) {
            const auto uv = [&](std::size_t i) { return glm::dvec2(mesh.uvs[corner[i]]); };
            record[4] = gradientOf(t, normal, {uv(0).x, uv(1).x, uv(2).x});
            record[5] = gradientOf(t, normal, {uv(0).y, uv(1).y, uv(2).y});
        }
        const auto end = record.begin() + (alpha ? 6 : 4);
        for (std::size_t m = 0; m < out.maps.size(); ++m) {
            LampMapTriangles& map = out.maps[m];
            const std::uint32_t pieces = images.write(int(m), t, map.corners);
            for (std::uint32_t i = 0; i < pieces; ++i)
                map.planes.insert(map.planes.end(), record.begin(), end);
            (alpha ? map.alpha.back().count : map.opaque) += pieces;
        }
    }
};

} // namespace

bool LampCaster::alphaTests() const {
    const Material& look = content->materials[std::size_t(geometry().material)];
    return look.alphaTest && look.image >= 0;
}

std::vector<LampCaster> castersOf(const Lamp& lamp, std::span<const LampCaster> casters) {
    std::vector<LampCaster> reached;
    for (const LampCaster& caster : casters)
        if (distanceTo(BoundingVolume(caster.geometry().box), lamp.position) <= lamp.rangeMetres)
            reached.push_back(caster);
    return reached;
}

LampGeometry lampGeometry(const Transform<LampFrame, Ecef>& lampFromEcef, const Lamp& lamp,
                          const LampMaps& maps, const glm::dmat3& meshAxes, double bendTexels,
                          std::span<const LampCaster> casters) {
    LampGeometry out;
    out.maps.resize(std::size_t(maps.count));
    Writer writer{lamp, lampFromEcef.axes() * meshAxes, lampFromEcef, {maps, bendTexels}, out, {}};
    for (const bool alpha : {false, true})
        for (std::size_t i = 0; i < casters.size(); ++i)
            if (casters[i].alphaTests() == alpha)
                writer.add(casters[i], i, alpha);
    return out;
}

} // namespace gnomon
