#include "streaming/flood/unstructured_topology.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <unordered_map>

namespace gnomon {

namespace {

using Triangle = std::array<std::uint32_t, 3>;

// Twice the area, positive when counter-clockwise.
double cross(glm::dvec2 a, glm::dvec2 b, glm::dvec2 c) {
    return (b.x - a.x) * (c.y - a.y) - (b.y - a.y) * (c.x - a.x);
}

double signedArea(const std::vector<glm::dvec2>& points, std::span<const std::uint32_t> face) {
    double twice = 0.0;
    for (std::size_t i = 1; i + 1 < face.size(); ++i)
        twice += cross(points[face[0]], points[face[i]], points[face[i + 1]]);
    return 0.5 * twice;
}

glm::dvec2 centroid(const std::vector<glm::dvec2>& points, std::span<const std::uint32_t> face) {
    // From the first corner: the products of coordinates far from their origin would cancel.
    const glm::dvec2 base = points[face[0]];
    glm::dvec2 sum(0.0);
    double twice = 0.0;
    for (std::size_t i = 1; i + 1 < face.size(); ++i) {
        const glm::dvec2 b = points[face[i]], c = points[face[i + 1]];
        const double area = cross(base, b, c);
        sum += area * ((b - base) + (c - base));
        twice += area;
    }
    return base + sum / (3.0 * twice);
}

std::span<const std::uint32_t> faceOf(const PolygonMesh& mesh, std::size_t face) {
    return std::span(mesh.corners)
        .subspan(mesh.starts[face], mesh.starts[face + 1] - mesh.starts[face]);
}

bool finite(glm::dvec2 p) {
    return std::isfinite(p.x) && std::isfinite(p.y);
}

// The cosine of a corner's angle: smaller is wider.
double cosine(glm::dvec2 a, glm::dvec2 at, glm::dvec2 b) {
    const glm::dvec2 u = a - at, v = b - at;
    const double lengths = std::sqrt((u.x * u.x + u.y * u.y) * (v.x * v.x + v.y * v.y));
    return lengths > 0.0 ? (u.x * v.x + u.y * v.y) / lengths : 1.0;
}

// The cosine of the sharpest angle of an ear, 2 when it cannot be cut off.
double sharpness(const std::vector<glm::dvec2>& points, std::span<const std::uint32_t> polygon,
                 std::size_t tip) {
    const std::size_t n = polygon.size();
    const glm::dvec2 a = points[polygon[(tip + n - 1) % n]], b = points[polygon[tip]],
                     c = points[polygon[(tip + 1) % n]];
    if (!(cross(a, b, c) > 0.0))
        return 2.0;
    for (std::size_t i = 2; i + 1 < n; ++i) {
        const glm::dvec2 p = points[polygon[(tip + i) % n]];
        if (cross(a, b, p) >= 0.0 && cross(b, c, p) >= 0.0 && cross(c, a, p) >= 0.0)
            return 2.0;
    }
    return std::max({cosine(c, a, b), cosine(a, b, c), cosine(b, c, a)});
}

// Cuts off the bluntest ear again and again; false when that does not end (lines that cross).
bool cutIntoTriangles(const std::vector<glm::dvec2>& points, std::vector<std::uint32_t> polygon,
                      std::vector<Triangle>& triangles) {
    const std::size_t before = triangles.size();
    while (polygon.size() >= 3) {
        std::size_t best = 0;
        double least = 2.0;
        for (std::size_t tip = 0; tip < polygon.size(); ++tip) {
            // Equal but for rounding: the first, so that a regular grid is cut the same everywhere.
            constexpr double kSame = 1e-9;
            const double sharp = sharpness(points, polygon, tip);
            if (sharp < least - kSame) {
                least = sharp;
                best = tip;
            }
        }
        if (least >= 2.0 - 1e-9) {
            // What is left may lie on a line: nothing to cover.
            if (std::abs(signedArea(points, polygon)) <= 0.0)
                return true;
            triangles.resize(before);
            return false;
        }
        const std::size_t n = polygon.size();
        triangles.push_back({polygon[(best + n - 1) % n], polygon[best], polygon[(best + 1) % n]});
        polygon.erase(polygon.begin() + std::ptrdiff_t(best));
    }
    return true;
}

// A face without corners that repeat, counter-clockwise; empty when it is none.
std::vector<std::uint32_t> tidied(const PolygonMesh& mesh, std::size_t face) {
    std::vector<std::uint32_t> kept;
    for (const std::uint32_t corner : faceOf(mesh, face)) {
        if (corner >= mesh.points.size() || !finite(mesh.points[corner]))
            return {};
        if (kept.empty() || kept.back() != corner)
            kept.push_back(corner);
    }
    while (kept.size() > 1 && kept.front() == kept.back())
        kept.pop_back();
    if (kept.size() < 3 || kept.size() > kMaxFaceCorners)
        return {};
    const double area = signedArea(mesh.points, kept);
    if (!(std::abs(area) > 0.0) || !std::isfinite(area))
        return {};
    if (area < 0.0)
        std::reverse(kept.begin(), kept.end());
    return kept;
}

// One corner of a face, seen from the point there.
struct Corner {
    std::uint32_t next, before, face; // the face's points after and before this one
};

// The corners at each point, sorted by `next`.
struct Fans {
    std::vector<std::uint32_t> starts;
    std::vector<Corner> corners;

    std::span<Corner> at(std::size_t point) {
        return std::span(corners).subspan(starts[point], starts[point + 1] - starts[point]);
    }
};

Fans fansOf(const PolygonMesh& mesh) {
    Fans fans;
    fans.starts.assign(mesh.points.size() + 1, 0);
    for (const std::uint32_t corner : mesh.corners)
        ++fans.starts[corner + 1];
    for (std::size_t p = 0; p < mesh.points.size(); ++p)
        fans.starts[p + 1] += fans.starts[p];
    fans.corners.resize(mesh.corners.size());
    std::vector<std::uint32_t> fill(fans.starts.begin(), fans.starts.end() - 1);
    for (std::size_t f = 0; f < mesh.faces(); ++f) {
        const auto face = faceOf(mesh, f);
        for (std::size_t i = 0; i < face.size(); ++i)
            fans.corners[fill[face[i]]++] = {face[(i + 1) % face.size()],
                                             face[(i + face.size() - 1) % face.size()],
                                             std::uint32_t(f)};
    }
    for (std::size_t p = 0; p < mesh.points.size(); ++p) {
        const auto fan = fans.at(p);
        std::sort(fan.begin(), fan.end(), [](const Corner& a, const Corner& b) {
            return a.next != b.next ? a.next < b.next : a.face < b.face;
        });
    }
    return fans;
}

const Corner* withNext(std::span<const Corner> fan, std::uint32_t next) {
    const auto found = std::lower_bound(
        fan.begin(), fan.end(), next, [](const Corner& c, std::uint32_t n) { return c.next < n; });
    return found != fan.end() && found->next == next ? &*found : nullptr;
}

// Points of smaller faces that lie in the middle of a larger one's edge, as in quadtrees: the
// larger face is given them as corners, so that neighbours meet.
class HangingPoints {
  public:
    HangingPoints(const PolygonMesh& mesh, Fans& fans) : points_(mesh.points) {
        double shortest = std::numeric_limits<double>::infinity();
        std::vector<std::uint32_t> rim;
        for (std::uint32_t p = 0; p < points_.size(); ++p)
            for (const Corner& corner : fans.at(p))
                if (withNext(fans.at(corner.next), p) == nullptr) {
                    const glm::dvec2 d = points_[corner.next] - points_[p];
                    const double edge = std::hypot(d.x, d.y);
                    if (edge > 0.0)
                        shortest = std::min(shortest, edge);
                    rim.push_back(p);
                    rim.push_back(corner.next);
                }
        // Coordinates in float, rounded to some 1e-7 of their size, may lie this far off.
        tolerance_ = 1e-2 * shortest;
        for (const std::uint32_t p : rim)
            at_.emplace(key(points_[p], 0, 0), p);
    }

    bool any() const { return !at_.empty(); }

    void insertInto(std::vector<std::uint32_t>& face, Fans& fans) const {
        std::vector<std::uint32_t> with;
        for (std::size_t i = 0; i < face.size(); ++i) {
            const std::uint32_t a = face[i], b = face[(i + 1) % face.size()];
            with.push_back(a);
            if (withNext(fans.at(b), a) == nullptr)
                between(a, b, kMaxHalvings, with);
        }
        if (with.size() <= kMaxFaceCorners)
            face = std::move(with);
    }

  private:
    static constexpr int kMaxHalvings = 3; // neighbours that differ by three levels

    std::uint64_t key(glm::dvec2 p, int dx, int dy) const {
        const auto column = std::uint64_t(std::int64_t(std::floor(p.x / (4 * tolerance_))) + dx);
        const auto row = std::uint64_t(std::int64_t(std::floor(p.y / (4 * tolerance_))) + dy);
        return column * 0x9E3779B97F4A7C15u ^ (row + 0x7F4A7C15u) * 0xC2B2AE3D27D4EB4Fu;
    }
    void between(std::uint32_t a, std::uint32_t b, int halvings,
                 std::vector<std::uint32_t>& out) const {
        if (halvings == 0)
            return;
        const glm::dvec2 middle = 0.5 * (points_[a] + points_[b]);
        for (int dy = -1; dy <= 1; ++dy)
            for (int dx = -1; dx <= 1; ++dx) {
                const auto found = at_.find(key(middle, dx, dy));
                if (found == at_.end() || found->second == a || found->second == b)
                    continue;
                const glm::dvec2 d = points_[found->second] - middle;
                if (std::hypot(d.x, d.y) > tolerance_)
                    continue;
                between(a, found->second, halvings - 1, out);
                out.push_back(found->second);
                between(found->second, b, halvings - 1, out);
                return;
            }
    }

    const std::vector<glm::dvec2>& points_;
    double tolerance_ = 0.0;
    std::unordered_map<std::uint64_t, std::uint32_t> at_;
};

void joinHangingPoints(PolygonMesh& mesh) {
    Fans fans = fansOf(mesh);
    const HangingPoints hanging(mesh, fans);
    if (!hanging.any())
        return;
    PolygonMesh joined;
    for (std::size_t f = 0; f < mesh.faces(); ++f) {
        const auto face = faceOf(mesh, f);
        std::vector<std::uint32_t> corners(face.begin(), face.end());
        hanging.insertInto(corners, fans);
        joined.addFace(corners.data(), corners.size());
    }
    mesh.corners = std::move(joined.corners);
    mesh.starts = std::move(joined.starts);
}

// Triangles between the centroids of a mesh's faces and the points of its rim.
class Dual {
  public:
    Dual(const PolygonMesh& mesh, NodeMesh& out)
        : mesh_(mesh), fans_(fansOf(mesh)), out_(out), nodeOfPoint_(mesh.points.size(), kNone) {}

    void build() {
        for (std::uint32_t p = 0; p < mesh_.points.size(); ++p)
            around(p);
    }

  private:
    static constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();

    // The faces at a point, in chains from one open edge to another or in rings.
    void around(std::uint32_t point) {
        const std::span<Corner> fan = fans_.at(point);
        used_.assign(fan.size(), false);
        for (std::size_t i = 0; i < fan.size(); ++i)
            if (withNext(fans_.at(fan[i].next), point) == nullptr) {
                chain(fan, i);
                rimEdge(point, fan[i]);
                open(point);
            }
        for (std::size_t i = 0; i < fan.size(); ++i)
            if (!used_[i]) {
                const bool closed = chain(fan, i);
                if (closed)
                    ring(point);
                else
                    open(point);
            }
    }

    // Counter-clockwise from one corner on; true when it comes back to it.
    bool chain(std::span<const Corner> fan, std::size_t first) {
        ring_.clear();
        for (std::size_t at = first; !used_[at];) {
            used_[at] = true;
            ring_.push_back(fan[at].face);
            const Corner* next = withNext(fan, fan[at].before);
            if (next == nullptr)
                return false;
            at = std::size_t(next - fan.data());
            if (at == first)
                return true;
        }
        return false;
    }

    void add(std::uint32_t a, std::uint32_t b, std::uint32_t c) {
        if (cross(out_.positions[a], out_.positions[b], out_.positions[c]) > 0.0)
            out_.triangles.push_back({a, b, c});
    }

    std::uint32_t nodeAt(std::uint32_t point) {
        std::uint32_t& node = nodeOfPoint_[point];
        if (node == kNone) {
            node = std::uint32_t(out_.positions.size());
            out_.positions.push_back(mesh_.points[point]);
            for (const Corner& corner : fans_.at(point))
                out_.meanOf.push_back(corner.face);
            out_.meanStarts.push_back(std::uint32_t(out_.meanOf.size()));
        }
        return node;
    }

    void rimEdge(std::uint32_t point, const Corner& corner) {
        const std::uint32_t a = nodeAt(point), b = nodeAt(corner.next);
        add(a, b, corner.face);
    }

    void open(std::uint32_t point) {
        const std::uint32_t node = nodeAt(point);
        for (std::size_t i = 0; i + 1 < ring_.size(); ++i)
            add(node, ring_[i], ring_[i + 1]);
    }

    void ring(std::uint32_t point) {
        if (ring_.size() < 3) // two faces that share both edges here: nothing between them
            return;
        if (ring_.size() <= kMaxFaceCorners &&
            cutIntoTriangles(out_.positions, ring_, out_.triangles))
            return;
        ring_.push_back(ring_.front());
        open(point);
    }

    const PolygonMesh& mesh_;
    Fans fans_;
    NodeMesh& out_;
    std::vector<std::uint32_t> nodeOfPoint_;
    std::vector<std::uint32_t> ring_;
    std::vector<bool> used_;
};

void nodesAtFaces(PolygonMesh& mesh, NodeMesh& out) {
    for (std::size_t f = 0; f < mesh.faces(); ++f) {
        const auto face = faceOf(mesh, f);
        out.positions.push_back(centroid(mesh.points, face));
        out.faceArea.push_back(signedArea(mesh.points, face));
    }
    joinHangingPoints(mesh);
    Dual(mesh, out).build();
}

void nodesAtPoints(const PolygonMesh& mesh, NodeMesh& out) {
    constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
    std::vector<std::uint32_t> nodeOf(mesh.points.size(), kNone);
    for (const std::uint32_t corner : mesh.corners)
        nodeOf[corner] = 0;
    for (std::uint32_t p = 0; p < mesh.points.size(); ++p)
        if (nodeOf[p] != kNone) {
            nodeOf[p] = std::uint32_t(out.positions.size());
            out.positions.push_back(mesh.points[p]);
            out.source.push_back(p);
        }
    for (std::size_t f = 0; f < mesh.faces(); ++f) {
        std::vector<std::uint32_t> polygon;
        for (const std::uint32_t corner : faceOf(mesh, f))
            polygon.push_back(nodeOf[corner]);
        if (!cutIntoTriangles(out.positions, std::move(polygon), out.triangles))
            ++out.unusableFaces;
    }
}

} // namespace

void PolygonMesh::addFace(const std::uint32_t* first, std::size_t count) {
    corners.insert(corners.end(), first, first + count);
    starts.push_back(std::uint32_t(corners.size()));
}

NodeMesh nodesOf(PolygonMesh mesh, ValuesAt at) {
    NodeMesh out;
    PolygonMesh tidy;
    std::vector<std::uint32_t> kept;
    for (std::size_t f = 0; f < mesh.faces(); ++f) {
        const std::vector<std::uint32_t> face = tidied(mesh, f);
        if (!face.empty()) {
            tidy.addFace(face.data(), face.size());
            kept.push_back(std::uint32_t(f));
        } else if (faceOf(mesh, f).size() < 3) {
            ++out.emptySlots;
        } else {
            ++out.unusableFaces;
        }
    }
    tidy.points = std::move(mesh.points);
    if (at == ValuesAt::Points) {
        nodesAtPoints(tidy, out);
    } else {
        out.source = std::move(kept);
        nodesAtFaces(tidy, out);
    }
    return out;
}

} // namespace gnomon
