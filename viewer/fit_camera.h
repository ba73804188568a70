// A first view of a scene nobody has chosen a view for.
#pragma once

#include "viewer/scene.h"

namespace gnomon {

// From the south-east, looking down 35°, as near as the whole scene allows.
Camera fitCamera(const Scene& scene, int widthPixels, int heightPixels, double verticalFovRadians);

} // namespace gnomon
