#include "viewer/commands.h"
#include "viewer/messages.h"
#include "viewer/place/place.h"
#include "viewer/progress.h"

namespace gnomon {

int runDemo(const DemoOptions& options) {
    PlaceOptions place;
    place.folder = options.folder;
    place.buildings = options.buildings;
    place.at = options.at;
    place.seed = options.seed;
    ProgressBar bar("parts in a hundred");
    const Result<PlaceFacts> facts =
        writePlace(place, [&](double fraction) { bar.update(std::size_t(100.0 * fraction), 100); });
    bar.finish();
    if (!facts) {
        sayError(facts.error());
        return exitCodeOf(facts.error().kind);
    }
    sayNote(options.folder, std::to_string(facts->buildings) + " buildings, " +
                                std::to_string(facts->trees) + " trees, " +
                                std::to_string(facts->tiles) + " tiles, " +
                                std::to_string(facts->triangles) + " triangles in " +
                                std::to_string(facts->files) + " files");
    return exit_code::kDone;
}

} // namespace gnomon
