// One view, drawn by one shadow technique after another: what each costs, and how wrong it is
// against rays over the triangles that were drawn. The measuring itself; the command line around
// it is viewer/evaluate_command.cpp.
#pragma once

#include "bench/flips.h"
#include "bench/lost_casters.h"
#include "bench/metrics.h"
#include "bench/techniques.h"

#include <functional>
#include <memory>

namespace gnomon::bench {

struct EvaluationInput {
    Scene& scene;
    FrameRenderer& renderer;
    FrameOptions base; // what techniques start from; its light's size is the reference's
    Camera camera;
    SunPosition sun;
    std::optional<UtcTime> time; // what stands then
    std::vector<Probe> probes;
    // To count flips along; empty: not asked, and the picture stands alone (FrameRequest::still).
    std::vector<Camera> path;
    int raysPerPixel = 64;
    int framesTimed = 7;
    double timeoutSeconds = 60.0; // for the tiles of a frame
};

// A technique's row. Times are medians of the frames timed.
struct Row {
    Technique technique;
    std::optional<Error> error; // it cannot be had in this view; nothing else is set then
    double frameMs = 0.0;       // by the clock, the choice of tiles and all
    double gpuMs = 0.0, visibilityMs = 0.0, sunMs = 0.0;
    std::vector<double> depthMs;     // a value a map
    std::optional<double> resolveMs; // of all maps, where two layers become a depth
    std::size_t bytes = 0;           // of the maps
    std::vector<double> texelMetres; // a value a cascade
    FrameFacts facts;                // of the last frame timed
    Comparison comparison;
    std::vector<float> visibility; // its answer
    std::optional<std::uint64_t> lostCasters;
    std::optional<Flips> flips;
};

class Evaluation {
  public:
    // Hears what is being done and how far it is; answers false to stop it all.
    using Progress = std::function<bool(const char* what, std::size_t done, std::size_t all)>;

    // Draws the base once, so that all tiles are there, and traces the reference over them.
    static Result<Evaluation> prepare(const EvaluationInput& input, Progress progress);
    Evaluation(Evaluation&&) noexcept;
    ~Evaluation();

    // A technique that cannot be had is a row with an error; this fails when nothing can go on.
    Result<Row> measure(const Technique& technique);

    const Reference& reference() const;
    std::uint64_t litFacing() const; // pixels facing the sun in the base's shadow range
    Picture picture() const;         // as the base draws it
    // What is not as it should be, in whole sentences; and tiles that failed to load.
    const std::vector<std::string>& warnings() const;
    bool lacksTiles() const;

  private:
    struct State;
    explicit Evaluation(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

} // namespace gnomon::bench
