// CityJSON and its text sequences, up to the houses made of them.
// words: streaming/features/cityjson.cpp
#include "tests/fuzz/feature_promises.h"

namespace gnomon::fuzz {

void fuzzOne(Span bytes) {
    std::vector<RawFeatures> layers;
    FeatureFile file;
    const Failure failure = readCityJson("houses", std::string(textOf(bytes)), layers, file);
    checkFeatures(failure, std::move(layers), std::move(file));
}

} // namespace gnomon::fuzz
