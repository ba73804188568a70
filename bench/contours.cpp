#include "bench/contours.h"

#include "bench/reference.h"

#include <glm/common.hpp>
#include <glm/geometric.hpp>
#include <glm/vec2.hpp>

#include <algorithm>
#include <cmath>

namespace gnomon::bench {

namespace {

struct Segment {
    glm::dvec2 from, to;
};

double distanceTo(const Segment& s, const glm::dvec2& p) {
    const glm::dvec2 along = s.to - s.from;
    const double square = glm::dot(along, along);
    const double t =
        square > 0.0 ? glm::clamp(glm::dot(p - s.from, along) / square, 0.0, 1.0) : 0.0;
    return glm::length(p - s.from - t * along);
}

// A picture's contours: the points where they cross the lines between pixels, and the pieces
// between these, at most two in the square between four pixels.
class Contour {
  public:
    Contour(const Contours& where, std::span<const float> values) : where_(where), values_(values) {
        for (int y = 0; y < where.height; ++y)
            for (int x = 0; x < where.width; ++x) {
                firstOf_.push_back(std::uint32_t(segments_.size()));
                for (const std::optional<glm::dvec2>& point : {right(x, y), below(x, y)})
                    if (point)
                        points_.push_back(*point);
                if (x + 1 < where.width && y + 1 < where.height)
                    fill(x, y);
            }
        firstOf_.push_back(std::uint32_t(segments_.size()));
    }

    const std::vector<glm::dvec2>& points() const { return points_; }

    // Rings of squares around the point's own, until none farther out can be nearer.
    double nearest(const glm::dvec2& p) const {
        const int cx = int(std::floor(p.x)), cy = int(std::floor(p.y));
        double best = kMostEdgePixels;
        for (int r = 0; double(r) - 1.0 < best; ++r)
            for (int y = cy - r; y <= cy + r; ++y) {
                const bool whole = y == cy - r || y == cy + r;
                for (int x = cx - r; x <= cx + r; x += whole || r == 0 ? 1 : 2 * r)
                    best = std::min(best, nearestIn(x, y, p));
            }
        return best;
    }

  private:
    std::size_t index(int x, int y) const { return std::size_t(y) * std::size_t(where_.width) + x; }
    float value(int x, int y) const { return values_[index(x, y)]; }

    // Where the contour crosses between two pixels, 0 at the first.
    static std::optional<double> crossing(float a, float b) {
        if ((a >= 0.5f) == (b >= 0.5f))
            return {};
        return (0.5 - double(a)) / (double(b) - double(a));
    }
    std::optional<glm::dvec2> right(int x, int y) const {
        if (x + 1 >= where_.width || !(where_.links[index(x, y)] & kLinkRight))
            return {};
        const auto t = crossing(value(x, y), value(x + 1, y));
        return t ? std::optional(glm::dvec2(x + *t, y)) : std::nullopt;
    }
    std::optional<glm::dvec2> below(int x, int y) const {
        if (y + 1 >= where_.height || !(where_.links[index(x, y)] & kLinkBelow))
            return {};
        const auto t = crossing(value(x, y), value(x, y + 1));
        return t ? std::optional(glm::dvec2(x, y + *t)) : std::nullopt;
    }

    // A contour that ends within the square, at another surface, counts as the point it has.
    void fill(int x, int y) {
        const auto top = right(x, y), bottom = right(x, y + 1);
        const auto left = below(x, y), rightSide = below(x + 1, y);
        const auto add = [&](const auto& a, const auto& b) {
            if (a || b)
                segments_.push_back({a ? *a : *b, b ? *b : *a});
        };
        if (int(bool(top)) + bool(bottom) + bool(left) + bool(rightSide) == 2) {
            const auto first = top ? top : bottom ? bottom : left;
            const auto second = rightSide ? rightSide : left ? left : bottom;
            add(first, second);
            return;
        }
        const float centre =
            0.25f * (value(x, y) + value(x + 1, y) + value(x, y + 1) + value(x + 1, y + 1));
        const bool joinsTopLeft = (value(x, y) >= 0.5f) != (centre >= 0.5f);
        add(top, joinsTopLeft ? left : rightSide);
        add(bottom, joinsTopLeft ? rightSide : left);
    }

    double nearestIn(int x, int y, const glm::dvec2& p) const {
        double best = kMostEdgePixels;
        if (x < 0 || y < 0 || x >= where_.width || y >= where_.height)
            return best;
        for (std::uint32_t i = firstOf_[index(x, y)]; i < firstOf_[index(x, y) + 1]; ++i)
            best = std::min(best, distanceTo(segments_[i], p));
        return best;
    }

    const Contours& where_;
    std::span<const float> values_;
    std::vector<Segment> segments_;
    std::vector<std::uint32_t> firstOf_; // of the square below and right of a pixel
    std::vector<glm::dvec2> points_;
};

double meanDistance(const Contour& from, const Contour& to) {
    const std::vector<glm::dvec2>& points = from.points();
    if (points.empty() || to.points().empty())
        return kMostEdgePixels;
    std::vector<double> distances(points.size());
    inParallel(points.size(), 256, 0, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            distances[i] = to.nearest(points[i]);
    });
    double sum = 0.0;
    for (const double distance : distances)
        sum += distance;
    return sum / double(points.size());
}

} // namespace

std::optional<double> contourDistance(const Contours& where, std::span<const float> a,
                                      std::span<const float> b) {
    const Contour first(where, a), second(where, b);
    if (first.points().empty() && second.points().empty())
        return {};
    return 0.5 * (meanDistance(first, second) + meanDistance(second, first));
}

} // namespace gnomon::bench
