#include "bench/evaluate.h"
#include "bench/evaluate_report.h"
#include "bench/plot.h"
#include "bench/scenes.h"
#include "render/context.h"
#include "viewer/commands.h"
#include "viewer/frame_report.h"
#include "viewer/image_file.h"
#include "viewer/input.h"
#include "viewer/messages.h"
#include "viewer/output_file.h"
#include "viewer/progress.h"
#include "viewer/shot.h"
#include "viewer/stop_signal.h"

#include <cstdio>
#include <filesystem>

namespace gnomon {

namespace {

constexpr int kSignalBase = 128; // the shell's habit: 128 + signal
constexpr int kPathFrames = 40;
constexpr double kPathFramesPerSecond = 30.0;

int printed(const std::string& text) {
    std::fputs(text.c_str(), stdout);
    if (std::fflush(stdout) == 0 && std::ferror(stdout) == 0)
        return exit_code::kDone;
    sayError({"stdout", "cannot be written", ErrorKind::Output});
    return exit_code::kOutput;
}

class Evaluate {
  public:
    explicit Evaluate(const EvaluateOptions& options) : options_(options) {}

    int run() {
        if (Failure wrong = prepare())
            return end(*wrong);
        if (Failure wrong = measure())
            return end(*wrong);
        return finish();
    }

  private:
    int end(const Error& error) {
        if (stopSignal())
            return kSignalBase + stopSignal();
        sayError(error);
        return exitCodeOf(error.kind);
    }

    // Cheap things that can be wrong come first, drawing last.
    Failure prepare() {
        Result<Shots> shots = Shots::create(options_.picture);
        if (!shots)
            return shots.error();
        if (Failure wrong = checkOutputs())
            return wrong;
        if (Failure wrong = open())
            return wrong;
        report_.settingsHash = settingsHash(options_.picture);
        Shot shot = shots->at(0.0, bench_ ? bench_->scene : *scene_);
        frame_ = frameOptionsFor(options_.picture, scene());
        if (bench_)
            takeFrom(*bench_, shot);
        camera_ = shot.camera;
        sun_ = shot.sun;
        time_ = shot.time;
        if (!bench_ && shots->usesDefaultSun(scene()))
            sayNote("sun", "neither --time nor --sun given: azimuth 225, elevation 40 degrees");
        if (Failure wrong = makePath(*shots))
            return wrong;
        return startDrawing();
    }

    Scene& scene() { return bench_ ? bench_->scene : *scene_; }

    Failure checkOutputs() const {
        if (options_.plotFile)
            if (Failure wrong = checkWritable(*options_.plotFile))
                return wrong;
        if (options_.picture.frameReport)
            if (Failure wrong = checkWritable(*options_.picture.frameReport))
                return wrong;
        if (!options_.imagesFolder)
            return {};
        std::error_code failed;
        std::filesystem::create_directories(*options_.imagesFolder, failed);
        if (failed)
            return Error{*options_.imagesFolder, "cannot be made: " + failed.message(),
                         ErrorKind::Output};
        return checkWritable(imagePath("reference"));
    }

    Failure open() {
        if (options_.sceneName) {
            Result<bench::BenchScene> opened =
                bench::openBenchScene(*options_.sceneName, bench::kDefaultPlace, sunOfProbes());
            if (!opened)
                return opened.error();
            bench_.emplace(std::move(*opened));
            inputs_ = {"scene " + *options_.sceneName};
            return {};
        }
        Result<Scene> opened = openScene(options_.picture.scene);
        if (!opened)
            return opened.error();
        scene_.emplace(std::move(*opened));
        for (const std::string& input : options_.picture.scene.inputs)
            inputs_.push_back(shownInput(input));
        if (say(scene_->problems))
            skipped_ = true;
        return {};
    }

    // Probes lie where the shadows of the sun that is asked for begin and end.
    std::optional<SunAngles> sunOfProbes() const {
        if (const SunAngles* angles = std::get_if<SunAngles>(&options_.picture.sun))
            return *angles;
        const UtcTime* time = std::get_if<UtcTime>(&options_.picture.sun);
        if (!time)
            return {};
        const SunPosition sun = sunAt(*time, bench::kDefaultPlace);
        return SunAngles{sun.azimuthDegrees, sun.elevationDegrees};
    }

    // What the command line leaves open, a built-in scene knows.
    void takeFrom(const bench::BenchScene& bench, Shot& shot) {
        const PictureOptions& asked = options_.picture;
        const FrameOptions given = frame_;
        frame_ = bench.frame;
        frame_.shadows = given.shadows;
        frame_.maximumScreenSpaceError = given.maximumScreenSpaceError;
        if (asked.groundGiven) {
            frame_.groundAuto = given.groundAuto;
            frame_.groundHeightMetres = given.groundHeightMetres;
        }
        if (std::holds_alternative<std::monostate>(asked.camera)) {
            shot.camera = bench.camera;
            if (asked.fovDegrees)
                shot.camera.verticalFovRadians = *asked.fovDegrees * kRadiansPerDegree;
            if (asked.sizeGiven) {
                shot.camera.widthPixels = asked.widthPixels;
                shot.camera.heightPixels = asked.heightPixels;
            }
        }
        if (std::holds_alternative<std::monostate>(asked.sun) && !shot.time)
            shot.sun = sunFromAngles(bench.sun.azimuthDegrees, bench.sun.elevationDegrees,
                                     bench.scene.anchor);
    }

    Failure makePath(const Shots& shots) {
        if (!options_.countFlips)
            return {};
        if (!options_.pathFile && !shots.moves()) {
            path_ = bench::smallMotion(camera_, kPathFrames);
            return {};
        }
        PictureOptions along = options_.picture;
        if (options_.pathFile)
            along.camera = CameraFile{*options_.pathFile};
        const Result<Shots> moving = Shots::create(along);
        if (!moving)
            return moving.error();
        for (int i = 0; i < kPathFrames; ++i)
            path_.push_back(moving->at(i / kPathFramesPerSecond, scene()).camera);
        return {};
    }

    Failure startDrawing() {
        render::ContextOptions contextOptions;
        contextOptions.device = options_.device;
        auto context = render::Context::createHeadless(contextOptions);
        if (!context)
            return context.error();
        context_ = std::move(*context);
        auto renderer = FrameRenderer::create(*context_, scene(), frame_);
        if (!renderer)
            return renderer.error();
        renderer_ = std::move(*renderer);
        return {};
    }

    bench::EvaluationInput input() {
        bench::EvaluationInput in{scene(),
                                  *renderer_,
                                  frame_,
                                  camera_,
                                  sun_,
                                  time_,
                                  {},
                                  path_,
                                  options_.raysPerPixel,
                                  options_.framesTimed,
                                  options_.picture.timeoutSeconds};
        if (bench_)
            in.probes = bench_->probes;
        return in;
    }

    Failure measure() {
        std::optional<ProgressBar> rays{"rows of rays"};
        auto prepared = bench::Evaluation::prepare(
            input(), [&rays](const char* what, std::size_t done, std::size_t all) {
                if (what && rays)
                    rays->update(done, all);
                return stopSignal() == 0;
            });
        rays.reset();
        if (!prepared)
            return prepared.error();
        bench::Evaluation& evaluation = *prepared;
        const bench::Reference& reference = evaluation.reference();
        if (Failure wrong = writeReference("reference", reference, reference.visibility))
            return wrong;
        const std::vector<bench::Technique> techniques = techniquesToMeasure();
        ProgressBar bar("techniques");
        for (std::size_t i = 0; i < techniques.size(); ++i) {
            Result<bench::Row> row = evaluation.measure(techniques[i]);
            if (!row)
                return row.error();
            if (Failure wrong = keep(std::move(*row), evaluation))
                return wrong;
            bar.update(i + 1, techniques.size());
        }
        bar.finish();
        note(evaluation);
        return {};
    }

    // When nothing is asked for: by night only what lamps have, by day both.
    std::vector<bench::Technique> techniquesToMeasure() {
        std::vector<bench::Technique> techniques = options_.techniques;
        if (options_.techniquesGiven || scene().lamps.empty())
            return techniques;
        if (sun_.elevationDegrees <= 0.0)
            techniques.clear();
        for (bench::Technique& lamps : bench::defaultLampTechniques(frame_.shadows))
            techniques.push_back(std::move(lamps));
        return techniques;
    }

    // The pictures of a row are written at once, so that they need not be kept.
    Failure keep(bench::Row row, const bench::Evaluation& evaluation) {
        const bench::Reference& reference = evaluation.reference();
        if (row.error) {
            warnings_.push_back(row.technique.text + ": " + row.error->reason);
            sayWarning(row.technique.text, row.error->reason);
        } else if (options_.imagesFolder && !row.visibility.empty()) {
            const std::string name = bench::fileNameOf(row.technique.text);
            if (Failure wrong = writeImage(name, reference, row.visibility))
                return wrong;
            if (!bench::isSoft(row.technique.settings) && !row.technique.ofLamps && !hardWritten_) {
                hardWritten_ = true;
                if (Failure wrong = writeReference("reference_hard", reference, reference.hard))
                    return wrong;
            }
            const Picture error =
                bench::errorPicture(evaluation.picture(), row.comparison.verdicts);
            if (Failure wrong =
                    gnomon::writeImage(error, ImageFormat::Png, imagePath(name + "_error")))
                return wrong;
        }
        // Of each technique the last frame timed.
        report_.frames.push_back(
            {std::int64_t(rows_.size()), time_, camera_, sun_, std::move(row.facts), {}, {}});
        row.visibility = {};
        row.comparison.verdicts = {};
        rows_.push_back(std::move(row));
        return {};
    }

    std::string imagePath(const std::string& name) const {
        return (std::filesystem::path(*options_.imagesFolder) / (name + ".png")).string();
    }
    Failure writeImage(const std::string& name, const bench::Reference& reference,
                       std::span<const float> visibility) const {
        if (!options_.imagesFolder)
            return {};
        return gnomon::writeImage(
            bench::visibilityPicture(reference.width, reference.height, visibility),
            ImageFormat::Png, imagePath(name));
    }

    // With the sky as in the techniques' pictures.
    Failure writeReference(const std::string& name, const bench::Reference& reference,
                           std::vector<float> visibility) const {
        for (std::size_t i = 0; i < visibility.size(); ++i)
            if (!reference.surfaces[i].any)
                visibility[i] = -1.0f;
        return writeImage(name, reference, visibility);
    }

    void note(const bench::Evaluation& evaluation) {
        const bench::Reference& reference = evaluation.reference();
        facts_.inputs = inputs_;
        facts_.renderer = context_->rendererName();
        facts_.camera = camera_;
        facts_.sun = sun_;
        facts_.sunDiameterDegrees = frame_.shadows.lightDiameterDegrees;
        facts_.raysPerPixel = reference.raysPerPixel;
        facts_.framesTimed = options_.framesTimed;
        for (const bench::SurfacePoint& surface : reference.surfaces)
            facts_.pixels += surface.any;
        facts_.litFacing = evaluation.litFacing();
        for (const bench::Row& row : rows_)
            if (facts_.litFacing == 0) // by night: of the lamp
                facts_.litFacing = row.comparison.metrics.litFacing;
        facts_.referenceMs = reference.milliseconds;
        for (const std::string& warning : evaluation.warnings())
            sayWarning("evaluate", warning);
        facts_.warnings = evaluation.warnings();
        facts_.warnings.insert(facts_.warnings.end(), warnings_.begin(), warnings_.end());
        skipped_ = skipped_ || evaluation.lacksTiles();
        report_.renderer = facts_.renderer;
        for (const Layer& layer : scene().layers)
            for (const FailedTile& failed : layer.tileset->failures()) {
                sayError(failed.error);
                report_.skipped.push_back(failed.error);
                skipped_ = true;
            }
    }

    int finish() {
        if (options_.picture.frameReport)
            if (Failure wrong = writeFile(*options_.picture.frameReport, report_.json()))
                return end(*wrong);
        if (options_.plotFile)
            if (Failure wrong = writePlot())
                return end(*wrong);
        const int code = printed(options_.json ? bench::reportJson(facts_, rows_)
                                               : bench::reportTable(facts_, rows_));
        if (code != exit_code::kDone)
            return code;
        return skipped_ ? exit_code::kSkipped : exit_code::kDone;
    }

    Failure writePlot() const {
        std::vector<bench::PlotPoint> points;
        for (const bench::Row& row : rows_) {
            const bench::Metrics& m = row.comparison.metrics;
            if (!row.error && m.litFacing > 0)
                points.push_back({row.technique.text, row.frameMs, m.falseLitAll + m.falseShadowAll,
                                  m.meanAbsolute});
        }
        std::string names;
        for (const std::string& input : inputs_)
            names += (names.empty() ? "" : ", ") + input;
        char view[160];
        std::snprintf(view, sizeof view, "%d x %d, sun %.1f° high, %d rays a pixel; ",
                      camera_.widthPixels, camera_.heightPixels, sun_.elevationDegrees,
                      facts_.raysPerPixel);
        return writeFile(*options_.plotFile,
                         bench::plotSvg({"Shadow techniques: time against error: " + names,
                                         view + facts_.renderer, facts_.litFacing},
                                        points));
    }

    const EvaluateOptions& options_;
    std::optional<bench::BenchScene> bench_;
    std::optional<Scene> scene_; // when it is not a built-in one
    std::vector<std::string> inputs_;
    FrameOptions frame_;
    Camera camera_;
    SunPosition sun_;
    std::optional<UtcTime> time_; // that set the sun
    std::vector<Camera> path_;
    std::unique_ptr<render::Context> context_;
    std::unique_ptr<FrameRenderer> renderer_; // before its context and scene go
    std::vector<bench::Row> rows_;
    std::vector<std::string> warnings_; // of rows
    bench::ReportFacts facts_;
    FrameReport report_;
    bool hardWritten_ = false;
    bool skipped_ = false;
};

} // namespace

int runEvaluate(const EvaluateOptions& options) {
    if (options.list)
        return printed(bench::techniqueListing());
    catchStopSignals();
    return Evaluate(options).run();
}

} // namespace gnomon
