#include "bench/evaluate.h"

#include "bench/surfaces.h"

#include <algorithm>
#include <chrono>
#include <cstdio>

namespace gnomon::bench {

namespace {

using Clock = std::chrono::steady_clock;

// The first frames of a technique compile its programs and fill its maps.
constexpr int kWarmUpFrames = 2;

Error stopped() {
    return {"evaluate", "stopped", ErrorKind::Transient};
}

double median(std::vector<double> values) {
    if (values.empty())
        return 0.0;
    std::sort(values.begin(), values.end());
    const std::size_t half = values.size() / 2;
    return values.size() % 2 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

template <class Get>
double medianOf(const std::vector<FrameFacts>& frames, const Get& get) {
    std::vector<double> values;
    for (const FrameFacts& frame : frames)
        values.push_back(get(frame));
    return median(std::move(values));
}

void noteTimes(const std::vector<FrameFacts>& frames, Row& row) {
    row.frameMs = medianOf(frames, [](const FrameFacts& f) { return f.totalMs; });
    row.gpuMs = medianOf(frames, [](const FrameFacts& f) { return f.gpuTotalMs; });
    row.visibilityMs = medianOf(frames, [](const FrameFacts& f) { return f.visibilityMs; });
    row.sunMs = medianOf(frames, [](const FrameFacts& f) { return f.sunMs; });
    for (std::size_t i = 0; i < frames.back().depthMs.size(); ++i)
        row.depthMs.push_back(medianOf(frames, [i](const FrameFacts& f) {
            return i < f.depthMs.size() ? f.depthMs[i] : 0.0;
        }));
    if (frames.back().resolveMs > 0.0)
        row.resolveMs = medianOf(frames, [](const FrameFacts& f) { return f.resolveMs; });
    row.bytes = frames.back().shadowBytes;
    for (const CascadeFacts& cascade : frames.back().cascades)
        row.texelMetres.push_back(cascade.texelMetres);
}

} // namespace

struct Evaluation::State {
    State(const EvaluationInput& in, Progress p) : input(in), progress(std::move(p)) {}

    EvaluationInput input;
    Progress progress;
    std::optional<RayScene> rays;
    Light sun;
    Reference reference;
    std::optional<Reference> lampReference; // of the first lamp, when it was asked for
    std::optional<LostCasters> lostCasters;
    std::uint64_t litFacing = 0;
    Picture picture;
    std::vector<std::string> warnings;
    bool lacksTiles = false;

    FrameRequest request() const {
        FrameRequest request;
        request.camera = input.camera;
        request.sun = input.sun;
        request.time = input.time;
        request.still = input.path.empty();
        request.withoutWater = true;
        request.deadline = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                              std::chrono::duration<double>(input.timeoutSeconds));
        return request;
    }
    bool goOn(const char* what, std::size_t done, std::size_t all) const {
        return !progress || progress(what, done, all);
    }
    Failure drawBase();
    Failure trace();
    Result<FrameFacts> drawWhole();
    Failure drawTimed(Row& row);
    void fadeOut(Answer& answer, const FrameFacts& facts) const;
    Answer answerOfSun(const Technique& technique, const FrameFacts& facts);
    Failure measureLamp(Row& row);
    void measureSun(Row& row);
    Failure measureFlips(Row& row);
    Light lampLight() const;
    void warnOnce(const std::string& text) {
        if (std::find(warnings.begin(), warnings.end(), text) == warnings.end())
            warnings.push_back(text);
    }
};

// A frame with every tile it wants; one that lacks some because they were late is none.
Result<FrameFacts> Evaluation::State::drawWhole() {
    Result<FrameFacts> facts = input.renderer.draw(request());
    if (!facts)
        return facts;
    if (!facts->late.empty())
        return Error{"evaluate",
                     "the time of --timeout passed while " + std::to_string(facts->late.size()) +
                         " tiles were still loading, " + facts->late.front() + " among them",
                     ErrorKind::Transient};
    for (const std::string& tile : facts->missing) {
        warnOnce(tile + " is missing, here and in the reference");
        lacksTiles = true;
    }
    if (facts->screenSpaceError > input.base.maximumScreenSpaceError) {
        char text[96];
        std::snprintf(text, sizeof text,
                      "its tiles do not fit into --memory: drawn with an error of %.3g pixels",
                      facts->screenSpaceError);
        warnOnce(text);
        lacksTiles = true;
    }
    return facts;
}

// The base as it is asked for, but never without shadows: their casters have to be there.
Failure Evaluation::State::drawBase() {
    FrameOptions options = input.base;
    if (options.shadows.method == ShadowMethod::Off)
        options.shadows.method = ShadowMethod::Cascades;
    input.renderer.setOptions(options);
    const Result<FrameFacts> facts = drawWhole();
    if (!facts)
        return facts.error();
    picture = input.renderer.picture();
    const std::vector<ResidentTile> resident = input.renderer.residentTiles();
    Result<RayScene> built =
        RayScene::build(resident, input.camera.position, input.renderer.meshAxes());
    if (!built)
        return built.error();
    rays.emplace(std::move(*built));
    sun = SunDisc{rays->stored(input.sun.towards), input.base.shadows.lightDiameterDegrees};
    if (Failure failure = trace())
        return failure;
    const Answer answer = answerOfSun({"", options.shadows, false}, *facts);
    for (std::size_t i = 0; i < reference.surfaces.size(); ++i) {
        const SurfacePoint& s = reference.surfaces[i];
        litFacing += s.any && answer.texels[i] > 0.0f &&
                     glm::dot(s.normal, towardsLight(sun, s.position)) > 0.0;
    }
    std::optional<std::string> warning;
    lostCasters = LostCasters::find(*rays, reference, sun, input.scene, resident, input.camera,
                                    facts->screenSpaceError, request().deadline, warning);
    if (warning)
        warnOnce(*warning);
    return {};
}

Failure Evaluation::State::trace() {
    ReferenceOptions options;
    options.light = sun;
    options.raysPerPixel = input.raysPerPixel;
    Result<Reference> traced =
        traceReference(*rays, input.camera, options, [this](int done, int all) {
            return goOn("rows of rays", std::size_t(done), std::size_t(all));
        });
    if (!traced)
        return traced.error();
    reference = std::move(*traced);
    return {};
}

Failure Evaluation::State::drawTimed(Row& row) {
    std::vector<FrameFacts> frames;
    for (int i = 0; i < kWarmUpFrames + input.framesTimed; ++i) {
        if (!goOn(nullptr, 0, 0))
            return stopped();
        Result<FrameFacts> facts = drawWhole();
        if (!facts)
            return facts.error();
        if (i >= kWarmUpFrames)
            frames.push_back(std::move(*facts));
    }
    noteTimes(frames, row);
    row.facts = std::move(frames.back());
    return {};
}

// Where shadows fade by design they are not held against rays.
void Evaluation::State::fadeOut(Answer& answer, const FrameFacts& facts) const {
    const double whole = facts.shadowRangeMetres - facts.shadowFadeMetres;
    const glm::dvec3 eye = rays->stored(input.camera.position);
    for (std::size_t i = 0; i < answer.texels.size(); ++i)
        if (reference.surfaces[i].any && glm::length(reference.surfaces[i].position - eye) > whole)
            answer.texels[i] = 0.0f;
}

Answer Evaluation::State::answerOfSun(const Technique& technique, const FrameFacts& facts) {
    Answer answer;
    answer.visibility = input.renderer.aov(Aov::Sun).values;
    answer.texels = input.renderer.texels().values;
    answer.viewDepths = input.renderer.aov(Aov::Depth).values;
    answer.filterRadiusTexels = filterRadiusTexels(technique.settings);
    answer.soft = isSoft(technique.settings);
    fadeOut(answer, facts);
    return answer;
}

void Evaluation::State::measureSun(Row& row) {
    const Answer answer = answerOfSun(row.technique, row.facts);
    row.comparison = compare(*rays, reference, sun, answer, input.camera, input.probes,
                             input.scene.ecefFromAnchor);
    row.visibility = answer.visibility;
    if (row.technique.settings.method == ShadowMethod::Off)
        return; // only its time is asked
    if (row.comparison.metrics.litFacing == 0) {
        row.error = Error{row.technique.text,
                          "no surface in the picture faces the sun within its shadow range"};
        return;
    }
    row.lostCasters = lostCasters->count(input.renderer, row.comparison);
}

Light Evaluation::State::lampLight() const {
    const Lamp& lamp = input.scene.lamps.front();
    return LampPoint{rays->stored(lamp.position), rays->stored(lamp.facing)};
}

Failure Evaluation::State::measureLamp(Row& row) {
    if (input.scene.lamps.empty()) {
        row.error = Error{row.technique.text, "this scene has no lamp"};
        return {};
    }
    const Light light = lampLight();
    if (!lampReference) {
        Result<Reference> traced =
            traceReference(*rays, input.camera, {light, 1, 0}, [this](int done, int all) {
                return goOn("rows of rays", std::size_t(done), std::size_t(all));
            });
        if (!traced)
            return traced.error();
        lampReference = std::move(*traced);
    }
    Answer answer;
    answer.visibility = input.renderer.lampVisibility(0).values;
    answer.texels = input.renderer.lampTexels(0).values;
    if (answer.visibility.empty() || answer.texels.size() != answer.visibility.size()) {
        row.error = Error{row.technique.text, "its lamps are not drawn in this view"};
        return {};
    }
    answer.viewDepths = input.renderer.aov(Aov::Depth).values;
    answer.filterRadiusTexels = filterRadiusTexels(row.technique.settings);
    answer.soft = false;
    row.comparison =
        compare(*rays, *lampReference, light, answer, input.camera, {}, input.scene.ecefFromAnchor);
    row.visibility = std::move(answer.visibility);
    return {};
}

Failure Evaluation::State::measureFlips(Row& row) {
    if (input.path.empty() || row.technique.ofLamps)
        return {};
    const Result<Flips> flips = countFlips(input.renderer, request(), row.technique.settings,
                                           input.path, [this] { return goOn(nullptr, 0, 0); });
    if (!flips)
        return flips.error();
    row.flips = *flips;
    return {};
}

Evaluation::Evaluation(std::unique_ptr<State> state) : state_(std::move(state)) {}
Evaluation::Evaluation(Evaluation&&) noexcept = default;
Evaluation::~Evaluation() = default;

Result<Evaluation> Evaluation::prepare(const EvaluationInput& input, Progress progress) {
    auto state = std::make_unique<State>(input, std::move(progress));
    if (Failure failure = state->drawBase())
        return *failure;
    return Evaluation(std::move(state));
}

Result<Row> Evaluation::measure(const Technique& technique) {
    State& s = *state_;
    Row row;
    row.technique = technique;
    FrameOptions options = s.input.base;
    options.shadows = technique.settings;
    s.input.renderer.setOptions(options);
    if (Failure failure = s.drawTimed(row))
        return *failure;
    if (technique.ofLamps) {
        if (Failure failure = s.measureLamp(row))
            return *failure;
    } else {
        s.measureSun(row);
    }
    if (!row.error)
        if (Failure failure = s.measureFlips(row))
            return *failure;
    return row;
}

const Reference& Evaluation::reference() const {
    return state_->reference;
}
std::uint64_t Evaluation::litFacing() const {
    return state_->litFacing;
}
Picture Evaluation::picture() const {
    return state_->picture;
}
const std::vector<std::string>& Evaluation::warnings() const {
    return state_->warnings;
}
bool Evaluation::lacksTiles() const {
    return state_->lacksTiles;
}

} // namespace gnomon::bench
