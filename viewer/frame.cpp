#include "viewer/frame.h"

#include "render/composite_pass.h"
#include "render/context.h"
#include "render/gpu_timer.h"
#include "render/visibility_pass.h"
#include "shadows/cascade_pass.h"
#include "shadows/light_basis.h"
#include "shadows/plane_maps.h"
#include "shadows/projective_pass.h"
#include "shadows/sun_pass.h"
#include "shadows/tight_fit.h"
#include "viewer/daylight.h"
#include "viewer/ground.h"
#include "viewer/lamps.h"
#include "viewer/shadow_range.h"
#include "viewer/tile_cache.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>

namespace gnomon {

namespace {

using Clock = std::chrono::steady_clock;

double millisecondsSince(Clock::time_point start) {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

// A window uploads a few tiles a frame, so that it never stalls; a capture all it needs.
constexpr std::size_t kWindowUploads = 4;

bool fitsTightly(const ShadowSettings& shadows, const FrameRequest& request) {
    return shadows.fit == ShadowFit::Tight || (shadows.fit == ShadowFit::Auto && request.still);
}

} // namespace

struct FrameRenderer::State {
    State(render::Context& gl, Scene& shown)
        : context(gl), scene(shown), cache(shown), lamps(shown) {}

    render::Context& context;
    Scene& scene;
    FrameOptions options;
    TileCache cache;
    std::optional<double> groundHeight;
    std::shared_ptr<const TileContent> groundContent;
    std::unique_ptr<render::GpuTile> ground;

    render::VisibilityPass visibilityPass;
    CascadePass cascadePass;
    ProjectivePass projectivePass;
    SunPass sunPass;
    LampLights lamps;
    render::CompositePass compositePass;
    render::GpuTimer timer;
    struct Last { // of the frame drawn last
        Camera camera;
        Camera surfaceCamera; // differs only where surfaces were kept
        std::vector<Selection> selections;
        std::vector<render::DrawItem> items;
        CascadeSet cascades;
        std::vector<ProjectiveMap> projective; // relative to `camera`
        glm::dvec3 towardsSun;                 // along the meshes' axes
        std::vector<DrawnCasters> drawn;       // of the cascades, then of these
    } last;

    void chooseGround();
    std::vector<Selection> select(const FrameRequest& request, std::span<const View> views,
                                  double& screenSpaceError, FrameFacts& facts);
    std::vector<render::DrawItem> drawItems(const FrameRequest& request,
                                            const std::vector<Selection>& selections);
    CascadeSet tightened(const CascadeInput& input, const ShadowSettings& shadows,
                         const CasterBound& casters);
    std::vector<ProjectiveMap> projectiveMaps(const CascadeInput& input, const CascadeSet& cascades,
                                              const ShadowSettings& shadows,
                                              const CasterBound& casters);
    std::vector<ResidentTile> residentTiles(const std::vector<Selection>& selections) const;
    std::vector<LampCaster> lampCasters(std::span<const render::DrawItem> items,
                                        const std::vector<Selection>& selections) const;
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
        if (!layer.stands(request.time)) {
            selections.emplace_back();
            continue;
        }
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

// Maps in the eye's perspective: for the planes most seen, or one for all.
std::vector<ProjectiveMap> FrameRenderer::State::projectiveMaps(const CascadeInput& input,
                                                                const CascadeSet& cascades,
                                                                const ShadowSettings& shadows,
                                                                const CasterBound& casters) {
    const glm::dvec4 reach =
        casterReach(casters, cascades.lightFromEcef, meshAxes(), input.camera.position);
    if (shadows.method == ShadowMethod::Perspective) {
        const auto map =
            perspectiveMap({input.camera, meshAxes(), last.towardsSun, input.nearMetres,
                            cascades.rangeMetres, reach, shadows.mapSize});
        return map ? std::vector{*map} : std::vector<ProjectiveMap>();
    }
    const std::vector<float> depth = visibilityPass.readViewDepth();
    const std::vector<std::uint16_t> normals = visibilityPass.readNormals();
    return planeOptimalMaps({{last.surfaceCamera, meshAxes(), depth, normals},
                             input.camera,
                             last.towardsSun,
                             reach,
                             cascades.rangeMetres},
                            shadows);
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

// The timer's marks stand after the visibility pass, each map, the sun, the lamps and the composite
// pass.
void FrameRenderer::State::noteCost(FrameFacts& facts) {
    facts.draws = visibilityPass.draws();
    const std::vector<double> times = timer.milliseconds();
    facts.visibilityMs = times.front();
    // The second mark of a cascade, where it has two, stands after its resolve.
    const auto perMap = std::size_t(CascadePass::marksPerMap(options.shadows));
    std::size_t at = 1;
    for (std::size_t i = 0; i < last.cascades.cascades.size(); ++i, at += perMap) {
        facts.depthMs.push_back(times[at]);
        facts.resolveMs += perMap == 2 ? times[at + 1] : 0.0;
    }
    for (; at + 3 < times.size(); ++at)
        facts.depthMs.push_back(times[at]);
    facts.sunMs = times[times.size() - 3];
    facts.lampMs = times[times.size() - 2];
    facts.lamps = std::uint32_t(lamps.live());
    facts.lampMapsDrawn = std::uint32_t(lamps.mapsDrawn());
    facts.compositeMs = times.back();
    for (const double ms : times)
        facts.gpuTotalMs += ms;
    facts.shadowBytes = (last.cascades.cascades.empty() ? 0 : cascadePass.bytes()) +
                        (last.projective.empty() ? 0 : projectivePass.bytes()) + lamps.bytes();
    facts.shadowRangeMetres = last.cascades.rangeMetres;
    facts.shadowFadeMetres = last.cascades.fadeMetres;
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
    const bool perspective = shadows.method == ShadowMethod::Perspective;
    if (perspective)
        shadows.cascades = 1; // finds the casters, and is not drawn

    // 1. The tiles that the camera sees, and how near and far their surfaces are.
    std::vector<View> views{perspectiveView(request.camera)};
    std::vector<Selection> selections = s.select(request, views, screenSpaceError, facts);
    facts.selectMs = millisecondsSince(start);
    Clock::time_point uploadStart = Clock::now();
    std::vector<render::DrawItem> items = s.drawItems(request, selections);
    facts.uploadMs = millisecondsSince(uploadStart);

    // 2. Cascades fitted to them, the lamps that are lit, and the tiles that cast into the maps of
    // both, in the picture or not.
    s.lamps.choose(request.camera, request.sun, shadows);
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
    }
    s.lamps.addViews(views);
    if (views.size() > 1) {
        const Clock::time_point selectStart = Clock::now();
        selections = s.select(request, views, screenSpaceError, facts);
        facts.selectMs += millisecondsSince(selectStart);
        uploadStart = Clock::now();
        items = s.drawItems(request, selections);
        facts.uploadMs += millisecondsSince(uploadStart);
    }
    if (!cascades.cascades.empty()) {
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
    // wished, to what is seen. And maps in the eye's perspective, for planes that are seen.
    if (perspective)
        cascades.cascades.clear();
    if (!cascades.cascades.empty() && fitsTightly(shadows, request))
        cascades = s.tightened(input, shadows, casters);
    s.last.drawn.clear();
    if (!cascades.cascades.empty())
        s.last.drawn = s.cascadePass.draw(cascades, shadows, items, s.timer);
    s.last.towardsSun = glm::transpose(s.meshAxes()) * request.sun.towards.xyz;
    s.last.projective.clear();
    if (perspective || shadows.method == ShadowMethod::PlaneOptimal)
        s.last.projective = s.projectiveMaps(input, cascades, shadows, casters);
    if (!s.last.projective.empty())
        for (DrawnCasters& drawn :
             s.projectivePass.draw({s.last.projective, request.camera, s.last.surfaceCamera,
                                    s.meshAxes(), s.last.towardsSun},
                                   shadows, items, s.timer))
            s.last.drawn.push_back(std::move(drawn));

    // 5. How much sun each surface gets; 6. what lamps give it; 7. the picture.
    SunPassInput sunInput{
        s.last.surfaceCamera, request.camera, request.sun.towards, nullptr, nullptr, casters,
        s.meshAxes()};
    if (shadows.method != ShadowMethod::Off)
        sunInput.cascades = &cascades;
    if (!cascades.cascades.empty())
        sunInput.maps = &s.cascadePass;
    if (!s.last.projective.empty())
        sunInput.projective = &s.projectivePass;
    s.sunPass.draw(s.visibilityPass, sunInput, shadows);
    s.timer.mark();
    if (s.lamps.live() > 0)
        s.lamps.draw(s.visibilityPass, s.last.surfaceCamera, s.lampCasters(items, selections));
    s.timer.mark();
    s.compositePass.draw(s.visibilityPass, s.sunPass.visibility(),
                         daylight(request.sun, s.last.surfaceCamera, s.meshAxes()),
                         s.lamps.light());
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
    return state_->residentTiles(state_->last.selections);
}

std::vector<ResidentTile>
FrameRenderer::State::residentTiles(const std::vector<Selection>& selections) const {
    std::vector<ResidentTile> tiles;
    if (groundContent)
        tiles.push_back({groundContent, 0});
    for (std::size_t layer = 0; layer < selections.size(); ++layer)
        for (const TileIndex index : selections[layer].draw)
            if (auto content = scene.layers[layer].tileset->content(index))
                if (const auto id = cache.idOf(layer, index))
                    tiles.push_back({std::move(content), *id});
    return tiles;
}

std::vector<LampCaster>
FrameRenderer::State::lampCasters(std::span<const render::DrawItem> items,
                                  const std::vector<Selection>& selections) const {
    std::map<std::uint32_t, std::shared_ptr<const TileContent>> contents;
    for (ResidentTile& tile : residentTiles(selections))
        contents.emplace(tile.id, std::move(tile.content));
    std::vector<LampCaster> casters;
    for (const render::DrawItem& item : items)
        if (const auto at = contents.find(item.tileId); at != contents.end())
            casters.push_back(
                {at->second, std::uint32_t(item.mesh - item.tile->meshes().data()), item.tile});
    return casters;
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
    const SeenSurfaces seen{s.last.surfaceCamera, s.meshAxes(), depth, {}};
    const SurfaceReader read(seen);
    const glm::dvec3 shift =
        glm::transpose(s.meshAxes()) * (s.last.surfaceCamera.position - s.last.camera.position).xyz;
    for (std::size_t i = 0; i < which.size(); ++i) {
        std::size_t c = which[i];
        if (c >= kFirstProjective && c - kFirstProjective < s.last.projective.size()) {
            const int x = int(i) % out.width, y = int(i) / out.width;
            out.values.push_back(
                float(texelMetres(s.last.projective[c - kFirstProjective], s.last.towardsSun,
                                  read.position(x, y) + shift)));
            continue;
        }
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

FloatPicture FrameRenderer::lampVisibility(std::size_t lamp) {
    State& s = *state_;
    if (auto shadow = s.lamps.shadowOf(s.visibilityPass, lamp))
        return {s.last.camera.widthPixels, s.last.camera.heightPixels, 1,
                std::move(shadow->visibility)};
    return {};
}

FloatPicture FrameRenderer::lampTexels(std::size_t lamp) {
    State& s = *state_;
    if (auto shadow = s.lamps.shadowOf(s.visibilityPass, lamp))
        return {s.last.camera.widthPixels, s.last.camera.heightPixels, 1,
                std::move(shadow->texelMetres)};
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
