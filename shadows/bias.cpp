#include "shadows/bias.h"

#include <limits>
#include <numbers>

namespace gnomon {

double riseMetres(const ShadowSettings& settings, double texelMetres, double tanAngle) {
    return std::numbers::sqrt2 * (filterRadiusTexels(settings) + 0.5) * texelMetres * tanAngle;
}

double constantBiasMetres(const ShadowSettings& settings, double texelMetres) {
    if (settings.bias != ShadowBias::Constant)
        return 0.0;
    return settings.biasMetres.value_or(riseMetres(settings, texelMetres, 1.0));
}

double layerOffsetMetres(const ShadowSettings& settings, double texelMetres) {
    if (settings.bias == ShadowBias::Midpoint)
        return std::numeric_limits<double>::infinity();
    return settings.biasMetres.value_or(riseMetres(settings, texelMetres, kSteepestSlope));
}

} // namespace gnomon
