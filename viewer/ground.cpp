#include "viewer/ground.h"

#include <glm/trigonometric.hpp>

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

namespace gnomon {

namespace {

constexpr int kSectors = 64;
constexpr int kSectorsPerMesh = 8;
constexpr int kRingsPerMesh = 8;
constexpr double kFirstRingMetres = 50.0;
constexpr double kRingGrowth = 1.15;
constexpr double kMeanRadiusMetres = 6371008.8;
constexpr double kFarthestMetres = 0.98 * std::numbers::pi * kMeanRadiusMetres;
// A calm, slightly warm grey-green, darker than most roofs.
const glm::vec4 kGroundColor(0.23f, 0.235f, 0.20f, 1.0f);

// The ground at `distance` along the surface from the anchor, in direction of sector `s`.
Point<Ecef> groundPoint(const Scene& scene, double heightMetres, double distance, int sector) {
    const double angle = 2.0 * std::numbers::pi * sector / kSectors;
    const double arc = distance / kMeanRadiusMetres;
    const Vector<Enu> sideways{{std::sin(angle), std::cos(angle), 0.0}};
    // A great circle on a sphere about the anchor's centre of curvature, put down on the ellipsoid.
    const Vector<Ecef> along = scene.ecefFromAnchor(sideways);
    const Vector<Ecef> up = scene.ecefFromAnchor(Vector<Enu>{{0, 0, 1}});
    const Point<Ecef> anchor =
        ecefOf({scene.anchor.longitudeDegrees, scene.anchor.latitudeDegrees, 0.0});
    const Point<Ecef> sphere = anchor + (kMeanRadiusMetres * std::sin(arc)) * along +
                               (kMeanRadiusMetres * (std::cos(arc) - 1.0)) * up;
    Geodetic place = geodeticOf(sphere);
    place.heightMetres = heightMetres;
    return ecefOf(place);
}

std::vector<double> ringRadii() {
    std::vector<double> radii{0.0};
    for (double r = kFirstRingMetres; r < kFarthestMetres; r *= kRingGrowth)
        radii.push_back(r);
    radii.push_back(kFarthestMetres);
    return radii;
}

// Rings [ring0, ring1] by sectors [sector0, sector1] as one mesh.
Mesh groundPatch(const Scene& scene, double heightMetres, const std::vector<double>& radii,
                 int ring0, int ring1, int sector0, int sector1) {
    std::vector<Point<Ecef>> points;
    for (int r = ring0; r <= ring1; ++r)
        for (int s = sector0; s <= sector1; ++s)
            points.push_back(groundPoint(scene, heightMetres, radii[std::size_t(r)], s));
    Mesh mesh;
    const glm::dmat3 stored = glm::transpose(scene.ecefFromAnchor.axes());
    mesh.box = boxAround(points, ecefFromEnu(geodeticOf(points[points.size() / 2])).axes());
    mesh.origin = mesh.box.centre;
    for (const Point<Ecef>& p : points) {
        mesh.positions.push_back(glm::vec3(stored * (p - mesh.origin).xyz));
        mesh.normals.push_back(encodeOct(stored * ellipsoidNormal(p).xyz));
        mesh.radiusMetres = std::max(mesh.radiusMetres, length(p - mesh.origin));
    }
    const auto add = [&](std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        const glm::dvec3 n =
            glm::cross(points[b].xyz - points[a].xyz, points[c].xyz - points[a].xyz);
        const double area = glm::length(n);
        if (area == 0.0) // the innermost ring's points coincide
            return;
        mesh.indices.insert(mesh.indices.end(), {a, b, c});
        mesh.faceNormals.push_back(encodeOct(stored * n / area));
    };
    const std::uint32_t columns = std::uint32_t(sector1 - sector0 + 1);
    for (std::uint32_t r = 0; r + 1 <= std::uint32_t(ring1 - ring0); ++r)
        for (std::uint32_t s = 0; s + 1 < columns; ++s) {
            const std::uint32_t a = r * columns + s, b = a + 1, c = a + columns, d = c + 1;
            add(a, d, c); // sectors run clockwise seen from above
            add(a, b, d);
        }
    mesh.closedTriangles = mesh.triangles(); // the Earth has an inside
    return mesh;
}

// A column of the Earth about the anchor, at a level of detail by the size of its pixels.
View columnView(const Scene& scene, double halfWidthMetres, double pixelMetres) {
    View view;
    for (const glm::dvec3 side :
         {glm::dvec3(1, 0, 0), glm::dvec3(-1, 0, 0), glm::dvec3(0, 1, 0), glm::dvec3(0, -1, 0)}) {
        const Vector<Ecef> inward = scene.ecefFromAnchor(Vector<Enu>{-side});
        view.planes.push_back({inward, scene.ecefFromAnchor(Point<Enu>{side * halfWidthMetres})});
    }
    view.eye = scene.ecefFromAnchor.origin();
    view.forward = -scene.ecefFromAnchor(Vector<Enu>{{0, 0, 1}});
    view.pixelMetres = pixelMetres;
    return view;
}

struct Sampled {
    std::vector<double> lowest; // of each building, metres above the ellipsoid
    double upwardArea = 0.0, footprint = 0.0;
};

void sample(const TileContent& content, const glm::dmat3& meshAxes, Sampled& out) {
    // A building is what carries one id, over all its materials; without ids, what stands on one
    // square of this size.
    constexpr double kCellMetres = 32.0;
    std::map<std::pair<std::int64_t, std::int64_t>, double> lowest;
    for (const Mesh& mesh : content.meshes) {
        const Vector<Ecef> up = ellipsoidNormal(mesh.origin);
        const Transform<Ecef, Enu> ecefFromLocal = ecefFromEnu(geodeticOf(mesh.origin));
        for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
            const glm::dvec3 fromOrigin = meshAxes * glm::dvec3(mesh.positions[i]);
            const Point<Ecef> p{mesh.origin.xyz + fromOrigin};
            const glm::dvec3 local = glm::transpose(ecefFromLocal.axes()) * fromOrigin;
            const auto cell = [&](double x) { return std::int64_t(std::floor(x / kCellMetres)); };
            const std::pair<std::int64_t, std::int64_t> key =
                mesh.features.empty() ? std::pair(cell(local.x), cell(local.y))
                                      : std::pair(std::int64_t(mesh.features[i]), std::int64_t(0));
            const double height = geodeticOf(p).heightMetres;
            const auto [at, fresh] = lowest.emplace(key, height);
            if (!fresh)
                at->second = std::min(at->second, height);
        }
        for (std::size_t i = 0; i + 2 < mesh.indices.size(); i += 3) {
            const glm::dvec3 a(mesh.positions[mesh.indices[i]]);
            const glm::dvec3 b(mesh.positions[mesh.indices[i + 1]]);
            const glm::dvec3 c(mesh.positions[mesh.indices[i + 2]]);
            out.upwardArea += 0.5 * glm::dot(meshAxes * glm::cross(b - a, c - a), up.xyz);
        }
        const glm::dmat3 half = glm::transpose(ecefFromLocal.axes()) * mesh.box.halfAxes;
        const glm::dvec3 extent = glm::abs(half[0]) + glm::abs(half[1]) + glm::abs(half[2]);
        out.footprint += 4.0 * extent.x * extent.y;
    }
    for (const auto& [key, height] : lowest)
        out.lowest.push_back(height);
}

using Clock = std::chrono::steady_clock;

// What this layer's view lacks, with the first reason that is known.
Error lackingIn(const Layer& layer, const Selection& selection) {
    Error error{layer.uri, "its tiles did not come in time", ErrorKind::Transient};
    for (const LoadRequest& request : selection.load)
        if (const Error* fault = layer.tileset->lastFault(request.tile))
            return *fault;
    return error;
}

Failure sampleColumn(Scene& scene, const View& column, Clock::time_point deadline, bool allMustCome,
                     Sampled& out) {
    for (Layer& layer : scene.layers) {
        const Settled settled =
            settle(*layer.tileset, std::span(&column, 1), {1.0, false}, deadline);
        if (allMustCome && !settled.complete && !settled.overBudget)
            return lackingIn(layer, settled.selection);
        for (const TileIndex tile : settled.selection.drawDepthFirst)
            if (const auto content = layer.tileset->content(tile))
                sample(*content, scene.ecefFromAnchor.axes(), out);
    }
    return {};
}

} // namespace

TileContent makeGround(const Scene& scene, double heightMetres) {
    TileContent content;
    Material material;
    material.baseColor = kGroundColor;
    content.materials.push_back(material);
    const std::vector<double> radii = ringRadii();
    for (int ring = 0; ring + 1 < int(radii.size()); ring += kRingsPerMesh)
        for (int sector = 0; sector < kSectors; sector += kSectorsPerMesh)
            content.meshes.push_back(
                groundPatch(scene, heightMetres, radii, ring,
                            std::min(ring + kRingsPerMesh, int(radii.size()) - 1), sector,
                            sector + kSectorsPerMesh));
    return content;
}

Result<std::optional<double>> findGroundHeight(Scene& scene, Clock::time_point deadline,
                                               bool allMustCome) {
    Sampled sampled;
    // The coarsest content there is will do; then the column widens until something stands in it.
    double coarsest = 1.0;
    for (const Layer& layer : scene.layers) {
        const TileTree& tree = layer.tileset->tree();
        coarsest = std::max(coarsest, tree.node(TileTree::root()).geometricErrorMetres);
    }
    for (double half = 200.0; sampled.lowest.empty(); half *= 4.0) {
        for (double pixel = 2.0 * coarsest; pixel > 0.1 && sampled.lowest.empty(); pixel /= 4.0)
            if (Failure late = sampleColumn(scene, columnView(scene, half, pixel), deadline,
                                            allMustCome, sampled))
                return *late;
        if (half > 2.0 * scene.radiusMetres)
            break;
    }
    if (sampled.lowest.empty())
        return std::optional<double>();
    // Roofs alone, seen from above, cover less than this of the boxes around them.
    constexpr double kTerrainShare = 0.7;
    if (sampled.upwardArea > kTerrainShare * sampled.footprint)
        return std::optional<double>();
    // A house a little sunk into the ground looks right, one that floats does not: three of four
    // stand on it or in it.
    const auto at = sampled.lowest.begin() + std::ptrdiff_t(3 * sampled.lowest.size() / 4);
    std::nth_element(sampled.lowest.begin(), at, sampled.lowest.end());
    return std::optional<double>(*at);
}

} // namespace gnomon
