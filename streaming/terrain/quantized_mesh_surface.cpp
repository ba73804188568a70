#include "streaming/terrain/quantized_mesh_surface.h"

#include "geo/ellipsoid.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

namespace gnomon {

namespace {

constexpr double kMost = kQuantizedMost;
// First eccentricity of the ellipsoid, squared.
constexpr double kEccentricity2 = 1.0 - (kPolarRadiusMetres * kPolarRadiusMetres) /
                                            (kEquatorialRadiusMetres * kEquatorialRadiusMetres);

// Quantized tiles have many vertices, but few columns and rows: sines, cosines and the radius of
// curvature of each are found once.
class Placer {
  public:
    Placer(const std::array<double, 4>& extent, std::size_t vertices) : extent_(extent) {
        // Below this the tables cost more than they save.
        constexpr std::size_t kWorthTables = 16384;
        if (vertices >= kWorthTables) {
            columns_.resize(kQuantizedMost + 1);
            rows_.resize(kQuantizedMost + 1);
        }
    }

    glm::dvec3 ecef(glm::dvec2 place, double height) {
        Angle columnHere, rowHere;
        const Angle& lon = angle(columns_, place.x, columnHere, extent_[0], extent_[2]);
        const Angle& lat = angle(rows_, place.y, rowHere, extent_[1], extent_[3]);
        const double out = (lat.radius + height) * lat.cosine;
        return {out * lon.cosine, out * lon.sine,
                ((1.0 - kEccentricity2) * lat.radius + height) * lat.sine};
    }

  private:
    struct Angle {
        double cosine = 0, sine = 0, radius = 0; // radius 0: not known yet
    };

    static Angle found(double at, double low, double high) {
        const double radians = std::lerp(low, high, at / kMost) * kRadiansPerDegree;
        Angle a{std::cos(radians), std::sin(radians), 0.0};
        a.radius = kEquatorialRadiusMetres / std::sqrt(1.0 - kEccentricity2 * a.sine * a.sine);
        return a;
    }
    static const Angle& angle(std::vector<Angle>& known, double at, Angle& here, double low,
                              double high) {
        const auto whole = std::size_t(at);
        if (known.empty() || double(whole) != at) // of a cut
            return here = found(at, low, high);
        if (known[whole].radius == 0.0)
            known[whole] = found(at, low, high);
        return known[whole];
    }

    std::array<double, 4> extent_;
    std::vector<Angle> columns_, rows_;
};

glm::vec3 unfolded(const std::array<std::uint8_t, 2>& oct) {
    const float x = float(oct[0]) * (2.0f / 255.0f) - 1.0f;
    const float y = float(oct[1]) * (2.0f / 255.0f) - 1.0f;
    glm::vec3 n(x, y, 1.0f - std::abs(x) - std::abs(y));
    if (n.z < 0.0f) {
        n.x = std::copysign(1.0f - std::abs(y), x);
        n.y = std::copysign(1.0f - std::abs(x), y);
    }
    return n;
}

struct Corner {
    glm::dvec2 place;
    double height = 0;
    glm::vec3 normal{0.0f};
};

// The same for both triangles of an edge, whichever way they run along it.
Corner between(const Corner& p, const Corner& q, int axis, double line) {
    const auto before = [](const Corner& l, const Corner& r) {
        return l.place.x != r.place.x   ? l.place.x < r.place.x
               : l.place.y != r.place.y ? l.place.y < r.place.y
                                        : l.height < r.height;
    };
    const Corner& a = before(p, q) ? p : q;
    const Corner& b = before(p, q) ? q : p;
    const double t = (line - a.place[axis]) / (b.place[axis] - a.place[axis]);
    Corner out;
    out.place = a.place + t * (b.place - a.place);
    out.place[axis] = line;
    out.height = a.height + t * (b.height - a.height);
    out.normal = a.normal + float(t) * (b.normal - a.normal);
    return out;
}

using Polygon = std::vector<Corner>;

// A convex polygon in two along a line.
void divide(const Polygon& polygon, int axis, double line, Polygon& below, Polygon& above) {
    below.clear();
    above.clear();
    for (std::size_t i = 0; i < polygon.size(); ++i) {
        const Corner& a = polygon[i];
        const Corner& b = polygon[(i + 1) % polygon.size()];
        const double da = a.place[axis] - line, db = b.place[axis] - line;
        if (da <= 0.0)
            below.push_back(a);
        if (da >= 0.0)
            above.push_back(a);
        if ((da < 0.0 && db > 0.0) || (da > 0.0 && db < 0.0)) {
            const Corner middle = between(a, b, axis, line);
            below.push_back(middle);
            above.push_back(middle);
        }
    }
}

double areaOf(const Polygon& polygon) {
    double area = 0.0;
    for (std::size_t i = 2; i < polygon.size(); ++i) {
        const glm::dvec2 a = polygon[i - 1].place - polygon[0].place;
        const glm::dvec2 b = polygon[i].place - polygon[0].place;
        area += 0.5 * (a.x * b.y - a.y * b.x);
    }
    return area;
}

std::vector<double> linesBetween(double from, double to, int cells) {
    std::vector<double> lines;
    for (int i = 0; i <= cells; ++i)
        lines.push_back(std::lerp(from, to, double(i) / cells));
    return lines;
}

class CutOut {
  public:
    CutOut(const QuantizedTile& tile, const QuantizedWindow& window, int cells)
        : tile_(tile), columns_(linesBetween(window.west, window.east, cells)),
          rows_(linesBetween(window.south, window.north, cells)) {
        part_.window = window;
    }

    // False when the pieces are too many: triangles that lie over each other.
    bool run() {
        Polygon triangle(3);
        for (std::size_t i = 0; i + 2 < tile_.indices.size(); i += 3) {
            if (part_.indices.size() > kMostIndices)
                return false;
            for (std::size_t k = 0; k < 3; ++k)
                triangle[k] = corner(tile_.indices[i + k]);
            strips(triangle, 0, columns_, [&](const Polygon& strip) {
                strips(strip, 1, rows_, [&](const Polygon& piece) { keep(piece); });
            });
        }
        if (tile_.normals.empty())
            part_.normals.clear();
        return true;
    }
    QuantizedPart take() { return std::move(part_); }

  private:
    Corner corner(std::uint32_t i) const {
        Corner c;
        c.place = {tile_.u[i], tile_.v[i]};
        c.height = tile_.heightMetres(tile_.height[i]);
        if (!tile_.normals.empty())
            c.normal = unfolded(tile_.normals[i]);
        return c;
    }

    // What of it lies between neighbouring lines, for each pair of them.
    template <class Take>
    static void strips(const Polygon& polygon, int axis, const std::vector<double>& lines,
                       const Take& take) {
        double low = kMost + 1.0, high = -1.0;
        for (const Corner& c : polygon) {
            low = std::min(low, c.place[axis]);
            high = std::max(high, c.place[axis]);
        }
        if (high <= lines.front() || low >= lines.back())
            return;
        auto line = std::upper_bound(lines.begin(), lines.end() - 1, low);
        Polygon rest = polygon, below, above;
        if (line == lines.begin() || low < *(line - 1)) {
            divide(rest, axis, lines.front(), below, above);
            rest.swap(above);
            line = lines.begin() + 1;
        }
        for (; line != lines.end() && rest.size() >= 3; ++line) {
            if (high <= *line) {
                take(rest);
                return;
            }
            divide(rest, axis, *line, below, above);
            if (below.size() >= 3)
                take(below);
            rest.swap(above);
        }
    }

    void keep(const Polygon& piece) {
        if (piece.size() < 3 || !(areaOf(piece) > 0.0))
            return;
        const std::uint32_t first = vertex(piece[0]);
        std::uint32_t last = vertex(piece[1]);
        for (std::size_t i = 2; i < piece.size(); ++i) {
            const std::uint32_t next = vertex(piece[i]);
            if (first != last && last != next && next != first)
                part_.indices.insert(part_.indices.end(), {first, last, next});
            last = next;
        }
    }

    // Found again by value: an open-addressing table that doubles when it is half full.
    std::uint32_t vertex(const Corner& c) {
        if (2 * part_.places.size() >= table_.size())
            grow();
        std::size_t at = hash(c.place, c.height) & (table_.size() - 1);
        for (; table_[at] != kNone; at = (at + 1) & (table_.size() - 1)) {
            const std::uint32_t i = table_[at];
            if (part_.places[i] == c.place && part_.heights[i] == c.height)
                return i;
        }
        table_[at] = std::uint32_t(part_.places.size());
        part_.places.push_back(c.place);
        part_.heights.push_back(c.height);
        part_.normals.push_back(c.normal);
        return table_[at];
    }
    static std::size_t hash(glm::dvec2 place, double height) {
        std::uint64_t h = 0;
        for (const double v : {place.x, place.y, height}) {
            h = (h ^ std::bit_cast<std::uint64_t>(v)) * 0x9e3779b97f4a7c15ull;
            h ^= h >> 29;
        }
        return std::size_t(h);
    }
    void grow() {
        table_.assign(std::max<std::size_t>(1024, 2 * table_.size()), kNone);
        for (std::uint32_t i = 0; i < part_.places.size(); ++i) {
            std::size_t at = hash(part_.places[i], part_.heights[i]) & (table_.size() - 1);
            while (table_[at] != kNone)
                at = (at + 1) & (table_.size() - 1);
            table_[at] = i;
        }
    }

    static constexpr std::uint32_t kNone = 0xffffffffu;
    // Of tiles as large as any that was seen, cut into cells; 200 MB.
    static constexpr std::size_t kMostIndices = 3u * (std::size_t(1) << 21);
    const QuantizedTile& tile_;
    std::vector<double> columns_, rows_;
    QuantizedPart part_;
    std::vector<std::uint32_t> table_;
};

// Edges along the window's sides, the surface to the left of them.
void findBorders(const QuantizedPart& part, TerrainSurface& surface) {
    enum : std::uint8_t { West = 1, South = 2, East = 4, North = 8 };
    std::vector<std::uint8_t> sides(part.places.size());
    const QuantizedWindow& w = part.window;
    for (std::size_t i = 0; i < sides.size(); ++i) {
        const glm::dvec2 p = part.places[i];
        sides[i] = std::uint8_t((p.x == w.west ? West : 0) | (p.y == w.south ? South : 0) |
                                (p.x == w.east ? East : 0) | (p.y == w.north ? North : 0));
    }
    const auto look = [&](std::uint32_t a, std::uint32_t b) {
        const std::uint8_t both = sides[a] & sides[b];
        if (both == 0)
            return;
        const glm::dvec2 along = part.places[b] - part.places[a];
        if (((both & South) && along.x > 0) || ((both & East) && along.y > 0) ||
            ((both & North) && along.x < 0) || ((both & West) && along.y < 0))
            surface.borders.push_back({a, b});
    };
    for (std::size_t i = 0; i + 2 < part.indices.size(); i += 3) {
        look(part.indices[i], part.indices[i + 1]);
        look(part.indices[i + 1], part.indices[i + 2]);
        look(part.indices[i + 2], part.indices[i]);
    }
}

} // namespace

std::array<double, 4> extentOf(const QuantizedPlace& place, bool webMercator) {
    const double side = std::ldexp(webMercator ? 360.0 : 180.0, -int(place.level));
    const double west = -180.0 + side * place.x;
    if (!webMercator)
        return {west, -90.0 + side * place.y, west + side, -90.0 + side * (place.y + 1.0)};
    // Rows are even in Mercator's y, from -pi to pi.
    const auto latitude = [&](double row) {
        const double y = std::numbers::pi * (2.0 * row * std::ldexp(1.0, -int(place.level)) - 1.0);
        return std::atan(std::sinh(y)) / kRadiansPerDegree;
    };
    return {west, latitude(place.y), west + side, latitude(place.y + 1.0)};
}

glm::dvec2 metresOf(const std::array<double, 4>& extent) {
    const double degree = kEquatorialRadiusMetres * kRadiansPerDegree;
    // The widest of its rows.
    const double nearest = extent[1] <= 0.0 && extent[3] >= 0.0
                               ? 0.0
                               : std::min(std::abs(extent[1]), std::abs(extent[3]));
    return {(extent[2] - extent[0]) * degree * std::cos(nearest * kRadiansPerDegree),
            (extent[3] - extent[1]) * degree};
}

glm::dvec2 lonLatOf(glm::dvec2 place, const std::array<double, 4>& extent) {
    return {std::lerp(extent[0], extent[2], place.x / kMost),
            std::lerp(extent[1], extent[3], place.y / kMost)};
}

QuantizedPart wholeOf(QuantizedTile tile) {
    QuantizedPart part;
    part.places.resize(tile.u.size());
    part.heights.resize(tile.u.size());
    for (std::size_t i = 0; i < tile.u.size(); ++i) {
        part.places[i] = {tile.u[i], tile.v[i]};
        part.heights[i] = tile.heightMetres(tile.height[i]);
    }
    part.normals.resize(tile.normals.size());
    for (std::size_t i = 0; i < tile.normals.size(); ++i)
        part.normals[i] = unfolded(tile.normals[i]);
    part.indices = std::move(tile.indices);
    return part;
}

std::optional<QuantizedPart> cutOut(const QuantizedTile& tile, const QuantizedWindow& window,
                                    int cells) {
    CutOut cut(tile, window, std::max(1, cells));
    return cut.run() ? std::optional(cut.take()) : std::nullopt;
}

TerrainSurface surfaceOf(QuantizedPart& part, const std::array<double, 4>& tileExtent,
                         std::vector<std::string>& warnings) {
    TerrainSurface surface;
    const QuantizedWindow& w = part.window;
    const glm::dvec2 southWest(w.west, w.south), northEast(w.east, w.north);
    const glm::dvec2 middle = lonLatOf(0.5 * (southWest + northEast), tileExtent);
    surface.origin = ecefOf({middle.x, middle.y, part.heights.empty() ? 0.0 : part.heights[0]});
    const glm::dvec2 low = lonLatOf(southWest, tileExtent);
    const glm::dvec2 high = lonLatOf(northEast, tileExtent);
    surface.sizeMetres = metresOf({low.x, low.y, high.x, high.y});
    Placer placer(tileExtent, part.places.size());
    surface.positions.resize(part.places.size());
    surface.places.resize(part.places.size());
    const glm::dvec2 scale = 1.0 / (northEast - southWest);
    bool lookUp = true;
    for (std::size_t i = 0; i < part.places.size(); ++i) {
        const glm::dvec3 p = placer.ecef(part.places[i], part.heights[i]);
        surface.positions[i] = p - surface.origin.xyz;
        const glm::dvec2 place = (part.places[i] - southWest) * scale;
        surface.places[i] = glm::vec2(float(place.x), float(1.0 - place.y));
        if (!part.normals.empty())
            lookUp = lookUp && glm::dot(glm::dvec3(part.normals[i]), p) > 0.0;
    }
    if (lookUp)
        surface.normals = std::move(part.normals);
    else
        warnings.push_back("some of its normals look down; all were made from its triangles");
    findBorders(part, surface);
    surface.indices = std::move(part.indices);
    return surface;
}

QuantizedHeights::QuantizedHeights(QuantizedPart part, const std::array<double, 4>& tileExtent)
    : part_(std::move(part)), extent_(tileExtent) {
    const std::size_t count = part_.indices.size() / 3;
    constexpr double kTrianglesACell = 2.0;
    constexpr double kMostCells = 512.0; // a side
    side_ = int(std::clamp(std::sqrt(double(count) / kTrianglesACell), 1.0, kMostCells));
    const auto cell = [&](double at) { return std::clamp(int(at / kMost * side_), 0, side_ - 1); };
    const auto eachBox = [&](const auto& take) {
        for (std::uint32_t t = 0; t < count; ++t) {
            const glm::dvec2 a = part_.places[part_.indices[3 * t]];
            const glm::dvec2 b = part_.places[part_.indices[3 * t + 1]];
            const glm::dvec2 c = part_.places[part_.indices[3 * t + 2]];
            const glm::dvec2 low = glm::min(a, glm::min(b, c)), high = glm::max(a, glm::max(b, c));
            take(t, glm::ivec2(cell(low.x), cell(low.y)), glm::ivec2(cell(high.x), cell(high.y)));
        }
    };
    // Triangles that lie over each other would be told of in every cell.
    for (;; side_ /= 2) {
        std::uint64_t entries = 0;
        eachBox([&](std::uint32_t, glm::ivec2 low, glm::ivec2 high) {
            entries += std::uint64_t(high.x - low.x + 1) * std::uint64_t(high.y - low.y + 1);
        });
        if (entries <= 16 * count + 1024 || side_ == 1)
            break;
    }
    const auto eachCell = [&](const auto& take) {
        eachBox([&](std::uint32_t t, glm::ivec2 low, glm::ivec2 high) {
            for (int row = low.y; row <= high.y; ++row)
                for (int column = low.x; column <= high.x; ++column)
                    take(std::size_t(row) * std::size_t(side_) + std::size_t(column), t);
        });
    };
    starts_.assign(std::size_t(side_) * std::size_t(side_) + 1, 0);
    eachCell([&](std::size_t at, std::uint32_t) { ++starts_[at + 1]; });
    for (std::size_t i = 1; i < starts_.size(); ++i)
        starts_[i] += starts_[i - 1];
    triangles_.resize(starts_.back());
    std::vector<std::uint32_t> next(starts_.begin(), starts_.end() - 1);
    eachCell([&](std::size_t at, std::uint32_t t) { triangles_[next[at]++] = t; });
}

bool QuantizedHeights::heightIn(std::uint32_t triangle, glm::dvec2 place, glm::dvec2 lonLat,
                                double& height) const {
    glm::dvec2 corners[3];
    for (std::size_t k = 0; k < 3; ++k)
        corners[k] = part_.places[part_.indices[3 * triangle + k]];
    const auto turn = [](glm::dvec2 a, glm::dvec2 b, glm::dvec2 p) {
        return (b.x - a.x) * (p.y - a.y) - (b.y - a.y) * (p.x - a.x);
    };
    const double area = turn(corners[0], corners[1], corners[2]);
    if (!(area > 0.0))
        return false;
    // Places on an edge belong to both sides, whatever rounding says.
    const double slack = -1e-9 * area;
    for (std::size_t k = 0; k < 3; ++k)
        if (turn(corners[k], corners[(k + 1) % 3], place) < slack)
            return false;
    glm::dvec3 p[3];
    for (std::size_t k = 0; k < 3; ++k) {
        const glm::dvec2 at = lonLatOf(corners[k], extent_);
        p[k] = ecefOf({at.x, at.y, part_.heights[part_.indices[3 * triangle + k]]}).xyz;
    }
    const Transform<Ecef, Enu> local = ecefFromEnu({lonLat.x, lonLat.y, 0.0});
    const glm::dvec3 normal = glm::cross(p[1] - p[0], p[2] - p[0]);
    const double rise = glm::dot(normal, local.axes()[2]);
    if (!(rise > 0.0))
        return false;
    height = glm::dot(normal, p[0] - local.origin().xyz) / rise;
    return true;
}

double QuantizedHeights::at(glm::dvec2 lonLat) const {
    const glm::dvec2 place = glm::dvec2((lonLat.x - extent_[0]) / (extent_[2] - extent_[0]),
                                        (lonLat.y - extent_[1]) / (extent_[3] - extent_[1])) *
                             kMost;
    double height = std::numeric_limits<double>::quiet_NaN();
    if (!(place.x >= 0.0 && place.y >= 0.0 && place.x <= kMost && place.y <= kMost))
        return height;
    const auto cell = [&](double at) {
        return std::size_t(std::clamp(int(at / kMost * side_), 0, side_ - 1));
    };
    const std::size_t at = cell(place.y) * std::size_t(side_) + cell(place.x);
    for (std::uint32_t i = starts_[at]; i < starts_[at + 1]; ++i)
        if (heightIn(triangles_[i], place, lonLat, height))
            return height;
    return height;
}

std::size_t QuantizedHeights::bytes() const {
    return part_.places.size() * (sizeof(glm::dvec2) + sizeof(double)) +
           (part_.indices.size() + starts_.size() + triangles_.size()) * sizeof(std::uint32_t);
}

} // namespace gnomon
