// A raster picture with a place, as a drape. Made by openDrape only.
#pragma once

#include "streaming/terrain/drape.h"

namespace gnomon {

Result<std::shared_ptr<const Drape>> openDrapePicture(const std::string& path,
                                                      const DrapeOptions& options,
                                                      std::vector<std::string>& notes);
// Is it a file of a kind of raster, whether or not it can be used?
bool looksLikeRaster(const std::string& path);

} // namespace gnomon
