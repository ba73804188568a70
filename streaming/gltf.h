// glTF 2.0 to one soup of triangles, and clouds of points, in the tile's frame: nodes, instances,
// RTC and the up axis are applied; primitives of every mode but lines, Draco, meshopt, quantisation
// and sparse accessors are read.
#pragma once

#include "streaming/content.h"
#include "streaming/points.h"
#include "streaming/soup.h"

#include <optional>
#include <span>
#include <vector>

namespace gnomon {

struct GltfContent {
    Soup soup;
    std::vector<PointCloud> points;
    std::vector<Material> materials; // those that are used
    std::vector<Image> images;
    std::shared_ptr<const FeatureTable> features;
    std::vector<std::string> extensions;
    std::string copyright;
    std::vector<std::string> warnings;
};

// `rtcCenter` is b3dm's; without it CESIUM_RTC counts. Throws BadContent.
GltfContent readGltf(std::span<const std::byte> bytes, const DecodeOptions& options,
                     const std::optional<glm::dvec3>& rtcCenter, ByteBudget& budget);

} // namespace gnomon
