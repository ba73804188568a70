// Polygons of one colour, as a drape. Made by openDrape only.
#pragma once

#include "streaming/terrain/drape.h"

namespace gnomon {

Result<std::shared_ptr<const Drape>> openDrapePolygons(const std::string& path,
                                                       const DrapeOptions& options,
                                                       std::vector<std::string>& notes);

} // namespace gnomon
