// How wide a shadow's edge is: visibility against the distance from where geometry puts the edge.
#pragma once

#include <cmath>
#include <cstddef>
#include <vector>

namespace gnomon::test {

// Visibility against the signed distance from the shadow's edge, in the light's plane.
class Profile {
  public:
    explicit Profile(double halfRange) : halfRange_(halfRange), sum_(kBins), count_(kBins) {}
    void add(double distance, double visibility) {
        const double at = (distance / halfRange_ + 1.0) * 0.5 * kBins;
        if (at < 0.0 || at >= kBins)
            return;
        sum_[std::size_t(at)] += visibility;
        count_[std::size_t(at)] += 1.0;
        ++samples_;
    }
    std::size_t samples() const { return samples_; }
    // Distance between the last place below 10 % and the first above 90 %, between bins by line.
    double width() const { return crossing(0.9) - crossing(0.1); }

  private:
    double crossing(double level) const {
        double lastX = 0.0, lastV = 0.0;
        bool any = false;
        for (std::size_t b = 0; b < kBins; ++b) {
            if (count_[b] == 0.0)
                continue;
            const double v = sum_[b] / count_[b];
            const double x = ((double(b) + 0.5) / kBins * 2.0 - 1.0) * halfRange_;
            if (v >= level)
                return any ? lastX + (x - lastX) * (level - lastV) / (v - lastV) : x;
            lastX = x, lastV = v, any = true;
        }
        return NAN;
    }
    static constexpr std::size_t kBins = 120;
    double halfRange_;
    std::vector<double> sum_, count_;
    std::size_t samples_ = 0;
};

} // namespace gnomon::test
