#include "streaming/flood/flood.h"

#include "streaming/flood/point_flood.h"
#include "streaming/flood/raster_flood.h"

namespace gnomon {

Result<std::vector<glm::vec2>> FloodData::velocities(std::size_t) const {
    return std::vector<glm::vec2>();
}

Result<std::shared_ptr<const FloodData>> FloodData::on(const GroundHeights&) const {
    return std::shared_ptr<const FloodData>();
}

Result<std::shared_ptr<const FloodData>> openFlood(const std::vector<std::string>& paths,
                                                   const FloodOptions& options) {
    if (paths.empty())
        return Error{"", "no file of water was named", ErrorKind::Usage};
    if (isUnstructuredFlood(paths.front())) {
        if (paths.size() > 1)
            return Error{paths[1], "results on a mesh come with all their steps in one file, here "
                                   "one was named before it"};
        return openUnstructuredFlood(paths.front(), options);
    }
    if (isPointFlood(paths.front())) {
        if (paths.size() > 1)
            return Error{paths[1], "levels at points have one step, here one was named before it"};
        return openPointFlood(paths.front(), options);
    }
    return openRasterFlood(paths, options);
}

} // namespace gnomon
