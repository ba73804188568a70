#include "viewer/capture_plan.h"
#include "viewer/commands.h"
#include "viewer/frame_report.h"
#include "viewer/image_file.h"
#include "viewer/lamps.h"
#include "viewer/messages.h"
#include "viewer/option_values.h"
#include "viewer/output_file.h"
#include "viewer/overlay_facts.h"
#include "viewer/progress.h"
#include "viewer/shot.h"
#include "viewer/stop_signal.h"
#include "viewer/video_file.h"

#include "render/context.h"

#include <algorithm>
#include <chrono>
#include <cstdio>
#include <filesystem>
#include <set>

namespace gnomon {

namespace {

using Clock = std::chrono::steady_clock;

constexpr int kSignalBase = 128; // the shell's habit: 128 + signal
// Frames whose tiles are loaded while one is drawn: a frame takes longer than a tile's way here,
// and what lies beyond the next few is a matter of the next frame.
constexpr std::size_t kLookAhead = 3;

double millisecondsSince(Clock::time_point start) {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

// Of several faults the one that says most about what to do next is told to the shell.
int graver(int a, int b) {
    static constexpr int kOrder[] = {exit_code::kDone,  exit_code::kSkipped, exit_code::kTransient,
                                     exit_code::kInput, exit_code::kUsage,   exit_code::kOutput};
    const auto rank = [](int code) {
        return std::find(std::begin(kOrder), std::end(kOrder), code);
    };
    return rank(a) < rank(b) ? b : a;
}

std::string listed(const std::vector<std::string>& names) {
    constexpr std::size_t kMostNamed = 20; // an error stays one line that can be read
    std::string text;
    for (std::size_t i = 0; i < std::min(names.size(), kMostNamed); ++i)
        text += (i == 0 ? "" : ", ") + names[i];
    if (names.size() > kMostNamed)
        text += " and " + std::to_string(names.size() - kMostNamed) + " more";
    return text;
}

class Capture {
  public:
    Capture(const CaptureOptions& options, OutputName output)
        : options_(options), output_(std::move(output)) {}

    int run() {
        if (Failure wrong = prepare())
            return end(*wrong);
        for (std::size_t i = 0; i < planned_.size() && !stopSignal(); ++i) {
            if (Failure wrong = drawFrame(i)) {
                fail(*wrong);
                break;
            }
            bar_.update(i + 1, planned_.size());
        }
        bar_.finish();
        if (Failure wrong = finishVideo())
            fail(*wrong);
        if (Failure wrong = writeReport())
            fail(*wrong);
        return stopSignal() ? kSignalBase + stopSignal() : exitCode_;
    }

  private:
    int end(const Error& error) {
        fail(error);
        return exitCode_;
    }
    void fail(const Error& error) {
        sayError(error);
        exitCode_ = graver(exitCode_, exitCodeOf(error.kind));
    }

    // Cheap things that can be wrong come first, drawing last.
    Failure prepare() {
        Result<Shots> shots = Shots::create(options_.picture);
        if (!shots)
            return shots.error();
        shots_.emplace(std::move(*shots));
        auto planned = planFrames(options_, output_, shots_->lengthSeconds());
        if (!planned)
            return planned.error();
        planned_ = std::move(*planned);
        single_ = planned_.size() == 1;
        report_.settingsHash = settingsHash(options_);
        takeAwayWhatWasAbandoned();
        if (options_.resume)
            leaveWhatIsThere();
        if (planned_.empty()) {
            sayNote(options_.output, "no frames are left to draw");
            return {};
        }
        if (Failure wrong = checkWritable(output_.of(planned_.front().index)))
            return wrong;
        if (options_.picture.frameReport)
            if (Failure wrong = checkWritable(*options_.picture.frameReport))
                return wrong;
        return prepareDrawing();
    }

    std::string description() const { return "gnomon, settings " + report_.settingsHash; }
    ImageFormat imageFormat() const {
        return output_.format() == OutputFormat::Png ? ImageFormat::Png : ImageFormat::Jpeg;
    }

    // By runs of the same frames that were killed while they wrote.
    void takeAwayWhatWasAbandoned() const {
        std::vector<std::string> files;
        for (const PlannedFrame& frame : planned_) {
            files.push_back(output_.of(frame.index));
            for (const Aov aov : options_.aovs)
                files.push_back(pathOf(frame, aov));
        }
        if (options_.picture.frameReport)
            files.push_back(*options_.picture.frameReport);
        removeAbandoned(files);
    }

    // A picture is written last, whole, and says so only when nothing in it was missing.
    void leaveWhatIsThere() {
        const std::string drawnSo = description();
        const auto isThere = [&](const PlannedFrame& frame) {
            if (readDescription(imageFormat(), output_.of(frame.index)) != drawnSo)
                return false;
            std::error_code ignored;
            return std::all_of(options_.aovs.begin(), options_.aovs.end(), [&](Aov aov) {
                return std::filesystem::exists(pathOf(frame, aov), ignored);
            });
        };
        std::vector<PlannedFrame> left;
        for (const PlannedFrame& frame : planned_)
            if (isThere(frame))
                report_.kept.push_back(frame.index);
            else
                left.push_back(frame);
        planned_ = std::move(left);
        if (!report_.kept.empty())
            sayNote(options_.output,
                    std::to_string(report_.kept.size()) + " frames are there already");
    }

    void prepareOverlay() {
        if (!options_.overlay)
            return;
        auto overlay = Overlay::create();
        if (!overlay) {
            sayWarning("overlay", overlay.error().message() + ": nothing is written over pictures");
            return;
        }
        overlay_ = std::move(*overlay);
        overlayFacts_ = overlayFactsOf(*scene_);
    }

    Failure prepareDrawing() {
        const std::chrono::duration<double> patience(options_.picture.timeoutSeconds);
        PictureOptions picture = options_.picture;
        picture.scene.patience = patience;
        Result<Scene> scene = openAsked(picture);
        if (!scene)
            return scene.error();
        scene_.emplace(std::move(*scene));
        report_.credits = scene_->credits;
        prepareOverlay();
        inputsLeftOut_ = say(scene_->problems);
        if (inputsLeftOut_)
            exitCode_ = exit_code::kSkipped;
        for (const Problem& problem : scene_->problems)
            if (problem.severity == Problem::Severity::Error)
                report_.skipped.push_back({problem.uri, problem.reason});
        if (shots_->usesDefaultSun(*scene_))
            sayNote("sun", "neither --time nor --sun given: azimuth 225, elevation 40 degrees");
        render::ContextOptions contextOptions;
        contextOptions.device = options_.device;
        auto context = render::Context::createHeadless(contextOptions);
        if (!context)
            return context.error();
        context_ = std::move(*context);
        report_.renderer = context_->rendererName();
        if (options_.picture.verbose)
            sayNote("renderer", report_.renderer);
        FrameOptions frameOptions = frameOptionsFor(options_.picture, *scene_);
        frameOptions.keepContents = needsContents();
        frameOptions.groundPatience = std::max(patience, frameOptions.groundPatience);
        frameOptions.groundMustBeKnown = true;
        auto renderer = FrameRenderer::create(*context_, *scene_, frameOptions);
        if (!renderer)
            return renderer.error();
        renderer_ = std::move(*renderer);
        // Until here nothing has been written, and a signal may end it at once.
        catchStopSignals();
        return openVideo();
    }

    // Nobody here asks for residentTiles(); the maps of lamps are cut from contents.
    bool needsContents() const {
        return !scene_->lamps.empty() &&
               std::any_of(planned_.begin(), planned_.end(), [&](const PlannedFrame& planned) {
                   return lampShare(shots_->at(planned.seconds, *scene_).sun.elevationDegrees) >
                          0.0;
               });
    }

    Failure openVideo() {
        if (!output_.isVideo())
            return {};
        VideoFormat format;
        format.container =
            output_.format() == OutputFormat::Mp4 ? Container::Mp4 : Container::Matroska;
        format.width = options_.picture.widthPixels;
        format.height = options_.picture.heightPixels;
        format.framesPerSecond = options_.framesPerSecond;
        auto video = VideoFile::create(output_.of(0), format);
        if (!video)
            return video.error();
        video_ = std::move(*video);
        return {};
    }

    std::vector<Coming> comingAfter(std::size_t index) const {
        std::vector<Coming> coming;
        for (std::size_t i = index + 1; i < std::min(index + 1 + kLookAhead, planned_.size());
             ++i) {
            const Shot shot = shots_->at(planned_[i].seconds, *scene_);
            coming.push_back({shot.camera, shot.sun, shot.time});
        }
        return coming;
    }

    // A failure ends the capture; a frame that lacks tiles does not.
    Failure drawFrame(std::size_t index) {
        const PlannedFrame& planned = planned_[index];
        const Shot shot = shots_->at(planned.seconds, *scene_);
        FrameRequest request;
        request.camera = shot.camera;
        request.sun = shot.sun;
        request.time = shot.time;
        request.still = !shots_->moves();
        request.deadline =
            Clock::now() + std::chrono::duration_cast<Clock::duration>(
                               std::chrono::duration<double>(options_.picture.timeoutSeconds));
        request.stopped = [] { return stopSignal() != 0; };
        request.coming = comingAfter(index);
        Result<FrameFacts> facts = renderer_->draw(request);
        saySkippedTiles();
        if (!facts)
            return named(planned, facts.error());
        if (stopSignal() && !facts->late.empty())
            return {}; // not late, but broken off
        ReportedFrame reported{planned.index, shot.time, shot.camera, shot.sun, *facts, {}, {}};
        Failure failure = judge(planned, *facts);
        if (!failure && facts->late.empty() && !facts->overBudget)
            failure = write(planned, shot, reported);
        report_.frames.push_back(std::move(reported));
        return failure;
    }

    std::string nameOf(const PlannedFrame& planned) const {
        return single_ ? output_.of(planned.index) : "frame " + std::to_string(planned.index);
    }
    Error named(const PlannedFrame& planned, const Error& error) const {
        return {single_ ? error.subject : nameOf(planned) + ": " + error.subject, error.reason,
                error.kind};
    }

    Error tooLarge(const PlannedFrame& planned) const {
        return {nameOf(planned), "its tiles do not fit into --memory, however coarse",
                ErrorKind::Usage};
    }
    Error late(const PlannedFrame& planned, const FrameFacts& facts) const {
        std::vector<std::string> tiles;
        for (std::size_t i = 0; i < facts.late.size(); ++i)
            tiles.push_back(facts.late[i] + (facts.lateReasons[i].empty()
                                                 ? ""
                                                 : " (" + facts.lateReasons[i] + ")"));
        return {nameOf(planned),
                "the time of --timeout passed while " + std::to_string(tiles.size()) +
                    " tiles were still loading: " + listed(tiles),
                ErrorKind::Transient};
    }

    // What a frame without all its tiles means for the run. A video cannot go on without a frame.
    Failure judge(const PlannedFrame& planned, const FrameFacts& facts) {
        if (facts.overBudget || !facts.late.empty()) {
            const Error lacking = facts.overBudget ? tooLarge(planned) : late(planned, facts);
            if (video_)
                return lacking;
            fail(lacking);
            return {};
        }
        if (!facts.missing.empty())
            exitCode_ = graver(exitCode_, exit_code::kSkipped);
        const double asked = options_.picture.frame.maximumScreenSpaceError;
        if (facts.screenSpaceError > asked) {
            char text[96];
            std::snprintf(text, sizeof text,
                          "its tiles do not fit into --memory: drawn with an "
                          "error of %.3g pixels",
                          facts.screenSpaceError);
            sayWarning(nameOf(planned), text);
            exitCode_ = graver(exitCode_, exit_code::kSkipped);
        } else if (facts.missing.empty() && !report_.fullDetailMs) {
            report_.fullDetailMs = millisecondsSince(start_);
        }
        return {};
    }

    void saySkippedTiles() {
        said_.resize(scene_->layers.size(), 0);
        for (std::size_t i = 0; i < scene_->layers.size(); ++i) {
            const auto& failures = scene_->layers[i].tileset->failures();
            for (; said_[i] < failures.size(); ++said_[i]) {
                const Error& error = failures[said_[i]].error;
                sayError(error);
                report_.skipped.push_back(error);
                exitCode_ = graver(exitCode_, exit_code::kSkipped);
            }
        }
    }

    // The picture comes last: where it is, all that goes with it is too.
    Failure write(const PlannedFrame& planned, const Shot& shot, ReportedFrame& reported) {
        for (const Aov aov : options_.aovs)
            if (Failure wrong = writeAov(planned, aov, reported))
                return wrong;
        Picture picture = renderer_->picture();
        drawOverlay(picture, shot);
        const std::string path = output_.of(planned.index);
        const bool whole =
            reported.facts.missing.empty() &&
            reported.facts.screenSpaceError <= options_.picture.frame.maximumScreenSpaceError;
        const Failure wrong =
            video_ ? video_->add(picture)
                   : writeImage(picture, imageFormat(), path, whole ? description() : "");
        if (wrong)
            return named(planned, *wrong);
        reported.files.push_back(path);
        return {};
    }

    void drawOverlay(Picture& picture, const Shot& shot) {
        if (!overlay_)
            return;
        setMoment(overlayFacts_, *scene_, shot, renderer_->groundHeightMetres());
        for (const std::string& name : overlay_->draw(picture, overlayFacts_))
            if (withoutRoom_.insert(name).second)
                sayWarning("overlay", "the picture has no room for " + name);
    }

    std::string pathOf(const PlannedFrame& planned, Aov aov) const {
        return output_.beside(planned.index, std::string(gnomon::nameOf(aov)) +
                                                 (aov == Aov::Cascade ? ".png" : ".exr"));
    }

    Failure writeAov(const PlannedFrame& planned, Aov aov, ReportedFrame& reported) {
        const FloatPicture picture = renderer_->aov(aov);
        const bool grey = aov == Aov::Cascade;
        const std::string path = pathOf(planned, aov);
        const Failure wrong = grey ? writeGreyPng(picture, path)
                                   : writeExr(picture, aov == Aov::Normal ? "XYZ" : "Y", path);
        if (wrong)
            return named(planned, *wrong);
        if (aov == Aov::Tile)
            reported.tileNames = renderer_->tileNames();
        reported.files.push_back(path);
        return {};
    }

    // A stopped video ends with its last complete frame; one that lacks a frame is not kept.
    Failure finishVideo() {
        if (!video_)
            return {};
        const bool whole = exitCode_ == exit_code::kDone || exitCode_ == exit_code::kSkipped;
        const bool any = std::any_of(report_.frames.begin(), report_.frames.end(),
                                     [](const ReportedFrame& f) { return !f.files.empty(); });
        if (!whole || !any)
            return {};
        return video_->finish();
    }

    Failure writeReport() const {
        if (!options_.picture.frameReport)
            return {};
        return writeFile(*options_.picture.frameReport, report_.json());
    }

    const CaptureOptions& options_;
    const OutputName output_;
    const Clock::time_point start_ = Clock::now();
    std::optional<Shots> shots_;
    std::vector<PlannedFrame> planned_;
    bool single_ = false; // one frame was asked for
    std::optional<Scene> scene_;
    bool inputsLeftOut_ = false;
    std::unique_ptr<render::Context> context_;
    std::unique_ptr<FrameRenderer> renderer_; // before its context and scene go
    std::unique_ptr<VideoFile> video_;
    std::unique_ptr<Overlay> overlay_; // null without
    OverlayFacts overlayFacts_;
    std::set<std::string> withoutRoom_; // told so far
    std::vector<std::size_t> said_;     // failures told so far, a count per layer
    FrameReport report_;
    ProgressBar bar_{"frames"};
    int exitCode_ = exit_code::kDone;
};

} // namespace

int runCapture(const CaptureOptions& options) {
    Result<OutputName> output = OutputName::parse(options.output);
    if (!output) {
        sayError(output.error());
        return exitCodeOf(output.error().kind);
    }
    return Capture(options, std::move(*output)).run();
}

} // namespace gnomon
