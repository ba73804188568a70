// What all layers that are made from a file of features have in common.
#pragma once

#include "streaming/features/features.h"
#include "streaming/terrain/ground_heights.h"

#include <memory>

namespace gnomon {

// Reads the file and makes the layer of what is in it.
template <class Layer, class Options>
auto openFeatureLayer(const std::string& path, const Options& options,
                      const std::shared_ptr<const GroundHeights>& ground)
    -> decltype(Layer::of(FeatureFile(), path, options, ground)) {
    Result<FeatureFile> file = readFeatures(path, options.source);
    if (!file)
        return file.error();
    return Layer::of(std::move(*file), path, options, ground);
}

// What was left out from `first` on belongs to the file `name`.
void nameLeftOut(FeatureFile& file, std::size_t first, const std::string& name);
// Why there is no layer of `things` ("trees").
Error nothingOf(const FeatureFile& file, const std::string& name, const char* things);

} // namespace gnomon
