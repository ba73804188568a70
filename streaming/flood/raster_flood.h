// Flood results on a grid: rasters (one file a step, or bands), NetCDF with coordinates and times
// by the CF conventions.
#pragma once

#include "streaming/flood/flood.h"
#include "streaming/flood/flood_grid.h"
#include "streaming/flood/flood_times.h"

#include <memory>
#include <string>
#include <vector>

namespace gnomon {

Result<std::shared_ptr<const FloodData>> openRasterFlood(const std::vector<std::string>& paths,
                                                         const FloodOptions& options);

// Where a grid's numbers come from: a value a node, row by row, as the file has them.
class GridSource {
  public:
    virtual ~GridSource() = default;
    virtual Result<std::vector<float>> water(std::size_t source) const = 0; // NaN: no data
    virtual bool hasVelocity() const { return false; }
    // Along the file's x and y, or along east and north.
    virtual Result<std::vector<glm::vec2>> velocity(std::size_t source) const;
    virtual bool velocityIsEastNorth() const { return false; }
};

class GridFlood : public FloodData {
  public:
    const FloodGeometry& geometry() const override { return geometry_; }
    WaterKind kind() const override { return kind_; }
    const std::vector<double>& stepSeconds() const override { return steps_.seconds; }
    bool stepsAreAbsolute() const override { return steps_.absolute; }
    Result<std::vector<float>> values(std::size_t step) const override;
    bool hasVelocity() const override { return source_->hasVelocity(); }
    Result<std::vector<glm::vec2>> velocities(std::size_t step) const override;

    // Filled by the readers, in this order.
    void place(GridPlaces places, const GridThinning& thinning);
    void setBed(std::vector<float> bed); // as the file has it
    void setSteps(FloodSteps steps, std::unique_ptr<const GridSource> source, WaterKind kind);

  private:
    FloodGeometry geometry_;
    std::vector<float> lift_, eastOfX_;
    FloodSteps steps_;
    std::unique_ptr<const GridSource> source_;
    WaterKind kind_ = WaterKind::Depth;
};

// No water stands as high or is as deep: what is beyond it marks where there is none.
inline constexpr float kMostWaterMetres = 9000.0f;

// Depth or level, by the values where nothing else tells it.
WaterKind guessWaterKind(const std::vector<float>& values);

// NetCDF files of variables over rows and columns, for openRasterFlood; several: their steps one
// after the other.
Result<std::shared_ptr<const FloodData>> openGridNetCdf(const std::vector<std::string>& paths,
                                                        const FloodOptions& options);

} // namespace gnomon
