// Flood results on meshes: what the readers of the formats hand over, and what is made of it.
//
// A reader gives the mesh in the coordinates of its file and a value a point or a face; placing on
// the Earth, heights, areas, steps and means along the rim are the same for all and made here.
#pragma once

#include "streaming/flood/flood.h"
#include "streaming/flood/unstructured_time.h"
#include "streaming/flood/unstructured_topology.h"

#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace gnomon {

class MeshFile {
  public:
    virtual ~MeshFile() = default;
    // One a point or face of `mesh`, metres (a level, or a depth); NaN: no data. What is not above
    // the bed is taken for dry by the caller.
    virtual Result<std::vector<float>> water(std::size_t step) const = 0;
    virtual bool hasVelocity() const { return false; }
    virtual Result<std::vector<glm::vec2>> velocity(std::size_t step) const; // m/s, along x and y

    PolygonMesh mesh;
    ValuesAt at = ValuesAt::Points;
    WaterKind kind = WaterKind::Stage;
    std::optional<std::string> crs;
    std::vector<float> bed;       // a value a point or face, metres; may be empty
    std::vector<double> faceArea; // where the file knows better than the corners; may be empty
    StepTimes times;
    std::vector<std::string> notes;
    std::vector<Error> leftOut;
};

// Builds the result; fails when there is no place, no face or no step.
Result<std::shared_ptr<const FloodData>>
floodFrom(const std::string& path, std::unique_ptr<MeshFile> file, const FloodOptions& options);

} // namespace gnomon
