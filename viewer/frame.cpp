#include "viewer/frame.h"

#include "render/composite_pass.h"
#include "render/context.h"
#include "render/gpu_timer.h"
#include "render/visibility_pass.h"
#include "shadows/cascade_pass.h"
#include "shadows/light_basis.h"
#include "shadows/sun_pass.h"
#include "shadows/tight_fit.h"
#include "viewer/daylight.h"
#include "viewer/ground.h"
#include "viewer/shadow_range.h"
#include "viewer/tile_cache.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace gnomon {

namespace {

using Clock = std::chrono::steady_clock;

double millisecondsSince(Clock::time_point start) {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

// A window uploads a few tiles a frame, so that it never stalls; a capture all it needs.
constexpr std::size_t kWindowUploads = 4;

} // namespace

struct FrameRenderer::State {
    State(render::Context& gl, Scene& shown) : context(gl), scene(shown), cache(shown) {}

    render::Context& context;
    Scene& scene;
    FrameOptions options;
    TileCache cache;
    std::optional<double> groundHeight;
    std::shared_ptr<const TileContent> groundContent;
    std::unique_ptr<render::GpuTile> ground;

    render::VisibilityPass visibilityPass;
    CascadePass cascadePass;
    SunPass sunPass;
    render::CompositePass compositePass;
    render::GpuTimer timer;
    struct Last { // of the frame drawn last
        Camera camera;
        Camera surfaceCamera; // differs only where surfaces were kept
        std::vector<Selection> selections;
        std::vector<render::DrawItem> items;
        CascadeSet cascades;
        std::vector<DrawnCasters> drawn;
    } last;

    void chooseGround();
    std::vector<Selection> select(const FrameRequest& request, std::span<const View> views,
                                  double& screenSpaceError, FrameFacts& facts);
    std::vector<render::DrawItem> drawItems(const FrameRequest& request,
                                            const std::vector<Selection>& selections);
    CascadeSet tightened(const CascadeInput& input, const ShadowSettings& shadows,
                         const CasterBound& casters);
    void noteTiles(const std::vector<Selection>& selections, FrameFacts& facts);
    void noteCost(FrameFacts& facts);
    glm::dmat3 meshAxes() const { return scene.ecefFromAnchor.axes(); }
    Transform<Light, Ecef> light(const FrameRequest& request) const {
        return lightFromEcef(scene.ecefFromAnchor, request.sun.towards);
    }
};

void FrameRenderer::State::chooseGround() {
    groundHeight = options.groundHeightMetres;
    if (options.groundAuto && !groundHeight)
        groundHeight = findGroundHeight(scene);
    ground.reset();
    if (!groundHeight)
        return;
    groundContent = std::make_shared<TileContent>(makeGround(scene, *groundHeight));
    std::vector<std::string> warnings;
    ground = std::make_unique<render::GpuTile>(*groundContent, warnings);
}

// What the views need, loaded; when the memory cannot hold it, at a larger error, which is said.
std::vector<Selection> FrameRenderer::State::select(const FrameRequest& request,
                                                    std::span<const View> views,
                                                    double& screenSpaceError, FrameFacts& facts) {
    std::vector<Selection> selections;
    facts.complete = true;
    for (Layer& layer : scene.layers) {
        if (!request.waitForTiles) {
            layer.tileset->poll();
            selections.push_back(
                gnomon::select(layer.tileset->tree(), views, {screenSpaceError, true}));
            layer.tileset->request(selections.back().load);
            facts.complete = facts.complete && selections.back().complete();
            continue;
        }
        Settled settled =
            settle(*layer.tileset, views, {screenSpaceError, false}, request.deadline);
        while (settled.overBudget && screenSpaceError < 1e6) {
            screenSpaceError *= 1.5;
            settled = settle(*layer.tileset, views, {screenSpaceError, false}, request.deadline);
        }
        facts.complete = facts.complete && settled.complete;
        selections.push_back(std::move(settled.selection));
    }
    return selections;
}

std::vector<render::DrawItem>
FrameRenderer::State::drawItems(const FrameRequest& request,
                                const std::vector<Selection>& selections) {
    const std::size_t uploads =
        request.waitForTiles ? std::numeric_limits<std::size_t>::max() : kWindowUploads;
    std::vector<render::DrawItem> items = cache.items(selections, uploads);
    if (ground)
        for (const render::GpuMesh& mesh : ground->meshes())
            items.push_back({ground.get(), &mesh, 0});
    return items;
}

// The casters' tiles were chosen for the looser cascades, which hold these.
CascadeSet FrameRenderer::State::tightened(const CascadeInput& input, const ShadowSettings& shadows,
                                           const CasterBound& casters) {
    const SeenReceivers seen =
        seenReceivers(last.surfaceCamera, visibilityPass.readViewDepth(), input.lightFromEcef,
                      casters.lightFromAnchor, input.farMetres);
    CascadeSet set = fitTightCascades(input, shadows, seen, casters);
    for (Cascade& cascade : set.cascades)
        setDepthRange(cascade, set.mapSize, casters);
    return set;
}

void FrameRenderer::State::noteTiles(const std::vector<Selection>& selections, FrameFacts& facts) {
    for (std::size_t i = 0; i < selections.size(); ++i) {
        const StreamedTileset& tileset = *scene.layers[i].tileset;
        facts.tilesSelected += std::uint32_t(selections[i].draw.size());
        facts.tilesLoaded += tileset.tilesLoaded();
        facts.decodedBytes += tileset.decodedBytes();
        for (const TileIndex tile : selections[i].failed)
            facts.missing.push_back(tileset.tree().node(tile).path);
        for (const LoadRequest& request : selections[i].load) {
            facts.missing.push_back(tileset.tree().node(request.tile).path);
            facts.late.push_back(facts.missing.back());
        }
    }
    facts.gpuBytes = cache.gpuBytes() + (ground ? ground->bytes() : 0);
}

// The timer's marks stand after the visibility pass, each map, the sun and the composite pass.
void FrameRenderer::State::noteCost(FrameFacts& facts) {
    facts.draws = visibilityPass.draws();
    const std::vector<double> times = timer.milliseconds();
    facts.visibilityMs = times.front();
    facts.depthMs.assign(times.begin() + 1, times.end() - 2);
    facts.sunMs = times[times.size() - 2];
    facts.compositeMs = times.back();
    for (const double ms : times)
        facts.gpuTotalMs += ms;
    for (std::size_t i = 0; i < last.cascades.cascades.size(); ++i) {
        const Cascade& cascade = last.cascades.cascades[i];
        facts.cascades.push_back(
            {cascade.nearMetres, cascade.farMetres, cascade.texelMetres,
             std::uint32_t(std::count(last.drawn[i].begin(), last.drawn[i].end(), true))});
    }
}

// ------------------------------------------------------------------------------------------------
// What happens in a frame, in order.
Result<FrameFacts> FrameRenderer::draw(const FrameRequest& request) {
    State& s = *state_;
    const Clock::time_point start = Clock::now();
    FrameFacts facts;
    double screenSpaceError = s.options.maximumScreenSpaceError;
    ShadowSettings shadows = s.options.shadows;
    if (sunShareAboveHorizon(request.sun.elevationDegrees,
                             geodeticOf(request.camera.position).heightMetres) == 0.0)
        shadows.method = ShadowMethod::Off;

    // 1. The tiles that the camera sees, and how near and far their surfaces are.
    std::vector<View> views{perspectiveView(request.camera)};
    std::vector<Selection> selections = s.select(request, views, screenSpaceError, facts);
    facts.selectMs = millisecondsSince(start);
    Clock::time_point uploadStart = Clock::now();
    std::vector<render::DrawItem> items = s.drawItems(request, selections);
    facts.uploadMs = millisecondsSince(uploadStart);

    // 2. Cascades fitted to them, and the tiles that cast into these, in the picture or not.
    CascadeInput input;
    CascadeSet cascades;
    CasterBound casters;
    if (shadows.method != ShadowMethod::Off) {
        const ShadowReach reach =
            shadowReach(s.scene, request.camera, request.sun, items, shadows, views.front());
        input = {request.camera,  s.light(request),  s.meshAxes(),    reach.nearMetres,
                 reach.farMetres, reach.rangeMetres, reach.fadeMetres};
        cascades = fitCascades(input, shadows);
        for (const Cascade& cascade : cascades.cascades)
            views.push_back(casterView(cascades, cascade));
        const Clock::time_point selectStart = Clock::now();
        selections = s.select(request, views, screenSpaceError, facts);
        facts.selectMs += millisecondsSince(selectStart);
        uploadStart = Clock::now();
        items = s.drawItems(request, selections);
        facts.uploadMs += millisecondsSince(uploadStart);
        casters = casterBound(s.scene, request.sun, cascades.lightFromEcef, items);
        for (Cascade& cascade : cascades.cascades)
            setDepthRange(cascade, cascades.mapSize, casters);
    }
    facts.screenSpaceError = screenSpaceError;
    s.noteTiles(selections, facts);

    // 3. What the camera sees.
    s.timer.start();
    if (!request.keepSurfaces) {
        facts.triangles = s.visibilityPass.draw(request.camera, items, s.meshAxes());
        s.last.surfaceCamera = request.camera;
    }
    s.timer.mark();

    // 4. Depth of the casters seen from the sun, a map a cascade; these fitted closer, if so
    // wished, to what is seen.
    if (!cascades.cascades.empty() && shadows.fit == ShadowFit::Tight)
        cascades = s.tightened(input, shadows, casters);
    s.last.drawn.clear();
    if (!cascades.cascades.empty())
        s.last.drawn = s.cascadePass.draw(cascades, shadows, items, s.timer);

    // 5. How much sun each surface gets; 6. the picture.
    SunPassInput sunInput{
        s.last.surfaceCamera, request.camera, request.sun.towards, nullptr, nullptr, casters,
        s.meshAxes()};
    if (!cascades.cascades.empty()) {
        sunInput.cascades = &cascades;
        sunInput.maps = &s.cascadePass;
    }
    s.sunPass.draw(s.visibilityPass, sunInput, shadows);
    s.timer.mark();
    s.compositePass.draw(s.visibilityPass, s.sunPass.visibility(),
                         daylight(request.sun, s.last.surfaceCamera, s.meshAxes()));
    s.timer.mark();
    s.context.finish();

    s.last.camera = request.camera;
    s.last.cascades = std::move(cascades);
    s.last.items = std::move(items);
    s.noteCost(facts);
    s.cache.evict(selections);
    s.last.selections = std::move(selections);
    if (s.context.lost())
        return Error{"OpenGL", "the graphics driver was reset", ErrorKind::Transient};
    facts.complete = facts.complete && !s.cache.leftOut();
    facts.totalMs = millisecondsSince(start);
    return facts;
}
// ------------------------------------------------------------------------------------------------

FrameRenderer::FrameRenderer(std::unique_ptr<State> state) : state_(std::move(state)) {}
FrameRenderer::~FrameRenderer() = default;

Result<std::unique_ptr<FrameRenderer>> FrameRenderer::create(render::Context& context, Scene& scene,
                                                             const FrameOptions& options) {
    std::unique_ptr<FrameRenderer> renderer(
        new FrameRenderer(std::make_unique<State>(context, scene)));
    renderer->state_->options = options;
    renderer->state_->chooseGround();
    return renderer;
}

void FrameRenderer::setOptions(const FrameOptions& options) {
    State& s = *state_;
    const bool sameGround = options.groundAuto == s.options.groundAuto &&
                            options.groundHeightMetres == s.options.groundHeightMetres;
    s.options = options;
    if (!sameGround)
        s.chooseGround();
}

std::optional<double> FrameRenderer::groundHeightMetres() const {
    return state_->groundHeight;
}

Picture FrameRenderer::picture() {
    return {state_->last.camera.widthPixels, state_->last.camera.heightPixels,
            state_->compositePass.read()};
}

FloatPicture FrameRenderer::aov(Aov which) {
    State& s = *state_;
    FloatPicture out{s.last.camera.widthPixels, s.last.camera.heightPixels, 1, {}};
    const std::vector<float> depth = s.visibilityPass.readViewDepth();
    const auto isSky = [&](std::size_t i) { return std::isinf(depth[i]); };
    switch (which) {
    case Aov::Sun:
        out.values = s.sunPass.readVisibility();
        for (std::size_t i = 0; i < depth.size(); ++i)
            if (isSky(i))
                out.values[i] = -1.0f;
        break;
    case Aov::Depth:
        out.values = depth;
        break;
    case Aov::Cascade:
        for (const std::uint8_t c : s.sunPass.readCascades())
            out.values.push_back(float(c));
        break;
    case Aov::Tile: {
        const std::vector<std::uint32_t> ids = s.visibilityPass.readTiles();
        out.values.assign(ids.begin(), ids.end());
        break;
    }
    case Aov::Normal: {
        out.channels = 3;
        const std::vector<std::uint16_t> oct = s.visibilityPass.readNormals();
        const glm::dmat3 enuFromStored =
            glm::transpose(ecefFromEnu(geodeticOf(s.last.camera.position)).axes()) * s.meshAxes();
        for (std::size_t i = 0; i < depth.size(); ++i) {
            const auto signedOf = [&](std::size_t c) {
                return std::int16_t(std::lround((oct[4 * i + c] / 65535.0 * 2.0 - 1.0) * 32767.0));
            };
            const glm::dvec3 n =
                isSky(i) ? glm::dvec3(0.0) : enuFromStored * decodeOct({signedOf(0), signedOf(1)});
            out.values.insert(out.values.end(), {float(n.x), float(n.y), float(n.z)});
        }
        break;
    }
    }
    return out;
}

std::vector<ResidentTile> FrameRenderer::residentTiles() const {
    const State& s = *state_;
    std::vector<ResidentTile> tiles;
    if (s.groundContent)
        tiles.push_back({s.groundContent, 0});
    for (std::size_t layer = 0; layer < s.last.selections.size(); ++layer)
        for (const TileIndex index : s.last.selections[layer].draw)
            if (auto content = s.scene.layers[layer].tileset->content(index))
                if (const auto id = s.cache.idOf(layer, index))
                    tiles.push_back({std::move(content), *id});
    return tiles;
}

std::vector<std::vector<MeshId>> FrameRenderer::drawnCasters() const {
    const State& s = *state_;
    std::vector<std::vector<MeshId>> lists;
    for (const DrawnCasters& drawn : s.last.drawn) {
        std::vector<MeshId>& list = lists.emplace_back();
        for (std::size_t i = 0; i < drawn.size(); ++i)
            if (drawn[i])
                list.push_back(
                    {s.last.items[i].tileId,
                     std::uint32_t(s.last.items[i].mesh - s.last.items[i].tile->meshes().data())});
        std::sort(list.begin(), list.end());
    }
    return lists;
}

FloatPicture FrameRenderer::texels() {
    State& s = *state_;
    FloatPicture out{s.last.camera.widthPixels, s.last.camera.heightPixels, 1, {}};
    const std::vector<std::uint8_t> which = s.sunPass.readCascades();
    const std::vector<float> depth = s.visibilityPass.readViewDepth();
    const std::vector<Cascade>& cascades = s.last.cascades.cascades;
    for (std::size_t i = 0; i < which.size(); ++i) {
        std::size_t c = which[i];
        if (c >= cascades.size()) {
            out.values.push_back(0.0f);
            continue;
        }
        // Where two are mixed, the coarser.
        if (depth[i] > cascades[c].blendStartMetres && c + 1 < cascades.size())
            ++c;
        out.values.push_back(float(cascades[c].texelMetres));
    }
    return out;
}

FloatPicture FrameRenderer::lampVisibility(std::size_t) {
    return {};
}

FloatPicture FrameRenderer::lampTexels(std::size_t) {
    return {};
}

glm::dmat3 FrameRenderer::meshAxes() const {
    return state_->meshAxes();
}

const std::vector<std::string>& FrameRenderer::tileNames() const {
    return state_->cache.names();
}

void FrameRenderer::present(int windowWidth, int windowHeight) {
    state_->compositePass.present(windowWidth, windowHeight);
}

} // namespace gnomon
