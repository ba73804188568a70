#include "viewer/shot.h"

#include "bench/scenes.h"
#include "streaming/terrain/ground_heights.h"
#include "viewer/fit_camera.h"
#include "viewer/messages.h"
#include "viewer/progress.h"

#include <cmath>

namespace gnomon {

Result<Shots> Shots::create(const PictureOptions& options) {
    Shots shots(options);
    if (const CameraFile* file = std::get_if<CameraFile>(&options.camera)) {
        Result<CameraPath> path =
            CameraPath::load(file->path, options.fovDegrees.value_or(kDefaultFovDegrees),
                             double(options.widthPixels) / options.heightPixels);
        if (!path)
            return path.error();
        for (const std::string& note : path->notes())
            sayNote(file->path, note);
        shots.path_ = std::move(*path);
    }
    return shots;
}

Camera Shots::cameraFor(const Scene& scene) const {
    double fov = options_.fovDegrees.value_or(kDefaultFovDegrees);
    const FixedCamera* fixed = std::get_if<FixedCamera>(&options_.camera);
    if (!fixed && !scene.camera)
        return fitCamera(scene, options_.widthPixels, options_.heightPixels,
                         fov * kRadiansPerDegree);
    if (!fixed && !options_.fovDegrees)
        fov = scene.camera->fovDegrees.value_or(fov);
    Camera camera;
    camera.verticalFovRadians = fov * kRadiansPerDegree;
    if (fixed)
        place(camera, fixed->position, fixed->orientation);
    else
        place(camera, scene.camera->position, scene.camera->orientation);
    return camera;
}

// Where nothing tells the ground's height, the layers' base does.
const CameraPath& Shots::pathIn(const Scene& scene) const {
    if (!path_->needsGround())
        return *path_;
    if (!pathOnGround_)
        pathOnGround_ = path_->onGround([&](double lon, double lat) {
            const double base = scene.ground
                                    ? scene.ground->heightMetres.value_or(scene.anchor.heightMetres)
                                    : scene.anchor.heightMetres;
            if (!scene.groundHeights)
                return base;
            const double height = scene.groundHeights->at({lon, lat});
            return std::isnan(height) ? base : height;
        });
    return *pathOnGround_;
}

Shot Shots::at(double seconds, const Scene& scene) const {
    Shot shot;
    if (path_) {
        CameraPath::Sample sample = pathIn(scene).sample(path_->startSeconds() + seconds);
        shot.camera = sample.camera;
        shot.time = sample.time;
    } else {
        shot.camera = cameraFor(scene);
    }
    shot.camera.widthPixels = options_.widthPixels;
    shot.camera.heightPixels = options_.heightPixels;
    if (!shot.time) {
        const UtcTime* given = std::get_if<UtcTime>(&options_.sun);
        shot.time = given ? std::optional(*given) : scene.time;
    }
    shot.timeZone = options_.timeZone;
    if (!shot.timeZone && path_)
        shot.timeZone = path_->timeZone();
    if (!shot.timeZone)
        shot.timeZone = scene.timeZone;
    const SunAngles* angles = std::get_if<SunAngles>(&options_.sun);
    if (options_.fixedSun)
        angles = &*options_.fixedSun;
    if (shot.time && !angles) {
        shot.sun = sunAt(*shot.time, scene.anchor);
    } else {
        const SunAngles sun = angles ? *angles : scene.sun.value_or(kDefaultSun);
        shot.sun = sunFromAngles(sun.azimuthDegrees, sun.elevationDegrees, scene.anchor);
    }
    return shot;
}

bool Shots::usesDefaultSun(const Scene& scene) const {
    return std::holds_alternative<std::monostate>(options_.sun) && !scene.sun &&
           !at(0.0, scene).time;
}

double Shots::lengthSeconds() const {
    return path_ ? path_->endSeconds() - path_->startSeconds() : 0.0;
}

Result<Scene> openAsked(const PictureOptions& options) {
    if (!options.benchScene) {
        ProgressBar bar("opening");
        SceneOptions asked = options.scene;
        asked.progress = [&](const std::string&, double share) {
            bar.update(std::size_t(100.0 * share), 100);
        };
        Result<Scene> scene = openScene(asked);
        bar.finish();
        return scene;
    }
    const auto place =
        options.scene.placement ? options.scene.placement->origin : bench::kDefaultPlace;
    Result<bench::BenchScene> scene = bench::openBenchScene(*options.benchScene, place);
    if (!scene)
        return scene.error();
    return std::move(scene->scene);
}

FrameOptions frameOptionsFor(const PictureOptions& options, const Scene& scene) {
    FrameOptions frame = options.frame;
    if (!options.groundGiven && scene.ground) {
        frame.groundAuto = scene.ground->automatic;
        frame.groundHeightMetres = scene.ground->heightMetres;
    }
    return frame;
}

} // namespace gnomon
