// TELEMAC's results.
#include "tests/fuzz/memory_file.h"

#include "streaming/flood/selafin.h"

namespace gnomon::fuzz {

namespace {

void check(const FloodData& data) {
    const FloodGeometry& geometry = data.geometry();
    const std::size_t nodes = geometry.lonLat.size();
    demand(geometry.cellArea.size() == nodes, "an area a node");
    demand(geometry.bed.empty() || geometry.bed.size() == nodes, "no bed or one a node");
    for (const glm::dvec2& place : geometry.lonLat)
        demand(std::isfinite(place.x) && std::abs(place.y) <= 90.0, "a node lies on the Earth");
    for (const auto& triangle : geometry.triangles)
        for (const std::uint32_t node : triangle)
            demand(node < nodes, "a corner is a node");
    const std::vector<double>& steps = data.stepSeconds();
    demand(!steps.empty() && std::is_sorted(steps.begin(), steps.end()), "steps in order");
    constexpr std::size_t kMostSteps = 3;
    for (std::size_t step = 0; step < std::min(steps.size(), kMostSteps); ++step) {
        if (const auto values = data.values(step))
            demand(values->size() == nodes, "a value a node");
        else
            demandReadable(values.error());
        if (!data.hasVelocity())
            continue;
        if (const auto velocities = data.velocities(step))
            demand(velocities->size() == nodes, "a velocity a node");
        else
            demandReadable(velocities.error());
    }
}

} // namespace

void fuzzOne(Span bytes) {
    const MemoryFile file(bytes);
    if (!isSelafin(file.path()))
        return;
    FloodOptions options;
    options.crs = "EPSG:32632";
    auto read = readSelafin(file.path(), options);
    if (!read) {
        demandReadable(read.error());
        return;
    }
    const auto data = floodFrom(file.path(), std::move(*read), options);
    if (data)
        check(**data);
    else
        demandReadable(data.error());
}

} // namespace gnomon::fuzz
