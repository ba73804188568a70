// What an evaluation found, for people and for programs: a table, JSON, and pictures in false
// colour.
#pragma once

#include "bench/evaluate.h"

#include <span>
#include <string>
#include <vector>

namespace gnomon::bench {

// What was looked at, beside the rows.
struct ReportFacts {
    std::vector<std::string> inputs; // or the one name of a built-in scene
    std::string renderer;
    Camera camera;
    SunPosition sun;
    double sunDiameterDegrees = 0.533;
    int raysPerPixel = 1;
    int framesTimed = 1;
    std::uint64_t pixels = 0; // with a surface
    std::uint64_t litFacing = 0;
    double referenceMs = 0.0;
    std::vector<std::string> warnings;
};

std::string reportTable(const ReportFacts& facts, std::span<const Row> rows);
std::string reportJson(const ReportFacts& facts, std::span<const Row> rows);
// All that can be asked for: words of techniques, scenes, and what is compared by default.
std::string techniqueListing();

// Light as grey, 0…1; the sky (below 0) in a pale blue.
Picture visibilityPicture(int width, int height, std::span<const float> visibility);
// The scene in grey; false light red, orange in the edge band; false shadow blue, cyan in the band.
Picture errorPicture(const Picture& scene, std::span<const Verdict> verdicts);
// A technique's text as a file's name: letters, digits, and + - _ . for what is left.
std::string fileNameOf(const std::string& technique);

} // namespace gnomon::bench
