#include "viewer/water_legend.h"

#include <cmath>

namespace gnomon {

double niceAtLeast(double value) {
    if (!(value > 0.0) || !std::isfinite(value))
        return 1.0;
    const double decade = std::pow(10.0, std::floor(std::log10(value)));
    for (const double step : {1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 6.0, 8.0})
        if (value <= step * decade * (1.0 + 1e-9))
            return step * decade;
    return 10.0 * decade;
}

WaterColors colorsOf(const WaterLayer& layer) {
    if (layer.look.colors == WaterColors::Speed && !layer.surface->data().hasVelocity())
        return WaterColors::Depth;
    return layer.look.colors;
}

WaterLegend legendOf(const WaterLayer& layer) {
    WaterLegend legend;
    legend.interpolated = layer.surface->data().isInterpolated();
    switch (colorsOf(layer)) {
    case WaterColors::Natural:
        return legend;
    case WaterColors::Depth:
        legend.title = "Water depth";
        legend.unit = "m";
        legend.map = ColorMap::Depth;
        legend.most = layer.look.most.value_or(niceAtLeast(layer.surface->deepestMetres()));
        break;
    case WaterColors::Speed:
        legend.title = "Water speed";
        legend.unit = "m/s";
        legend.map = ColorMap::Speed;
        legend.most = layer.look.most.value_or(niceAtLeast(layer.surface->fastest()));
        break;
    }
    return legend;
}

} // namespace gnomon
