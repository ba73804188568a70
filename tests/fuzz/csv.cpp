// Outlines and points in text files, up to the houses made of them.
// words: streaming/features/features_csv.cpp
#include "tests/fuzz/feature_promises.h"

namespace gnomon::fuzz {

void fuzzOne(Span bytes) {
    std::vector<RawFeatures> layers;
    FeatureFile file;
    const Failure failure = readCsv("houses.csv", std::string(textOf(bytes)), layers, file);
    checkFeatures(failure, std::move(layers), std::move(file));
}

} // namespace gnomon::fuzz
