// Where buildings begin and end: on the ground under them, by their height.
#include "geo/plan_frame.h"
#include "streaming/features/buildings_model.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <limits>
#include <span>
#include <thread>

namespace gnomon {

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
// A house of two storeys, for those of which nothing is known.
constexpr double kAssumedMetres = 6.0;
// Lower than this above the ground, a polygon's own z is the ground's and not a roof's.
constexpr double kLowestRoofMetres = 2.0;
// How far bodies reach into the ground: it is known every kSampleMetres and bulges in between, and
// coarser terrain, which is drawn further away, may lie lower.
constexpr double kBaseDepthMetres = 1.0;
constexpr double kSampleMetres = 5.0;
constexpr int kMostSamplesAcross = 8;

// Places under one outline: its vertices, what lies between them, and a grid inside.
void addSamples(const BuildingBody& body, std::vector<glm::dvec2>& out) {
    const PlanFrame frame{glm::dvec2(body.west, body.south)};
    const glm::dvec2 degrees(body.east - body.west, body.north - body.south);
    const glm::dvec2 extent = frame.plan(glm::dvec2(body.east, body.north));
    const double step = std::max(kSampleMetres, std::max(extent.x, extent.y) / kMostSamplesAcross);
    for (const FeaturePart& part : body.parts)
        for (const FeatureRing& ring : part)
            for (std::size_t i = 0; i < ring.size(); ++i) {
                const glm::dvec2 a(ring[i]), b(ring[(i + 1) % ring.size()]);
                const glm::dvec2 along(std::remainder(b.x - a.x, 360.0), b.y - a.y);
                const double metres = glm::length(frame.plan(b) - frame.plan(a));
                const int pieces = int(std::ceil(std::max(metres / step, 1.0)));
                for (int k = 0; k < pieces; ++k)
                    out.push_back(a + along * (double(k) / pieces));
            }
    const glm::dvec2 cells = glm::ceil(glm::max(extent / step, glm::dvec2(1.0)));
    for (double y = 0.5; y < cells.y; ++y)
        for (double x = 0.5; x < cells.x; ++x) {
            const glm::dvec2 place =
                glm::dvec2(body.west, body.south) + degrees * glm::dvec2(x, y) / cells;
            if (covers(body, place))
                out.push_back(place);
        }
}

// On several threads, as terrain is large and made for that.
void sampleAll(const GroundHeights& ground, std::span<const glm::dvec2> places,
               std::span<double> heights) {
    constexpr std::size_t kChunk = 1 << 15;
    const std::size_t workers = std::clamp<std::size_t>(
        places.size() / kChunk, 1, std::max(1u, std::thread::hardware_concurrency()));
    std::vector<std::jthread> threads;
    for (std::size_t w = 0; w < workers; ++w) {
        const std::size_t first = places.size() * w / workers;
        const std::size_t count = places.size() * (w + 1) / workers - first;
        threads.emplace_back(
            [&ground, places = places.subspan(first, count),
             heights = heights.subspan(first, count)] { ground.sample(places, heights); });
    }
}

struct Below {
    double lowest = kNaN, mean = kNaN; // NaN: no ground there
};

Below belowOf(std::span<const double> heights) {
    Below below;
    double sum = 0.0, low = std::numeric_limits<double>::infinity();
    std::size_t count = 0;
    for (const double h : heights)
        if (std::isfinite(h)) {
            low = std::min(low, h);
            sum += h;
            ++count;
        }
    if (count > 0)
        below = {low, sum / double(count)};
    return below;
}

// Ground for those that have none under them: the lowest in the nearest cells of a coarse grid that
// have any.
class Neighbours {
  public:
    Neighbours(const std::vector<BuildingBody>& bodies, const std::vector<Below>& below) {
        start_ = {bodies.front().west, bodies.front().south};
        glm::dvec2 low(1e9), high(-1e9);
        for (const BuildingBody& body : bodies) {
            low = glm::min(low, place(body));
            high = glm::max(high, place(body));
        }
        low_ = low;
        size_ = glm::max((high - low) / double(kCells), glm::dvec2(1e-9));
        lowest_.assign(std::size_t(kCells) * kCells, kNaN);
        for (std::size_t i = 0; i < bodies.size(); ++i)
            if (std::isfinite(below[i].lowest)) {
                double& cell = lowest_[cellOf(bodies[i])];
                cell = std::isnan(cell) ? below[i].lowest : std::min(cell, below[i].lowest);
            }
        spread();
    }
    double lowestNear(const BuildingBody& body) const { return lowest_[cellOf(body)]; }

  private:
    static constexpr int kCells = 64;

    glm::dvec2 place(const BuildingBody& body) const {
        return {std::remainder((body.west + body.east) / 2.0 - start_.x, 360.0),
                (body.south + body.north) / 2.0 - start_.y};
    }
    std::size_t cellOf(const BuildingBody& body) const {
        const glm::dvec2 c = glm::clamp(glm::floor((place(body) - low_) / size_), glm::dvec2(0.0),
                                        glm::dvec2(kCells - 1));
        return std::size_t(c.y) * kCells + std::size_t(c.x);
    }
    void spread() {
        std::vector<std::size_t> border;
        for (std::size_t i = 0; i < lowest_.size(); ++i)
            if (!std::isnan(lowest_[i]))
                border.push_back(i);
        while (!border.empty()) {
            std::vector<std::pair<std::size_t, double>> reached;
            for (const std::size_t i : border) {
                const int x = int(i % kCells), y = int(i / kCells);
                for (const auto& [dx, dy] : {std::pair(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
                    const int u = x + dx, v = y + dy;
                    if (u < 0 || v < 0 || u >= kCells || v >= kCells)
                        continue;
                    const std::size_t j = std::size_t(v) * kCells + std::size_t(u);
                    if (std::isnan(lowest_[j]))
                        reached.emplace_back(j, lowest_[i]);
                }
            }
            border.clear();
            for (const auto& [j, height] : reached) {
                if (std::isnan(lowest_[j])) {
                    border.push_back(j);
                    lowest_[j] = height;
                } else {
                    lowest_[j] = std::min(lowest_[j], height);
                }
            }
        }
    }

    glm::dvec2 start_{0.0}, low_{0.0}, size_{1.0};
    std::vector<double> lowest_;
};

struct OwnHeights {
    double lowest = kNaN, mean = kNaN, highest = kNaN;
};

// Of the vertices, where all have one.
OwnHeights ownHeights(const BuildingBody& body) {
    OwnHeights own;
    double sum = 0.0;
    std::size_t count = 0;
    for (const FeaturePart& part : body.parts)
        for (const FeatureRing& ring : part)
            for (const glm::dvec3& p : ring) {
                own.lowest = count == 0 ? p.z : std::min(own.lowest, p.z);
                own.highest = count == 0 ? p.z : std::max(own.highest, p.z);
                sum += p.z;
                ++count;
            }
    if (!std::isfinite(sum))
        return {};
    own.mean = sum / double(count);
    return own;
}

std::string metres(double value) {
    std::array<char, 32> text;
    std::snprintf(text.data(), text.size(), "%.1f m", value);
    return text.data();
}

class Standing {
  public:
    Standing(std::vector<BuildingBody>& bodies, const BuildingOptions& options,
             const GroundHeights* ground, FeatureFile& file)
        : bodies_(bodies), options_(options), ground_(ground), file_(file) {}

    void run() {
        sample();
        for (std::size_t i = 0; i < bodies_.size(); ++i) {
            BuildingBody& body = bodies_[i];
            if (body.isSurface)
                standSurface(body, below_[i]);
            else
                standOutline(body, below_[i]);
            const PlanFrame frame{glm::dvec2(body.west, body.south)};
            body.sizeMetres = std::max(glm::length(frame.plan(glm::dvec2(body.east, body.north))),
                                       body.topMetres - body.baseMetres);
        }
        tell();
    }

  private:
    void sample() {
        below_.resize(bodies_.size());
        if (ground_ == nullptr)
            return;
        std::vector<glm::dvec2> places;
        std::vector<std::size_t> ends;
        for (const BuildingBody& body : bodies_) {
            if (body.isSurface)
                places.emplace_back((body.west + body.east) / 2.0, (body.south + body.north) / 2.0);
            else
                addSamples(body, places);
            ends.push_back(places.size());
        }
        std::vector<double> heights(places.size(), kNaN);
        sampleAll(*ground_, places, heights);
        for (std::size_t i = 0, first = 0; i < bodies_.size(); first = ends[i++])
            below_[i] = belowOf(std::span(heights).subspan(first, ends[i] - first));
        fillGaps();
    }

    void fillGaps() {
        const Neighbours neighbours(bodies_, below_);
        for (std::size_t i = 0; i < bodies_.size(); ++i)
            if (!bodies_[i].isSurface && std::isnan(below_[i].lowest) &&
                std::isnan(ownHeights(bodies_[i]).mean)) {
                below_[i].lowest = below_[i].mean = neighbours.lowestNear(bodies_[i]);
                groundless_ += !std::isnan(below_[i].lowest);
            }
    }

    void standSurface(BuildingBody& body, const Below& below) {
        const OwnHeights own = ownHeights(body);
        body.groundMetres = body.baseMetres = own.lowest;
        body.topMetres = own.highest;
        if (std::isfinite(below.mean))
            offsets_.push_back(own.lowest - below.mean);
    }

    void standOutline(BuildingBody& body, Below below) {
        const OwnHeights own = ownHeights(body);
        const bool known = std::isfinite(below.lowest), hasOwn = std::isfinite(own.mean);
        const double assumed = options_.heightMetres.value_or(kAssumedMetres);
        bool ownIsRoof = false;
        if (hasOwn && known) // whichever fits better
            ownIsRoof = own.mean - below.mean >
                        (body.statedMetres ? *body.statedMetres / 2.0 : kLowestRoofMetres);
        const double foot = hasOwn && !ownIsRoof ? own.lowest : known ? below.lowest : 0.0;
        body.groundMetres = foot;
        body.heightAssumed = !ownIsRoof && !body.statedMetres;
        if (ownIsRoof)
            body.topMetres = own.mean;
        else if (body.statedMetres) // from the lowest ground, as maps and CityGML define it
            body.topMetres = foot + *body.statedMetres;
        else
            body.topMetres = (hasOwn ? own.mean : known ? below.mean : 0.0) + assumed;
        const double depth = ground_ != nullptr ? kBaseDepthMetres : 0.0;
        body.baseMetres = body.startsAtMetres > 0.0
                              ? foot + body.startsAtMetres
                              : std::min(foot, known ? below.lowest : foot) - depth;
        roofs_ += ownIsRoof;
        feet_ += hasOwn && !ownIsRoof;
        assumed_ += body.heightAssumed;
        atZero_ += !known && !hasOwn;
    }

    void tell() {
        if (assumed_ > 0)
            file_.notes.push_back(std::to_string(assumed_) + " of " +
                                  std::to_string(bodies_.size()) + " buildings have no height: " +
                                  (options_.heightMetres
                                       ? metres(*options_.heightMetres) + " as stated"
                                       : metres(kAssumedMetres) + " assumed"));
        if (roofs_ > 0)
            file_.notes.push_back(std::to_string(roofs_) +
                                  " outlines lie above the ground: they are taken for roofs");
        if (feet_ > 0)
            file_.notes.push_back(std::to_string(feet_) +
                                  " outlines bring the height of the ground they stand on");
        if (groundless_ > 0)
            file_.notes.push_back(std::to_string(groundless_) +
                                  " buildings stand where the ground has no height: on the lowest "
                                  "ground near them");
        if (atZero_ > 0)
            file_.notes.push_back("no ground is known: " + std::to_string(atZero_) +
                                  " buildings stand at 0 m above the ellipsoid");
        tellOffset();
    }

    // Geoid and ellipsoid are up to 100 m apart, which is the usual mistake.
    void tellOffset() {
        constexpr double kWorthSaying = 3.0;
        if (offsets_.empty())
            return;
        const auto middle = offsets_.begin() + std::ptrdiff_t(offsets_.size() / 2);
        std::nth_element(offsets_.begin(), middle, offsets_.end());
        if (std::abs(*middle) > kWorthSaying)
            file_.notes.push_back("its buildings begin " + metres(std::abs(*middle)) +
                                  (*middle > 0.0 ? " above" : " below") +
                                  " the ground (half of them more): do its heights mean what the "
                                  "ground's do (--heights, --raise)?");
    }

    std::vector<BuildingBody>& bodies_;
    const BuildingOptions& options_;
    const GroundHeights* ground_;
    FeatureFile& file_;
    std::vector<Below> below_;
    std::vector<double> offsets_;
    std::size_t assumed_ = 0, roofs_ = 0, feet_ = 0, groundless_ = 0, atZero_ = 0;
};

} // namespace

void standOnGround(std::vector<BuildingBody>& bodies, const BuildingOptions& options,
                   const std::shared_ptr<const GroundHeights>& ground, FeatureFile& file) {
    if (!bodies.empty())
        Standing(bodies, options, ground.get(), file).run();
}

} // namespace gnomon
