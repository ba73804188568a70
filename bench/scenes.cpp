#include "bench/scenes.h"

#include "bench/scene_making.h"
#include "streaming/memory_source.h"
#include "viewer/input.h"
#include "viewer/place/glb.h"
#include "viewer/place/place.h"
#include "viewer/scene_file.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>

namespace gnomon::bench {

namespace {

namespace fs = std::filesystem;

constexpr SunAngles kNight{0.0, -20.0};

constexpr std::array kEntries = {
    SceneEntry{
        {"l-shape", "an L of two boxes on a floor (Weiskopf & Ertl 2003)"}, {215, 35}, makeLShape},
    SceneEntry{{"double-torus", "a closed body with two holes, finely cut, that shades itself "
                                "(Weiskopf & Ertl 2003)"},
               {230, 42},
               makeDoubleTorus},
    SceneEntry{{"factory", "an open hall of trusses, pipes, ladders, a crane and thin sheets "
                           "(Weiskopf & Ertl 2003)"},
               {205, 48},
               makeFactory},
    SceneEntry{{"floor-wall-spheres", "spheres before a wall, on and above a floor (Chong & "
                                      "Gortler 2004)"},
               {200, 38},
               makeFloorWallSpheres},
    SceneEntry{{"table-floor", "a laid table on a floor: two planes of interest (Chong & Gortler "
                               "2004)"},
               {328, 46},
               makeTableFloor},
    SceneEntry{{"wall-near-eye", "a wall near the eye beside the plane of interest: where one "
                                 "plane's map fails (Chong & Gortler 2004)"},
               {108, 15},
               makeWallNearEye},
    SceneEntry{{"lamp-room", "a lamp all round amid pillars and furniture (Brabec, Annen & Seidel "
                             "2002)"},
               kNight,
               makeLampRoom},
    SceneEntry{{"ceiling-lamp", "a lamp for half the space, on the ceiling over tables (Brabec, "
                                "Annen & Seidel 2002)"},
               kNight,
               makeCeilingLamp},
    SceneEntry{{"house-row", "gabled houses in a row on a slope"}, {112, 21}, makeHouseRow},
    SceneEntry{{"bridge", "a truss bridge of thin bars"}, {228, 38}, makeBridge},
    SceneEntry{{"trees", "trees with leaves cut out of crossed quads, and with round crowns"},
               {220, 36},
               makeTrees},
    SceneEntry{{"shed", "sheds and shelters of sheets with one side"}, {215, 34}, makeShed},
    SceneEntry{{"tower", "blades 5 to 200 m up the rays over a floor: penumbrae of known width"},
               {180, 50},
               makeTower},
    SceneEntry{{"ridge", "30 km: a ridge at sunrise, its shadow's edge among houses on the plain"},
               {90, 5},
               makeRidge},
    SceneEntry{{"contact-wall", "walls of several thicknesses on a floor: where shadows begin"},
               {195, 40},
               makeContactWall},
    SceneEntry{{"place", "the built-in place (gnomon demo), small"}, {225, 40}, nullptr},
};

const std::array kDescriptions = [] {
    std::array<SceneDescription, kEntries.size()> all{};
    for (std::size_t i = 0; i < all.size(); ++i)
        all[i] = kEntries[i].description;
    return all;
}();

Error noSuchScene(const std::string& name) {
    std::string names;
    for (const SceneEntry& entry : kEntries)
        names += (names.empty() ? "" : ", ") + std::string(entry.description.name);
    return {"--scene " + name, "no such scene; there are " + names, ErrorKind::Usage};
}

Camera cameraOf(const Look& look, const Transform<Ecef, Enu>& ecefFromPlace) {
    const glm::dvec3 forward = glm::normalize(look.target - look.eye);
    const glm::dvec3 side(forward.y, -forward.x, 0.0);
    const glm::dvec3 right = glm::length(side) > 1e-9 ? glm::normalize(side) : glm::dvec3(1, 0, 0);
    Camera camera;
    camera.position = ecefFromPlace(Point<Enu>{look.eye});
    camera.forward = ecefFromPlace(Vector<Enu>{forward});
    camera.right = ecefFromPlace(Vector<Enu>{right});
    camera.up = ecefFromPlace(Vector<Enu>{glm::cross(right, forward)});
    camera.verticalFovRadians = look.fovDegrees * kRadiansPerDegree;
    return camera;
}

Result<Bytes> glbOf(const MadeScene& made) {
    builtin::Glb glb;
    glb.addPlainMesh("solids", made.solids, glb.addMaterial("plain", -1, false));
    if (!made.leaves.indices.empty()) {
        constexpr std::uint64_t kSeed = 7;
        const Result<Bytes> picture = leafPicture(kSeed);
        if (!picture)
            return picture.error();
        const int texture = glb.addTexture(*picture, "image/png", false);
        glb.addPlainMesh("leaves", made.leaves, glb.addCutoutMaterial("leaves", texture));
    }
    return glb.finish();
}

Result<BenchScene> openMade(const SceneEntry& entry, const Geodetic& place, const SunAngles& sun) {
    MadeScene made;
    made.sun = sun;
    entry.make(made, place);
    made.dropSpoiltProbes();
    Result<Bytes> glb = glbOf(made);
    if (!glb)
        return glb.error();
    const std::string name = entry.description.name;
    const auto source = std::make_shared<MemorySource>("scene");
    source->add(name + ".glb", std::move(*glb));
    SceneOptions options;
    options.placement = Placement{place, 0.0};
    Result<Scene> scene = openScene(options, source, {name, name + ".glb", InputKind::Model});
    if (!scene)
        return scene.error();
    BenchScene out{std::move(*scene), {}, entry.sun, {}, std::move(made.probes)};
    const Transform<Ecef, Enu> ecefFromPlace = ecefFromEnu(place);
    out.camera = cameraOf(made.look, ecefFromPlace);
    for (const MadeLamp& lamp : made.lamps) {
        Lamp real;
        real.position = ecefFromPlace(Point<Enu>{lamp.position});
        real.facing = ecefFromPlace(Vector<Enu>{lamp.facing});
        real.rangeMetres = lamp.rangeMetres;
        real.power = lamp.power;
        out.scene.lamps.push_back(real);
    }
    out.scene.ground = GroundChoice{false, {}};
    if (made.ground)
        out.scene.ground->heightMetres = place.heightMetres;
    return out;
}

// A folder that is gone when this is.
class TemporaryFolder {
  public:
    static Result<TemporaryFolder> make() {
        std::error_code failed;
        std::string name = (fs::temp_directory_path(failed) / "gnomon-place-XXXXXX").string();
        if (failed || ::mkdtemp(name.data()) == nullptr)
            return Error{name,
                         "cannot make a temporary folder: " +
                             (failed ? failed.message() : std::strerror(errno)),
                         ErrorKind::Output};
        return TemporaryFolder(name);
    }
    TemporaryFolder(TemporaryFolder&& other) noexcept : path_(std::move(other.path_)) {
        other.path_.clear();
    }
    ~TemporaryFolder() {
        std::error_code ignored;
        if (!path_.empty())
            fs::remove_all(path_, ignored);
    }
    const fs::path& path() const { return path_; }

  private:
    explicit TemporaryFolder(fs::path path) : path_(std::move(path)) {}
    fs::path path_;
};

// All files below it: the small place is a few megabytes.
Failure readInto(MemorySource& source, const fs::path& folder) {
    std::error_code failed;
    for (fs::recursive_directory_iterator i(folder, failed), end; !failed && i != end;
         i.increment(failed)) {
        if (!i->is_regular_file(failed))
            continue;
        std::ifstream file(i->path(), std::ios::binary);
        const std::string text{std::istreambuf_iterator<char>(file), {}};
        if (!file)
            return Error{i->path().string(), "cannot be read", ErrorKind::Transient};
        Bytes bytes(text.size());
        std::memcpy(bytes.data(), text.data(), text.size());
        source.add(i->path().lexically_relative(folder).generic_string(), std::move(bytes));
    }
    if (failed)
        return Error{folder.string(), failed.message(), ErrorKind::Transient};
    return {};
}

Result<BenchScene> openPlace(const SceneEntry& entry, const Geodetic& at) {
    const Result<TemporaryFolder> folder = TemporaryFolder::make();
    if (!folder)
        return folder.error();
    PlaceOptions options;
    options.folder = folder->path().string();
    options.at = at;
    if (const auto written = writePlace(options); !written)
        return written.error();
    const auto source = std::make_shared<MemorySource>("place");
    if (Failure wrong = readInto(*source, folder->path()))
        return *wrong;
    const Result<SceneFile> file = readSceneFile((folder->path() / "place.scene.json").string());
    if (!file)
        return file.error();
    Result<Scene> scene = openScene({}, source, {"place", "tileset.json", InputKind::Tileset});
    if (!scene)
        return scene.error();
    BenchScene out{std::move(*scene), {}, entry.sun, {}, {}};
    if (file->camera) {
        place(out.camera, file->camera->position, file->camera->orientation);
        out.camera.verticalFovRadians = file->camera->fovDegrees.value_or(45.0) * kRadiansPerDegree;
    }
    out.scene.ground = file->ground;
    return out;
}

// What the frame and those who open the scene as any other are told.
void settle(BenchScene& scene) {
    scene.scene.sun = scene.sun;
    scene.scene.camera = SceneCamera{geodeticOf(scene.camera.position), orientationOf(scene.camera),
                                     scene.camera.verticalFovRadians / kRadiansPerDegree};
    if (scene.scene.ground) {
        scene.frame.groundAuto = scene.scene.ground->automatic;
        scene.frame.groundHeightMetres = scene.scene.ground->heightMetres;
    }
}

} // namespace

std::span<const SceneDescription> sceneDescriptions() {
    return kDescriptions;
}

Result<BenchScene> openBenchScene(const std::string& name, const Geodetic& place,
                                  const std::optional<SunAngles>& sun) {
    const auto entry = std::find_if(kEntries.begin(), kEntries.end(), [&](const SceneEntry& e) {
        return name == e.description.name;
    });
    if (entry == kEntries.end())
        return noSuchScene(name);
    Result<BenchScene> scene = entry->make == nullptr
                                   ? openPlace(*entry, place)
                                   : openMade(*entry, place, sun.value_or(entry->sun));
    if (scene) {
        if (sun)
            scene->sun = *sun;
        bench::settle(*scene);
    }
    return scene;
}

} // namespace gnomon::bench
