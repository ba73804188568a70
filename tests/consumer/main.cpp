// Where the sun stands over Cologne, what of a tileset a camera needs, and its cascades.
#include "geo/camera.h"
#include "geo/sun.h"
#include "geo/view.h"
#include "shadows/cascades.h"
#include "shadows/light_basis.h"
#include "streaming/loader.h"

#include <cstdio>

using namespace gnomon;

int main(int argc, char** argv) {
    if (argc != 3) {
        std::fprintf(stderr, "usage: consumer FOLDER TILESET.json\n");
        return 2;
    }
    const Geodetic cologne{6.96, 50.94, 100.0};
    const auto time = parseTime("2024-06-21T13:33 Europe/Berlin");
    if (!time)
        return 1;
    const SunPosition sun = sunAt(*time, cologne);
    std::printf("sun %.1f %.1f\n", sun.azimuthDegrees, sun.elevationDegrees);

    auto tileset = StreamedTileset::open(fileSource(argv[1]), argv[2], {}, {});
    if (!tileset) {
        std::fprintf(stderr, "error: %s\n", tileset.error().message().c_str());
        return 1;
    }
    const TileNode& root = (*tileset)->tree().node(TileTree::root());
    const Sphere all = boundingSphere(root.volume);
    Camera camera;
    Geodetic above = geodeticOf(all.centre);
    above.heightMetres += 3.0 * all.radiusMetres;
    place(camera, above, {0.0, -90.0, 0.0});
    const View view = perspectiveView(camera);
    const Settled settled = settle(**tileset, std::span(&view, 1), {},
                                   std::chrono::steady_clock::now() + std::chrono::seconds(30));
    std::printf("tiles %zu %s\n", settled.selection.draw.size(),
                settled.complete ? "complete" : "incomplete");

    CascadeInput input;
    input.camera = camera;
    input.lightFromEcef = lightFromEcef(ecefFromEnu(cologne), sun.towards);
    input.farMetres = 4.0 * all.radiusMetres;
    const CascadeSet set = fitCascades(input, {});
    std::printf("cascades %zu\n", set.cascades.size());
    return 0;
}
