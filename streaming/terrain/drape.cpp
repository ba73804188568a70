#include "streaming/terrain/drape.h"

#include "streaming/terrain/drape_picture.h"
#include "streaming/terrain/drape_polygons.h"

namespace gnomon {

Result<std::shared_ptr<const Drape>> openDrape(const std::string& path, const DrapeOptions& options,
                                               std::vector<std::string>& notes) {
    // A GeoPackage may hold either, or both: pictures win.
    Result<std::shared_ptr<const Drape>> picture = openDrapePicture(path, options, notes);
    if (picture)
        return picture;
    Result<std::shared_ptr<const Drape>> polygons = openDrapePolygons(path, options, notes);
    if (polygons || !looksLikeRaster(path))
        return polygons;
    return picture;
}

} // namespace gnomon
