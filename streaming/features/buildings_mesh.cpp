// Bodies of buildings as triangles: outlines put up with a roof, walls and an underside, faces in
// space cut in their own planes.
#include "geo/plan_frame.h"
#include "streaming/features/buildings_model.h"
#include "streaming/features/triangulate.h"
#include "streaming/features/vertex_color.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <span>
#include <utility>

namespace gnomon {

namespace {

// Calm: walls of pale plaster, roofs a little darker and warmer.
constexpr glm::dvec3 kWallColor(0.83, 0.81, 0.77), kRoofColor(0.66, 0.60, 0.55);
// Steeper than about 70 degrees is a wall.
constexpr double kSteepest = 0.34;

class Builder {
  public:
    Builder(Soup& soup, std::uint32_t feature, Point<Ecef> origin)
        : soup_(soup), feature_(feature), origin_(origin) {}

    glm::dvec3 local(double longitude, double latitude, double height) const {
        return (ecefOf({longitude, latitude, height}) - origin_).xyz;
    }
    std::uint32_t vertex(const glm::dvec3& position, std::uint32_t color) {
        const auto index = std::uint32_t(soup_.positions.size());
        soup_.positions.push_back(position);
        soup_.normals.emplace_back(0.0f);
        soup_.uvs.emplace_back(0.0f);
        soup_.colors.push_back(color);
        soup_.features.push_back(feature_);
        return index;
    }
    void triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        soup_.triangles.push_back({{a, b, c}, 0, Soup::Colors | Soup::Features});
    }

  private:
    Soup& soup_;
    std::uint32_t feature_;
    Point<Ecef> origin_;
};

std::uint32_t wallColor() {
    static const std::uint32_t color = linearRgba(kWallColor);
    return color;
}
std::uint32_t roofColor() {
    static const std::uint32_t color = linearRgba(kRoofColor);
    return color;
}

void addOutline(Builder& builder, const FeaturePart& part, const BuildingBody& body) {
    const PlanFrame frame{glm::dvec2(part[0][0])};
    PlanPolygon polygon;
    std::vector<glm::dvec2> places;
    for (const FeatureRing& ring : part) {
        PlanRing plan;
        for (const glm::dvec3& p : ring)
            plan.push_back(frame.plan(p));
        // The outer ring counter-clockwise, holes clockwise: walls face outward.
        const bool outer = polygon.rings.empty();
        const bool turn = (signedArea(plan) > 0.0) != outer;
        if (turn)
            std::reverse(plan.begin(), plan.end());
        for (std::size_t i = 0; i < ring.size(); ++i)
            places.emplace_back(ring[turn ? ring.size() - 1 - i : i]);
        polygon.rings.push_back(std::move(plan));
    }
    std::vector<std::uint32_t> foot, head, roof;
    for (const glm::dvec2& p : places) {
        const glm::dvec3 low = builder.local(p.x, p.y, body.baseMetres);
        const glm::dvec3 high = builder.local(p.x, p.y, body.topMetres);
        foot.push_back(builder.vertex(low, wallColor()));
        head.push_back(builder.vertex(high, wallColor()));
        roof.push_back(builder.vertex(high, roofColor()));
    }
    for (const auto& [a, b, c] : cornersOf(polygon)) {
        builder.triangle(roof[a], roof[b], roof[c]);
        builder.triangle(foot[a], foot[c], foot[b]);
    }
    std::size_t first = 0;
    for (const PlanRing& ring : polygon.rings) {
        for (std::size_t i = 0; i < ring.size(); ++i) {
            const std::size_t a = first + i, b = first + (i + 1) % ring.size();
            builder.triangle(foot[a], foot[b], head[b]);
            builder.triangle(foot[a], head[b], head[a]);
        }
        first += ring.size();
    }
}

// Twice the area vector (Newell).
glm::dvec3 areaVector(std::span<const glm::dvec3> ring) {
    glm::dvec3 sum(0.0);
    for (std::size_t i = 1; i + 1 < ring.size(); ++i)
        sum += glm::cross(ring[i] - ring[0], ring[i + 1] - ring[0]);
    return sum;
}

// A face with one ring inside another or crossing it is cut as what it covers; its corners are then
// not those of its neighbours.
void addMendedFace(Builder& builder, const PlanPolygon& crossing, const glm::dvec3& corner,
                   const glm::dvec3& u, const glm::dvec3& v, std::uint32_t color) {
    for (PlanPolygon& area : validAreas(crossing.rings)) {
        std::vector<std::uint32_t> vertices;
        if (signedArea(area.rings[0]) < 0.0)
            std::reverse(area.rings[0].begin(), area.rings[0].end());
        for (const PlanRing& ring : area.rings)
            for (const glm::dvec2& p : ring)
                vertices.push_back(builder.vertex(corner + p.x * u + p.y * v, color));
        for (const auto& [a, b, c] : cornersOf(area))
            builder.triangle(vertices[a], vertices[b], vertices[c]);
    }
}

void addFace(Builder& builder, const FeaturePart& part) {
    std::vector<std::vector<glm::dvec3>> rings;
    for (const FeatureRing& ring : part) {
        std::vector<glm::dvec3>& out = rings.emplace_back();
        for (const glm::dvec3& p : ring)
            out.push_back(builder.local(p.x, p.y, p.z));
    }
    const glm::dvec3 area = areaVector(rings[0]);
    const double size = glm::length(area);
    if (!(size > 0.0))
        return;
    const glm::dvec3 normal = area / size;
    const glm::dvec3 aside = std::abs(normal.x) < 0.5 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 1, 0);
    const glm::dvec3 u = glm::normalize(glm::cross(aside, normal)), v = glm::cross(normal, u);
    const glm::dvec3 corner = rings[0][0];
    const Vector<Ecef> up = ellipsoidNormal(ecefOf({part[0][0].x, part[0][0].y, part[0][0].z}));
    const std::uint32_t color =
        std::abs(glm::dot(normal, up.xyz)) > kSteepest ? roofColor() : wallColor();

    PlanPolygon polygon;
    std::vector<std::uint32_t> vertices;
    for (const auto& ring : rings) {
        PlanRing& plan = polygon.rings.emplace_back();
        for (const glm::dvec3& p : ring) {
            plan.emplace_back(glm::dot(p - corner, u), glm::dot(p - corner, v));
            vertices.push_back(builder.vertex(p, color));
        }
    }
    // A triangle is always sound.
    if (vertices.size() > 3 && !isSound(polygon.rings)) {
        addMendedFace(builder, polygon, corner, u, v, color);
        return;
    }
    for (const auto& [a, b, c] : cornersOf(polygon))
        builder.triangle(vertices[a], vertices[b], vertices[c]);
}

bool isInside(const FeatureRing& ring, glm::dvec2 place) {
    bool inside = false;
    for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
        const glm::dvec2 a(std::remainder(ring[i].x - place.x, 360.0), ring[i].y - place.y);
        const glm::dvec2 b(std::remainder(ring[j].x - place.x, 360.0), ring[j].y - place.y);
        if ((a.y > 0.0) != (b.y > 0.0) && (b.x - a.x) * (0.0 - a.y) / (b.y - a.y) + a.x > 0.0)
            inside = !inside;
    }
    return inside;
}

// Surfaces that lack nothing but their underside, as terrain hides it, get one: then they are
// solids. What is missing are loops of edges that one face only has, level and as low as anything.
class Underside {
  public:
    explicit Underside(const BuildingBody& body) {
        for (const FeaturePart& part : body.parts)
            for (const FeatureRing& ring : part)
                for (std::size_t i = 0; i < ring.size(); ++i) {
                    const std::uint32_t a = number(ring[i]);
                    const std::uint32_t b = number(ring[(i + 1) % ring.size()]);
                    if (a != b)
                        ++edges_[{a, b}];
                }
    }

    // One face a loop; holes with the loop around them. Empty when more is missing.
    std::vector<FeaturePart> faces() const {
        constexpr double kLevelMetres = 0.05;
        std::map<std::uint32_t, std::uint32_t> next; // along the missing face
        double lowest = std::numeric_limits<double>::infinity(), highest = -lowest;
        for (const auto& [edge, count] : edges_) {
            const auto back = edges_.find({edge.second, edge.first});
            const int missing = count - (back == edges_.end() ? 0 : back->second);
            if (missing <= 0)
                continue;
            if (missing > 1 || !next.emplace(edge.second, edge.first).second)
                return {};
            highest = std::max(highest, places_[edge.first].z);
        }
        for (const glm::dvec3& p : places_)
            lowest = std::min(lowest, p.z);
        if (next.empty() || highest > lowest + kLevelMetres)
            return {};
        return nested(loops(std::move(next)));
    }

  private:
    std::uint32_t number(const glm::dvec3& p) {
        const auto [at, fresh] =
            numbers_.emplace(std::array{p.x, p.y, p.z}, std::uint32_t(places_.size()));
        if (fresh)
            places_.push_back(p);
        return at->second;
    }

    std::vector<FeatureRing> loops(std::map<std::uint32_t, std::uint32_t> next) const {
        std::vector<FeatureRing> loops;
        while (!next.empty()) {
            FeatureRing& loop = loops.emplace_back();
            for (auto at = next.begin(); at != next.end();) {
                loop.push_back(places_[at->first]);
                const std::uint32_t to = at->second;
                next.erase(at);
                at = next.find(to);
            }
        }
        return loops;
    }

    // Seen from above, what faces down is clockwise; the other way round are holes in it.
    std::vector<FeaturePart> nested(std::vector<FeatureRing> loops) const {
        const PlanFrame frame{glm::dvec2(places_.front())};
        std::vector<FeaturePart> faces;
        std::vector<FeatureRing> holes;
        for (FeatureRing& loop : loops) {
            PlanRing plan;
            for (const glm::dvec3& p : loop)
                plan.push_back(frame.plan(p));
            if (signedArea(plan) < 0.0)
                faces.push_back({std::move(loop)});
            else
                holes.push_back(std::move(loop));
        }
        for (FeatureRing& hole : holes)
            for (FeaturePart& face : faces)
                if (isInside(face[0], glm::dvec2(hole[0]))) {
                    face.push_back(std::move(hole));
                    break;
                }
        return faces;
    }

    std::map<std::array<double, 3>, std::uint32_t> numbers_;
    std::vector<glm::dvec3> places_;
    std::map<std::pair<std::uint32_t, std::uint32_t>, int> edges_;
};

} // namespace

BuildingTriangles::BuildingTriangles(Point<Ecef> near) {
    ecefFromTile.matrix[3] = glm::dvec4(near.xyz, 1.0);
    clean.origin = near;
}

void BuildingTriangles::add(const BuildingBody& body, std::uint32_t feature) {
    if (body.isSurface) {
        Soup one;
        Builder builder(one, feature, clean.origin);
        for (const FeaturePart& face : body.parts)
            addFace(builder, face);
        for (const FeaturePart& face : Underside(body).faces())
            addFace(builder, face);
        take(one);
        return;
    }
    for (const FeaturePart& part : body.parts) {
        Soup one;
        Builder builder(one, feature, clean.origin);
        addOutline(builder, part, body);
        take(one);
    }
}

void BuildingTriangles::take(const Soup& one) {
    const CleanSoup cleaned = gnomon::clean(one, ecefFromTile);
    const auto first = std::uint32_t(soup.positions.size());
    const auto append = [](auto& to, const auto& from) {
        to.insert(to.end(), from.begin(), from.end());
    };
    append(soup.positions, one.positions);
    append(soup.normals, one.normals);
    append(soup.uvs, one.uvs);
    append(soup.colors, one.colors);
    append(soup.features, one.features);
    const glm::dvec3 offset = (cleaned.origin - clean.origin).xyz;
    for (const glm::dvec3& p : cleaned.local)
        clean.local.push_back(p + offset);
    for (Soup::Triangle t : cleaned.triangles) {
        for (std::uint32_t& v : t.vertex)
            v += first;
        clean.triangles.push_back(t);
    }
    append(clean.closed, cleaned.closed);
    clean.duplicates += cleaned.duplicates;
    clean.degenerate += cleaned.degenerate;
    clean.invalid += cleaned.invalid;
    clean.closedTriangles += cleaned.closedTriangles;
    clean.components += cleaned.components;
    clean.closedComponents += cleaned.closedComponents;
    clean.areaVector += cleaned.areaVector;
}

bool covers(const BuildingBody& body, glm::dvec2 lonLat) {
    const double x = body.west + std::remainder(lonLat.x - body.west, 360.0);
    const double wrapped = x < body.west ? x + 360.0 : x;
    if (wrapped > body.east || lonLat.y < body.south || lonLat.y > body.north)
        return false;
    for (const FeaturePart& part : body.parts) {
        bool inside = false; // even-odd: holes are rings too
        for (const FeatureRing& ring : part)
            inside ^= isInside(ring, lonLat);
        if (inside)
            return true;
    }
    return false;
}

} // namespace gnomon
