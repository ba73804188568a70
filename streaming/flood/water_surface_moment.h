// A flood result at one moment: depths at all nodes, and how the shore is placed among them.
#pragma once

#include "streaming/flood/flood.h"
#include "streaming/flood/water_surface_nodes.h"
#include "streaming/flood/water_surface_shore.h"
#include "streaming/terrain/ground_heights.h"

#include <deque>
#include <memory>

namespace gnomon {

struct WaterMoment {
    double seconds = 0.0;
    std::vector<float> depths;         // 0: dry
    std::vector<glm::vec2> velocities; // m/s east, north; empty when not known
    ShoreRule rule;
    WaterSums byNodes, shown; // nodes and their cells; the surface that is drawn
    double deepest = 0.0, fastest = 0.0;
    // Triangles with any wet corner, patch by patch: none in those that are left out.
    std::vector<char> patchIsWet;
};

// Steps as depths over the bed, the last two kept, and moments between them.
class WaterMoments {
  public:
    WaterMoments(std::shared_ptr<const FloodData> data, double dryMetres);
    // Fails when there is nothing that the water could stand on.
    Failure setBed(const GroundHeights* ground);

    const FloodData& data() const { return *data_; }
    const WaterNodes& nodes() const { return nodes_; }
    const std::vector<float>& beds() const { return beds_; } // NaN: not known
    double dryMetres() const { return dryMetres_; }
    WetTriangles wetTriangles(const WaterMoment& moment) const {
        return {moment.depths, beds_, dryMetres_};
    }
    Result<std::shared_ptr<const WaterMoment>> at(double seconds) const;

    struct Step {
        std::size_t index = 0;
        std::vector<float> depths;
        std::vector<glm::vec2> velocities;
    };
    Result<std::shared_ptr<const Step>> step(std::size_t index) const;

  private:
    Result<std::shared_ptr<const Step>> read(std::size_t index) const;
    Failure blend(double seconds, WaterMoment& moment) const;
    void placeShore(WaterMoment& moment) const;

    std::shared_ptr<const FloodData> data_;
    WaterNodes nodes_;
    std::vector<float> beds_;
    double dryMetres_;
    mutable std::deque<std::shared_ptr<const Step>> steps_;
    mutable std::shared_ptr<const WaterMoment> moment_;
};

} // namespace gnomon
