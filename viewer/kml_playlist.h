// The first gx:Tour of a KML file, as it is written: its playlist, step by step. Hostile bytes are
// bounded: entities and deep nesting are refused, what is not the tour is not kept.
#pragma once

#include "geo/result.h"

#include <map>
#include <string>
#include <vector>

namespace gnomon {

struct TourStep {
    enum class Kind { FlyTo, Wait, Pause, Sound, Update } kind = Kind::FlyTo;
    // Text by the names that lead to it, without prefixes: "duration", "Camera/longitude",
    // "LookAt/TimeStamp/when".
    std::map<std::string, std::string> texts;
};

struct KmlPlaylist {
    std::string tourName;
    std::size_t tours = 0; // in the whole file
    std::vector<TourStep> steps;
};

Result<KmlPlaylist> readKmlPlaylist(const std::string& text, const std::string& name);

} // namespace gnomon
