// What the colours of a water layer mean: the picture and the legend beside it take it from here,
// so that they agree.
#pragma once

#include "streaming/color_map.h"
#include "viewer/scene.h"

#include <string>

namespace gnomon {

struct WaterLegend {
    std::string title; // "Water depth"; empty where colours tell no number (WaterColors::Natural)
    std::string unit;  // "m" or "m/s"
    double most = 0.0; // what the last colour stands for, and all beyond; the first stands for 0
    ColorMap map = ColorMap::Depth;
    bool interpolated = false; // between a few points, no model's result: to be said
};

// How a layer is really coloured: by depth where speeds are asked for and the data has none.
WaterColors colorsOf(const WaterLayer& layer);

WaterLegend legendOf(const WaterLayer& layer);

// The least of 1, 1.5, 2, 3, 4, 5, 6, 8 times a power of ten that is no less; 1 for what is not
// above 0.
double niceAtLeast(double value);

} // namespace gnomon
