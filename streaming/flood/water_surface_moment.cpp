#include "streaming/flood/water_surface_moment.h"

#include "streaming/flood/unstructured_place.h"

#include <cmath>
#include <limits>

namespace gnomon {

namespace {

constexpr float kNotKnown = std::numeric_limits<float>::quiet_NaN();

} // namespace

WaterMoments::WaterMoments(std::shared_ptr<const FloodData> data, double dryMetres)
    : data_(std::move(data)), nodes_(data_->geometry()), dryMetres_(dryMetres) {}

Failure WaterMoments::setBed(const GroundHeights* ground) {
    const FloodGeometry& geometry = data_->geometry();
    if (!geometry.bed.empty()) {
        beds_ = nodes_.spread(geometry.bed);
        return {};
    }
    if (ground == nullptr)
        return Error{data_->path,
                     std::string("holds ") +
                         (data_->kind() == WaterKind::Depth ? "depths" : "levels") +
                         " of water but no bed, and there is no ground here for it to stand on: "
                         "give terrain as well"};
    std::vector<double> heights(geometry.lonLat.size());
    ground->sample(geometry.lonLat, heights);
    std::vector<float> beds(heights.size());
    bool any = false;
    for (std::size_t i = 0; i < beds.size(); ++i) {
        beds[i] = std::isfinite(heights[i]) ? float(heights[i]) : kNotKnown;
        any = any || std::isfinite(heights[i]);
    }
    if (!any)
        return Error{data_->path, "lies nowhere where there is ground"};
    beds_ = nodes_.spread(beds);
    return {};
}

Result<std::shared_ptr<const WaterMoments::Step>> WaterMoments::read(std::size_t index) const {
    const Result<std::vector<float>> values = data_->values(index);
    if (!values)
        return values.error();
    if (values->size() != data_->geometry().lonLat.size())
        return Error{data_->path, "step " + std::to_string(index + 1) + " has " +
                                      std::to_string(values->size()) + " values for " +
                                      std::to_string(data_->geometry().lonLat.size()) + " nodes"};
    auto step = std::make_shared<Step>();
    step->index = index;
    step->depths = nodes_.spread(*values);
    const bool stage = data_->kind() == WaterKind::Stage;
    for (std::size_t i = 0; i < step->depths.size(); ++i) {
        const float depth = stage ? step->depths[i] - beds_[i] : step->depths[i];
        step->depths[i] = depth > 0.0f && std::isfinite(beds_[i]) ? depth : 0.0f;
    }
    if (data_->hasVelocity()) {
        const Result<std::vector<glm::vec2>> velocities = data_->velocities(index);
        if (!velocities)
            return velocities.error();
        if (velocities->size() == values->size())
            step->velocities = nodes_.spread(*velocities);
    }
    return std::shared_ptr<const Step>(std::move(step));
}

Result<std::shared_ptr<const WaterMoments::Step>> WaterMoments::step(std::size_t index) const {
    for (const auto& step : steps_)
        if (step->index == index)
            return step;
    if (steps_.size() == 2)
        steps_.pop_front(); // its memory first
    auto read = this->read(index);
    if (read)
        steps_.push_back(*read);
    return read;
}

Failure WaterMoments::blend(double seconds, WaterMoment& moment) const {
    const std::vector<double>& times = data_->stepSeconds();
    const auto after = std::upper_bound(times.begin(), times.end(), seconds);
    const std::size_t next = std::min(std::size_t(after - times.begin()), times.size() - 1);
    const std::size_t before = next > 0 && seconds < times[next] ? next - 1 : next;
    const bool within = before != next && seconds > times[before];
    // The later first, so that going on in time finds it already there.
    const auto from = step(within ? before : (seconds < times.front() ? 0 : before));
    if (!from)
        return from.error();
    moment.depths = (*from)->depths;
    moment.velocities = (*from)->velocities;
    if (!within)
        return {};
    const auto to = step(next);
    if (!to)
        return to.error();
    const float share = float((seconds - times[before]) / (times[next] - times[before]));
    for (std::size_t i = 0; i < moment.depths.size(); ++i)
        moment.depths[i] += share * ((*to)->depths[i] - moment.depths[i]);
    if ((*to)->velocities.size() == moment.velocities.size())
        for (std::size_t i = 0; i < moment.velocities.size(); ++i)
            moment.velocities[i] += share * ((*to)->velocities[i] - moment.velocities[i]);
    return {};
}

void WaterMoments::placeShore(WaterMoment& moment) const {
    const WetTriangles wet = wetTriangles(moment);
    for (std::uint32_t node = 0; node < moment.depths.size(); ++node) {
        if (!wet.isWet(node))
            continue;
        const double area = nodes_.cellArea(node), depth = moment.depths[node];
        moment.byNodes.area += area;
        moment.byNodes.volume += area * depth;
        moment.deepest = std::max(moment.deepest, depth);
        if (!moment.velocities.empty())
            moment.fastest = std::max(moment.fastest, double(glm::length(moment.velocities[node])));
    }
    const auto isWet = [&](std::uint32_t node) { return wet.isWet(node); };
    std::vector<ShoreTriangle> shore;
    WaterSums full;
    moment.patchIsWet.assign(nodes_.patches().size(), 0);
    for (std::size_t p = 0; p < nodes_.patches().size(); ++p)
        nodes_.eachTriangle(nodes_.patches()[p], isWet, [&](const NodeTriangle& t) {
            const int corners = wet.wetCorners(t);
            if (corners == 0)
                return;
            moment.patchIsWet[p] = 1;
            const double area =
                areaOnEarth({nodes_.lonLat(t[0]), nodes_.lonLat(t[1]), nodes_.lonLat(t[2])});
            if (corners < 3) {
                shore.push_back({t, area});
                return;
            }
            full.area += area;
            full.volume += area * (wet.depth(t[0]) + wet.depth(t[1]) + wet.depth(t[2])) / 3.0;
        });
    const WaterSums missing{moment.byNodes.area - full.area, moment.byNodes.volume - full.volume};
    moment.rule = fitShore(wet, shore, missing, moment.byNodes);
    const WaterSums rim = shownOf(wet, shore, moment.rule);
    moment.shown = {full.area + rim.area, full.volume + rim.volume};
}

Result<std::shared_ptr<const WaterMoment>> WaterMoments::at(double seconds) const {
    if (moment_ && moment_->seconds == seconds)
        return moment_;
    auto moment = std::make_shared<WaterMoment>();
    moment->seconds = seconds;
    if (const Failure failed = blend(seconds, *moment))
        return *failed;
    placeShore(*moment);
    moment_ = moment;
    return moment_;
}

} // namespace gnomon
