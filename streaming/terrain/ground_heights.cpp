#include "streaming/terrain/ground_heights.h"

#include "geo/plan_frame.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>

namespace gnomon {

namespace {

class FlatGround : public GroundHeights {
  public:
    explicit FlatGround(double heightMetres) : height_(heightMetres) {}
    void sample(std::span<const glm::dvec2>, std::span<double> heights) const override {
        std::fill(heights.begin(), heights.end(), height_);
    }

  private:
    double height_;
};

class StackedGround : public GroundHeights {
  public:
    explicit StackedGround(std::vector<std::shared_ptr<const GroundHeights>> grounds)
        : grounds_(std::move(grounds)) {}

    void sample(std::span<const glm::dvec2> lonLat, std::span<double> heights) const override {
        assert(lonLat.size() == heights.size());
        std::fill(heights.begin(), heights.end(), std::numeric_limits<double>::quiet_NaN());
        std::vector<std::size_t> open(lonLat.size()); // places without a height so far
        for (std::size_t i = 0; i < open.size(); ++i)
            open[i] = i;
        for (const auto& ground : grounds_) {
            if (open.empty())
                return;
            std::vector<glm::dvec2> asked;
            for (const std::size_t i : open)
                asked.push_back(lonLat[i]);
            std::vector<double> found(asked.size());
            ground->sample(asked, found);
            std::vector<std::size_t> still;
            for (std::size_t k = 0; k < open.size(); ++k) {
                heights[open[k]] = found[k];
                if (std::isnan(found[k]))
                    still.push_back(open[k]);
            }
            open = std::move(still);
        }
    }

  private:
    std::vector<std::shared_ptr<const GroundHeights>> grounds_;
};

// Seen straight from above the middle of the rings, so that they may cross the antimeridian or hold
// a pole.
class GroundWithin : public GroundHeights {
  public:
    GroundWithin(std::shared_ptr<const GroundHeights> ground,
                 const std::vector<std::vector<glm::dvec2>>& rings)
        : ground_(std::move(ground)), up_(middleOf(rings)), frame_(lonLatOf(up_)) {
        for (const std::vector<glm::dvec2>& ring : rings) {
            std::vector<glm::dvec2>& flat = rings_.emplace_back();
            for (const glm::dvec2 p : ring)
                flat.push_back(frame_.plan(p));
        }
        findExtent(rings);
    }

    void sample(std::span<const glm::dvec2> lonLat, std::span<double> heights) const override {
        ground_->sample(lonLat, heights);
        for (std::size_t i = 0; i < lonLat.size(); ++i)
            if (!contains(lonLat[i]))
                heights[i] = std::numeric_limits<double>::quiet_NaN();
    }
    std::optional<std::array<double, 4>> extent() const override { return extent_; }

  private:
    using Rings = std::vector<std::vector<glm::dvec2>>;

    static glm::dvec3 middleOf(const Rings& rings) {
        glm::dvec3 sum(0.0);
        for (const std::vector<glm::dvec2>& ring : rings)
            for (const glm::dvec2 p : ring)
                sum += glm::normalize(ecefOf({p.x, p.y, 0.0}).xyz);
        return glm::length(sum) > 0.0 ? glm::normalize(sum) : glm::dvec3(0, 0, 1);
    }
    static glm::dvec2 lonLatOf(const glm::dvec3& up) {
        const Geodetic middle = geodeticOf({kEquatorialRadiusMetres * up});
        return {middle.longitudeDegrees, middle.latitudeDegrees};
    }
    // Not known in degrees where rings cross the antimeridian or lie about a pole.
    void findExtent(const Rings& rings) {
        constexpr double kNearPole = 89.0, kHalfTurn = 180.0;
        std::array<double, 4> e{INFINITY, INFINITY, -INFINITY, -INFINITY};
        for (const std::vector<glm::dvec2>& ring : rings)
            for (const glm::dvec2 p : ring)
                e = {std::min(e[0], p.x), std::min(e[1], p.y), std::max(e[2], p.x),
                     std::max(e[3], p.y)};
        if (e[2] - e[0] < kHalfTurn && e[1] > -kNearPole && e[3] < kNearPole)
            extent_ = e;
    }
    // Sides that a ray to the east crosses: odd inside. Nothing is on the Earth's far side.
    bool contains(glm::dvec2 lonLat) const {
        const Result<Point<Ecef>> place = ecefFromGeodetic({lonLat.x, lonLat.y, 0.0});
        if (!place || glm::dot(place->xyz, up_) < 0.0)
            return false;
        const glm::dvec2 p = frame_.plan(lonLat);
        bool inside = false;
        for (const std::vector<glm::dvec2>& ring : rings_)
            for (std::size_t i = 0, j = ring.size() - 1; i < ring.size(); j = i++) {
                const glm::dvec2 a = ring[j], b = ring[i];
                if ((a.y > p.y) != (b.y > p.y) &&
                    p.x < a.x + (p.y - a.y) / (b.y - a.y) * (b.x - a.x))
                    inside = !inside;
            }
        return inside;
    }
    std::shared_ptr<const GroundHeights> ground_;
    glm::dvec3 up_; // at the middle
    PlanFrame frame_;
    Rings rings_; // in the plan
    std::optional<std::array<double, 4>> extent_;
};

} // namespace

double GroundHeights::at(glm::dvec2 lonLat) const {
    double height = 0.0;
    sample(std::span(&lonLat, 1), std::span(&height, 1));
    return height;
}

std::shared_ptr<const GroundHeights> flatGround(double heightMetres) {
    return std::make_shared<FlatGround>(heightMetres);
}

std::shared_ptr<const GroundHeights> groundWithin(std::shared_ptr<const GroundHeights> ground,
                                                  std::vector<std::vector<glm::dvec2>> rings) {
    return std::make_shared<GroundWithin>(std::move(ground), rings);
}

std::shared_ptr<const GroundHeights>
stackedGround(std::vector<std::shared_ptr<const GroundHeights>> grounds) {
    return std::make_shared<StackedGround>(std::move(grounds));
}

} // namespace gnomon
