#include "streaming/features/barriers_solid.h"

#include "geo/plan_frame.h"
#include "streaming/clean.h"
#include "streaming/features/barriers_plan.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

namespace gnomon {

namespace {

// How often the ground is asked along a barrier, and what of its course is kept.
constexpr double kStepMetres = 2.0;
constexpr double kCrestTolerance = 0.01, kGroundTolerance = 0.1;
// A solid's outline has at most about so many points (cutting it into triangles takes time by their
// square).
constexpr std::size_t kMostStations = 4000;
constexpr std::size_t kMostVertices = 200000; // of what a file may hold in one polygon
constexpr std::size_t kPieceVertices = 400;

// About the middle of all vertices, found in space: a line may cross the antimeridian or a pole.
PlanFrame frameAround(const FeaturePart& part) {
    glm::dvec3 sum(0.0);
    for (const FeatureRing& ring : part)
        for (const glm::dvec3& p : ring)
            sum += glm::normalize(ecefOf({p.x, p.y, 0.0}).xyz);
    const Geodetic middle = geodeticOf({kEquatorialRadiusMetres * glm::normalize(sum)});
    return PlanFrame({middle.longitudeDegrees, middle.latitudeDegrees});
}

// Heights along a course of stations, to be asked anywhere near it.
struct Course {
    struct Station {
        glm::dvec2 at{0.0};
        double ground = NAN, crest = NAN;
        bool starts = false; // nothing leads here from the station before
    };
    std::vector<Station> stations;

    // Between the two stations that are nearest.
    Station nearest(const glm::dvec2& p) const {
        Station best = stations.front();
        double squared = glm::dot(best.at - p, best.at - p);
        for (std::size_t i = 1; i < stations.size(); ++i) {
            const Station &a = stations[i - 1], &b = stations[i];
            if (b.starts)
                continue;
            const glm::dvec2 along = b.at - a.at;
            const double length = glm::dot(along, along);
            const double t =
                length > 0.0 ? std::clamp(glm::dot(p - a.at, along) / length, 0.0, 1.0) : 0.0;
            const glm::dvec2 at = a.at + t * along;
            const double d = glm::dot(at - p, at - p);
            if (d < squared) {
                squared = d;
                best = {at, glm::mix(a.ground, b.ground, t), glm::mix(a.crest, b.crest, t), false};
            }
        }
        return best;
    }
};

class Builder {
  public:
    Builder(const BarrierFacts& barrier, const FeaturePart& rings, const GroundHeights& ground)
        : barrier_(barrier), rings_(rings), ground_(ground), frame_(frameAround(rings)) {}

    Result<std::vector<BarrierSolid>> run() {
        if (!findCourse())
            return Error{"", "the ground has no height there"};
        std::vector<BarrierSolid> solids;
        for (const PlanPolygon& polygon : polygons()) {
            std::optional<PlanMesh> mesh = triangulated(withStations(polygon));
            if (!mesh)
                continue;
            if (barrier_.isArea && barrier_.crest == CrestFrom::Ground)
                refine(*mesh);
            solids.push_back(solidOf(*mesh));
        }
        if (solids.empty())
            return Error{"", barrier_.isArea ? "it has no area" : "it has no length"};
        return solids;
    }

  private:
    struct Heights {
        double ground = 0.0, crest = 0.0;
    };

    std::vector<PlanPolygon> polygons() const {
        std::vector<PlanRing> rings;
        for (const FeatureRing& ring : rings_) {
            PlanRing& out = rings.emplace_back();
            for (const glm::dvec3& p : ring)
                if (const glm::dvec2 at = frame_.plan(p); out.empty() || out.back() != at)
                    out.push_back(at);
        }
        if (barrier_.isArea)
            return validAreas(rings);
        return rings[0].size() < 2 ? std::vector<PlanPolygon>()
                                   : stripAlong(rings[0], barrier_.widthMetres);
    }

    std::vector<double> groundAt(std::span<const glm::dvec2> places) const {
        std::vector<glm::dvec2> lonLat;
        for (const glm::dvec2& p : places)
            lonLat.push_back(frame_.lonLat(p));
        std::vector<double> heights(places.size());
        ground_.sample(lonLat, heights);
        return heights;
    }

    // False where no station has ground.
    bool findCourse() {
        double length = 0.0;
        eachSegment([&](const glm::dvec3& a, const glm::dvec3& b, bool) {
            length += glm::distance(frame_.plan(a), frame_.plan(b));
        });
        step_ = std::max(kStepMetres, length / double(kMostStations));
        eachSegment([&](const glm::dvec3& a, const glm::dvec3& b, bool starts) {
            const glm::dvec2 from = frame_.plan(a), to = frame_.plan(b);
            const int steps = std::max(1, int(std::ceil(glm::distance(from, to) / step_)));
            for (int i = starts ? 0 : 1; i <= steps; ++i) {
                const double t = double(i) / steps;
                course_.stations.push_back(
                    {glm::mix(from, to, t), NAN, glm::mix(a.z, b.z, t), starts && i == 0});
            }
        });
        if (course_.stations.empty()) // a single point
            course_.stations.push_back({frame_.plan(rings_[0][0]), NAN, rings_[0][0].z, true});
        std::vector<glm::dvec2> places;
        for (const Course::Station& station : course_.stations)
            places.push_back(station.at);
        std::vector<double> ground = groundAt(places);
        if (!fillGaps(ground))
            return false;
        for (std::size_t i = 0; i < ground.size(); ++i) {
            Course::Station& station = course_.stations[i];
            station.ground = ground[i];
            if (barrier_.crest != CrestFrom::Shape)
                station.crest = barrier_.crest == CrestFrom::Level ? barrier_.metres
                                                                   : ground[i] + barrier_.metres;
        }
        return true;
    }

    // `visit(a, b, starts)`: each segment, rings of areas closed.
    template <class Visit>
    void eachSegment(const Visit& visit) const {
        for (const FeatureRing& ring : rings_)
            for (std::size_t i = 0; i + (barrier_.isArea ? 0 : 1) < ring.size(); ++i)
                visit(ring[i], ring[(i + 1) % ring.size()], i == 0);
    }

    // What has no ground takes that of the nearest before it, else behind it.
    static bool fillGaps(std::vector<double>& heights) {
        const auto known = [](double h) { return !std::isnan(h); };
        const auto first = std::ranges::find_if(heights, known);
        if (first == heights.end())
            return false;
        std::fill(heights.begin(), first, *first);
        for (auto at = first; at != heights.end(); ++at)
            if (std::isnan(*at))
                *at = *(at - 1);
        return true;
    }

    // A line's crest is level across: it is that of the nearest place on the line.
    std::vector<Heights> heightsAt(std::span<const glm::dvec2> places) const {
        std::vector<double> ground = groundAt(places);
        std::vector<Heights> out;
        for (std::size_t i = 0; i < places.size(); ++i) {
            const bool own = barrier_.isArea && barrier_.crest == CrestFrom::Ground;
            Course::Station near;
            if (!own || std::isnan(ground[i]))
                near = course_.nearest(places[i]);
            const double below = std::isnan(ground[i]) ? near.ground : ground[i];
            out.push_back({below, own ? below + barrier_.metres : near.crest});
        }
        return out;
    }

    // With points where the ground or the crest turns (Douglas & Peucker's rule).
    PlanPolygon withStations(const PlanPolygon& polygon) const {
        PlanPolygon out;
        for (const PlanRing& ring : polygon.rings) {
            PlanRing& kept = out.rings.emplace_back();
            for (std::size_t i = 0; i < ring.size(); ++i) {
                const glm::dvec2 &a = ring[i], &b = ring[(i + 1) % ring.size()];
                const int steps = std::max(1, int(std::ceil(glm::distance(a, b) / step_)));
                std::vector<glm::dvec2> places;
                for (int k = 0; k <= steps; ++k)
                    places.push_back(glm::mix(a, b, double(k) / steps));
                std::vector<std::uint8_t> keep(places.size(), 0);
                if (steps > 1)
                    markTurns(heightsAt(places), 0, places.size() - 1, keep);
                kept.push_back(a);
                for (std::size_t k = 1; k + 1 < places.size(); ++k)
                    if (keep[k])
                        kept.push_back(places[k]);
            }
        }
        return out;
    }

    static void markTurns(const std::vector<Heights>& heights, std::size_t first, std::size_t last,
                          std::vector<std::uint8_t>& keep) {
        std::size_t worst = first;
        double most = 1.0;
        for (std::size_t i = first + 1; i < last; ++i) {
            const double t = double(i - first) / double(last - first);
            const double off =
                std::max(std::abs(heights[i].crest -
                                  glm::mix(heights[first].crest, heights[last].crest, t)) /
                             kCrestTolerance,
                         std::abs(heights[i].ground -
                                  glm::mix(heights[first].ground, heights[last].ground, t)) /
                             kGroundTolerance);
            if (off > most) {
                most = off;
                worst = i;
            }
        }
        if (worst == first)
            return;
        keep[worst] = 1;
        markTurns(heights, first, worst, keep);
        markTurns(heights, worst, last, keep);
    }

    using Edge = std::pair<std::uint32_t, std::uint32_t>;

    // Halves inner edges along which the ground leaves a straight line, until none is left. What is
    // done to an edge depends on it alone, so the triangles on both sides agree.
    void refine(PlanMesh& mesh) const {
        constexpr int kRounds = 16;
        for (int round = 0; round < kRounds && mesh.points.size() < kMostStations * 4; ++round) {
            std::map<Edge, std::uint32_t> middles;
            for (const Edge& edge : bentEdges(mesh)) {
                middles.emplace(edge, std::uint32_t(mesh.points.size()));
                mesh.points.push_back((mesh.points[edge.first] + mesh.points[edge.second]) / 2.0);
            }
            if (middles.empty())
                return;
            halve(mesh, middles);
        }
    }

    std::vector<Edge> bentEdges(const PlanMesh& mesh) const {
        std::map<Edge, int> uses;
        for (const auto& t : mesh.triangles)
            for (std::size_t i = 0; i < 3; ++i)
                ++uses[std::minmax(t[i], t[(i + 1) % 3])];
        std::vector<Edge> bent;
        for (const auto& [edge, count] : uses) {
            const glm::dvec2 &a = mesh.points[edge.first], &b = mesh.points[edge.second];
            constexpr int kMostSteps = 64;
            const int steps = std::min(kMostSteps, int(glm::distance(a, b) / step_));
            if (count < 2 || steps < 2)
                continue;
            std::vector<glm::dvec2> places;
            for (int k = 0; k <= steps; ++k)
                places.push_back(glm::mix(a, b, double(k) / steps));
            std::vector<std::uint8_t> keep(places.size(), 0);
            markTurns(heightsAt(places), 0, places.size() - 1, keep);
            if (std::ranges::find(keep, 1) != keep.end())
                bent.push_back(edge);
        }
        return bent;
    }

    static void halve(PlanMesh& mesh, const std::map<Edge, std::uint32_t>& middles) {
        std::vector<std::array<std::uint32_t, 3>> out;
        for (const auto& t : mesh.triangles) {
            // Its outline with the new points, cut off corner by corner.
            std::array<std::int64_t, 3> middle{-1, -1, -1}; // behind each corner
            int cut = 0;
            for (std::size_t i = 0; i < 3; ++i)
                if (const auto at = middles.find(std::minmax(t[i], t[(i + 1) % 3]));
                    at != middles.end()) {
                    middle[i] = at->second;
                    ++cut;
                }
            if (cut == 0) {
                out.push_back(t);
                continue;
            }
            std::size_t s = 0; // the first cut edge; with two, the one whose next is cut too
            while (middle[s] < 0 || (cut == 2 && middle[(s + 1) % 3] < 0))
                ++s;
            const std::uint32_t a = t[s], b = t[(s + 1) % 3], c = t[(s + 2) % 3];
            const auto m = std::uint32_t(middle[s]), n = std::uint32_t(middle[(s + 1) % 3]),
                       o = std::uint32_t(middle[(s + 2) % 3]);
            if (cut == 1)
                out.insert(out.end(), {{a, m, c}, {m, b, c}});
            else if (cut == 2)
                out.insert(out.end(), {{m, b, n}, {a, m, n}, {a, n, c}});
            else
                out.insert(out.end(), {{a, m, o}, {m, b, n}, {o, n, c}, {m, n, o}});
        }
        mesh.triangles = std::move(out);
    }

    BarrierSolid solidOf(const PlanMesh& mesh) const {
        const std::vector<Heights> heights = heightsAt(mesh.points);
        const auto count = std::uint32_t(mesh.points.size());
        const auto at = [&](std::uint32_t i, double height) {
            const glm::dvec2 p = frame_.lonLat(mesh.points[i]);
            return ecefOf({p.x, p.y, height});
        };
        BarrierSolid solid;
        solid.material = barrier_.material;
        solid.origin = at(0, heights[0].crest);
        for (const bool top : {true, false})
            for (std::uint32_t i = 0; i < count; ++i) {
                const double base =
                    std::min(heights[i].ground, heights[i].crest) - kBaseDepthMetres;
                solid.positions.push_back(
                    (at(i, top ? heights[i].crest : base) - solid.origin).xyz);
            }
        std::map<Edge, bool> directed;
        for (const auto& t : mesh.triangles) {
            solid.triangles.push_back(t);
            solid.triangles.push_back({t[0] + count, t[2] + count, t[1] + count});
            for (std::size_t i = 0; i < 3; ++i)
                directed[{t[i], t[(i + 1) % 3]}] = true;
        }
        for (const auto& [edge, there] : directed) {
            const auto& [a, b] = edge;
            if (directed.contains({b, a}))
                continue;
            solid.triangles.push_back({a + count, b + count, b});
            solid.triangles.push_back({a + count, b, a});
        }
        return checked(std::move(solid));
    }

    // As the decoders' content is: duplicates dropped, wound outward where closed.
    static BarrierSolid checked(BarrierSolid solid) {
        Transform<Ecef, Tile> ecefFromTile;
        ecefFromTile.matrix[3] = glm::dvec4(solid.origin.xyz, 1.0);
        Soup soup;
        soup.positions = solid.positions;
        soup.normals.resize(soup.positions.size(), glm::vec3(0.0f));
        soup.uvs.resize(soup.positions.size());
        soup.colors.resize(soup.positions.size());
        soup.features.resize(soup.positions.size());
        for (const auto& t : solid.triangles)
            soup.triangles.push_back({{t[0], t[1], t[2]}, 0, 0});
        const CleanSoup cleaned = clean(soup, ecefFromTile);
        solid.triangles.clear();
        for (const Soup::Triangle& t : cleaned.triangles)
            solid.triangles.push_back({t.vertex[0], t.vertex[1], t.vertex[2]});
        solid.closed = cleaned.closed;
        return solid;
    }

    const BarrierFacts& barrier_;
    const FeaturePart& rings_;
    const GroundHeights& ground_;
    PlanFrame frame_;
    Course course_;
    double step_ = kStepMetres;
};

// In the plan, so that a line may cross the antimeridian or a pole.
glm::dvec3 between(const PlanFrame& frame, const glm::dvec3& a, const glm::dvec3& b, double t) {
    return {frame.lonLat(glm::mix(frame.plan(a), frame.plan(b), t)), glm::mix(a.z, b.z, t)};
}

// Segments no longer than half a piece, so that a piece can end in the middle of one.
FeatureRing withShortSegments(const FeatureRing& line, const PlanFrame& frame) {
    FeatureRing out;
    for (std::size_t i = 0; i + 1 < line.size(); ++i) {
        const double length = glm::distance(frame.plan(line[i]), frame.plan(line[i + 1]));
        const int steps = std::max(1, int(std::ceil(2.0 * length / kMaxMeshExtentMetres)));
        for (int k = 0; k < steps; ++k)
            out.push_back(k == 0 ? line[i]
                                 : between(frame, line[i], line[i + 1], double(k) / steps));
    }
    out.push_back(line.back());
    return out;
}

std::vector<FeatureRing> piecesOf(const FeatureRing& whole) {
    const PlanFrame frame = frameAround({whole});
    FeatureRing line = withShortSegments(whole, frame);
    double length = 0.0;
    for (std::size_t i = 0; i + 1 < line.size(); ++i)
        length += glm::distance(frame.plan(line[i]), frame.plan(line[i + 1]));
    if (length <= 1.5 * kMaxMeshExtentMetres && line.size() <= kPieceVertices)
        return {whole};
    if (glm::dvec2(line.front()) == glm::dvec2(line.back())) {
        // Closed: begins and ends in the middle of a segment, so that no corner is left unmitred.
        const glm::dvec3 middle = between(frame, line[0], line[1], 0.5);
        line.front() = middle;
        line.push_back(middle);
    }
    std::vector<FeatureRing> pieces(1, FeatureRing{line.front()});
    double sofar = 0.0;
    for (std::size_t i = 1; i < line.size(); ++i) {
        sofar += glm::distance(frame.plan(line[i - 1]), frame.plan(line[i]));
        pieces.back().push_back(line[i]);
        if (i + 2 < line.size() &&
            (sofar >= kMaxMeshExtentMetres || pieces.back().size() >= kPieceVertices)) {
            const glm::dvec3 middle = between(frame, line[i], line[i + 1], 0.5);
            pieces.back().push_back(middle);
            pieces.push_back({middle});
            sofar = 0.0;
        }
    }
    return pieces;
}

} // namespace

Result<std::vector<BarrierSolid>> solidsOf(const BarrierFacts& barrier,
                                           const GroundHeights& ground) {
    std::size_t vertices = 0;
    for (const FeatureRing& ring : barrier.rings)
        vertices += ring.size();
    if (barrier.isArea && vertices > kMostVertices)
        return Error{"", "its outline has " + std::to_string(vertices) + " vertices, more than " +
                             std::to_string(kMostVertices)};
    if (barrier.isArea)
        return Builder(barrier, barrier.rings, ground).run();
    std::vector<BarrierSolid> all;
    Failure last;
    for (const FeatureRing& piece : piecesOf(barrier.rings.front())) {
        const FeaturePart part{piece};
        Result<std::vector<BarrierSolid>> solids = Builder(barrier, part, ground).run();
        if (!solids) {
            last = solids.error();
            continue;
        }
        for (BarrierSolid& solid : *solids)
            all.push_back(std::move(solid));
    }
    if (all.empty())
        return *last;
    return all;
}

} // namespace gnomon
