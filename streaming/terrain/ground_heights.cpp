#include "streaming/terrain/ground_heights.h"

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

} // namespace

double GroundHeights::at(glm::dvec2 lonLat) const {
    double height = 0.0;
    sample(std::span(&lonLat, 1), std::span(&height, 1));
    return height;
}

std::shared_ptr<const GroundHeights> flatGround(double heightMetres) {
    return std::make_shared<FlatGround>(heightMetres);
}

std::shared_ptr<const GroundHeights>
stackedGround(std::vector<std::shared_ptr<const GroundHeights>> grounds) {
    return std::make_shared<StackedGround>(std::move(grounds));
}

} // namespace gnomon
