#include "viewer/frame.h"

#include "render/context.h"
#include "shadows/light_basis.h"
#include "shadows/plane_maps.h"
#include "shadows/tight_fit.h"
#include "viewer/daylight.h"
#include "viewer/frame_state.h"
#include "viewer/ground.h"
#include "viewer/shadow_range.h"

#include <algorithm>
#include <limits>
#include <map>

namespace gnomon {

namespace {

using Clock = std::chrono::steady_clock;

double millisecondsSince(Clock::time_point start) {
    return std::chrono::duration<double, std::milli>(Clock::now() - start).count();
}

// Where tiles do not fit, the error is raised by so much at a time; as coarse as the last, whatever
// there is is drawn by its roots.
constexpr double kCoarserStep = 1.5;
constexpr double kCoarsest = 1e6;

bool fitsTightly(const ShadowSettings& shadows, const FrameRequest& request) {
    return shadows.fit == ShadowFit::Tight || (shadows.fit == ShadowFit::Auto && request.still);
}

// By night nothing has a shadow of the sun; a map in the eye's perspective wants one cascade, which
// finds its casters and is not drawn.
ShadowSettings shadowsOf(const FrameOptions& options, const FrameRequest& request) {
    ShadowSettings shadows = options.shadows;
    if (sunShareAboveHorizon(request.sun.elevationDegrees,
                             geodeticOf(request.camera.position).heightMetres) == 0.0)
        shadows.method = ShadowMethod::Off;
    if (shadows.method == ShadowMethod::Perspective)
        shadows.cascades = 1;
    return shadows;
}

// Surfaces of the same camera, into what was gathered already.
void add(SeenReceivers& seen, const SeenReceivers& more) {
    std::vector<SeenReceivers::Bin> bins = std::move(seen.bins);
    bins.insert(bins.end(), more.bins.begin(), more.bins.end());
    std::sort(bins.begin(), bins.end(),
              [](const auto& a, const auto& b) { return a.nearMetres < b.nearMetres; });
    seen.bins.clear();
    for (const SeenReceivers::Bin& bin : bins) {
        if (seen.bins.empty() || bin.nearMetres > seen.bins.back().farMetres) {
            seen.bins.push_back(bin);
            continue;
        }
        SeenReceivers::Bin& last = seen.bins.back();
        last.farMetres = std::max(last.farMetres, bin.farMetres);
        last.bounds = {glm::min(last.bounds.min, bin.bounds.min),
                       glm::max(last.bounds.max, bin.bounds.max)};
        last.lowestMetres = std::min(last.lowestMetres, bin.lowestMetres);
    }
}

} // namespace

FrameRenderer::State::Frame::Frame(const FrameRequest& of, const FrameOptions& options,
                                   double maximumScreenSpaceError)
    : request(of), shadows(shadowsOf(options, of)),
      screenSpaceError(maximumScreenSpaceError), views{perspectiveView(of.camera)} {}

// ------------------------------------------------------------------------------------------------
// What happens in a frame, in order.
Result<FrameFacts> FrameRenderer::draw(const FrameRequest& request) {
    State& s = *state_;
    const Clock::time_point start = Clock::now();
    const double coarser = request.waitForTiles ? 1.0 : s.coarser;
    State::Frame frame(request, s.options, coarser * s.options.maximumScreenSpaceError);

    s.showWater(frame);   // 1. how it stands at this moment
    s.findTiles(frame);   // 2. that the camera sees, and how near and far their surfaces are
    s.fitShadows(frame);  // 3. cascades fitted to both, and the lamps that are lit
    s.findCasters(frame); // 4. the tiles that cast into the maps of these, in the picture or not
    s.askForMore(frame);  //    and of what comes next, to be loaded meanwhile

    s.timer.start();
    s.drawSurfaces(frame); // 5. what the camera sees: the nearest surface, and water over it
    s.drawMaps(frame);     // 6. depth of the casters seen from the sun
    s.drawLight(frame);    // 7. how much sun each surface gets, and what lamps give it
    s.drawPicture(frame);  // 8. light, haze and sky
    s.context.finish();

    s.noteCost(frame);
    FrameFacts facts = s.keep(std::move(frame));
    if (s.context.lost())
        return Error{"OpenGL", "the graphics driver was reset", ErrorKind::Transient};
    if (s.context.outOfMemory())
        return Error{"OpenGL",
                     "there is not enough graphics memory for this frame: a smaller --memory, "
                     "--map-size or --size asks for less",
                     ErrorKind::Transient};
    facts.totalMs = millisecondsSince(start);
    return facts;
}
// ------------------------------------------------------------------------------------------------

MemoryLedger* FrameRenderer::State::ledger() const {
    return scene.layers.empty() ? nullptr : &scene.layers.front().tileset->ledger();
}

std::vector<StreamedTileset*> FrameRenderer::State::standing(std::optional<UtcTime> time) const {
    std::vector<StreamedTileset*> tilesets;
    for (const Layer& layer : scene.layers)
        tilesets.push_back(layer.stands(time) ? layer.tileset.get() : nullptr);
    return tilesets;
}

void FrameRenderer::State::select(Frame& frame) {
    const Clock::time_point start = Clock::now();
    for (const Layer& layer : scene.layers)
        if (!layer.stands(frame.request.time))
            layer.tileset->rest();
    if (frame.request.waitForTiles)
        settleTiles(frame);
    else
        takeTiles(frame);
    frame.facts.selectMs += millisecondsSince(start);
}

// What the views need, loaded and on the GPU; when the memory cannot hold it, at a larger error,
// which is said.
void FrameRenderer::State::settleTiles(Frame& frame) {
    const FrameRequest& request = frame.request;
    double& error = frame.screenSpaceError;
    const std::vector<StreamedTileset*> tilesets = standing(request.time);
    const auto settleAt = [&](double maximumError) {
        return settle(tilesets,
                      {frame.views,
                       {maximumError, false},
                       request.deadline,
                       request.stopped,
                       [this](std::size_t layer, TileIndex tile) { cache.upload(layer, tile); }});
    };
    SettledAll settled = settleAt(error);
    while (settled.overBudget && error < kCoarsest) {
        error *= kCoarserStep;
        settled = settleAt(error);
    }
    frame.facts.complete = settled.complete;
    frame.facts.overBudget = settled.overBudget;
    frame.selections = std::move(settled.selections);
}

// What is there already; the rest is asked for in askForMore().
void FrameRenderer::State::takeTiles(Frame& frame) {
    const std::vector<StreamedTileset*> tilesets = standing(frame.request.time);
    // While what the last frame used still counts as used.
    const bool isFirst = frame.selections.empty();
    for (StreamedTileset* tileset : tilesets)
        if (isFirst && tileset)
            tileset->poll();
    if (isFirst && ledger())
        ledger()->nextMoment();
    frame.selections.clear();
    frame.facts.complete = true;
    for (StreamedTileset* tileset : tilesets) {
        if (!tileset) {
            frame.selections.emplace_back();
            continue;
        }
        frame.selections.push_back(
            gnomon::select(tileset->tree(), frame.views, {frame.screenSpaceError, true}));
        tileset->use(frame.selections.back().draw);
        tileset->use(frame.selections.back().wanted);
        frame.facts.complete = frame.facts.complete && frame.selections.back().complete();
    }
}

void FrameRenderer::State::findTiles(Frame& frame) {
    select(frame);
    const Clock::time_point start = Clock::now();
    std::optional<Clock::duration> uploadTime;
    if (!frame.request.waitForTiles)
        uploadTime = frame.uploadTime;
    frame.items = cache.items(frame.selections, uploadTime);
    frame.uploadTime -= std::min(frame.uploadTime, Clock::now() - start);
    if (ground)
        for (const render::GpuMesh& mesh : ground->meshes())
            frame.items.push_back({ground.get(), &mesh, 0});
    frame.facts.uploadMs += millisecondsSince(start);
}

void FrameRenderer::State::showWater(Frame& frame) {
    if (frame.request.withoutWater)
        waters.hide();
    else if (!frame.request.keepSurfaces) {
        const Clock::time_point start = Clock::now();
        frame.facts.missing = waters.show(frame.request.time);
        frame.facts.uploadMs += millisecondsSince(start);
    }
    if (ledger())
        ledger()->setOther(waters.bytes() + (ground ? ground->bytes() : 0));
}

void FrameRenderer::State::fitShadows(Frame& frame) {
    lamps.choose(frame.request.camera, frame.request.sun, frame.shadows);
    fitCascadesTo(frame);
    lamps.addViews(frame.views);
}

void FrameRenderer::State::fitCascadesTo(Frame& frame) const {
    if (frame.shadows.method == ShadowMethod::Off)
        return;
    const FrameRequest& request = frame.request;
    const std::vector<OrientedBox> waterBoxes = waters.boxes();
    const ShadowReach reach = shadowReach(scene, request.camera, request.sun, frame.items,
                                          frame.shadows, frame.views.front(), waterBoxes);
    frame.input = {request.camera,  lightFromEcef(scene.ecefFromAnchor, request.sun.towards),
                   meshAxes(),      reach.nearMetres,
                   reach.farMetres, reach.rangeMetres,
                   reach.fadeMetres};
    frame.cascades = fitCascades(frame.input, frame.shadows);
    for (const Cascade& cascade : frame.cascades.cascades)
        frame.views.push_back(casterView(frame.cascades, cascade));
}

void FrameRenderer::State::findCasters(Frame& frame) {
    if (frame.views.size() > 1)
        findTiles(frame);
    if (!frame.cascades.cascades.empty()) {
        frame.casters =
            casterBound(scene, frame.request.sun, frame.cascades.lightFromEcef, frame.items);
        for (Cascade& cascade : frame.cascades.cascades)
            setDepthRange(cascade, frame.cascades.mapSize, frame.casters);
    }
    noteTiles(frame);
}

void FrameRenderer::State::askForMore(Frame& frame) {
    if (frame.request.waitForTiles) {
        if (frame.facts.complete)
            prefetch(frame);
        return;
    }
    bool noRoom = false;
    StreamedTileset::Need need;
    const std::vector<StreamedTileset*> tilesets = standing(frame.request.time);
    for (std::size_t i = 0; i < tilesets.size(); ++i) {
        if (!tilesets[i])
            continue;
        noRoom = noRoom || tilesets[i]->foundNoRoom();
        need.bytes += tilesets[i]->needOf(frame.selections[i].wanted).bytes;
        tilesets[i]->request(frame.selections[i].load);
    }
    // Back only when the finer picture, of about as many more tiles as the error's square is
    // smaller, is sure to fit: else it would go to and fro.
    constexpr double kFiner = kCoarserStep * kCoarserStep;
    if (noRoom)
        coarser = std::min(coarser * kCoarserStep, kCoarsest);
    else if (coarser > 1.0 && frame.facts.complete &&
             kFiner * double(need.bytes) < double(ledger()->cap()))
        coarser = std::max(coarser / kCoarserStep, 1.0);
    frame.facts.complete = frame.facts.complete && !noRoom;
}

// Their shadows are fitted as those of this frame are, to the surfaces of this frame: they differ
// little. What the tiles of coming frames are is decided anew when these are drawn.
void FrameRenderer::State::prefetch(const Frame& frame) {
    std::vector<std::vector<Selection>> wanted(scene.layers.size());
    for (const Coming& next : frame.request.coming) {
        FrameRequest request;
        request.camera = next.camera;
        request.sun = next.sun;
        request.time = next.time;
        Frame coming(request, options, frame.screenSpaceError);
        coming.items = frame.items;
        fitCascadesTo(coming);
        const std::vector<StreamedTileset*> tilesets = standing(next.time);
        for (std::size_t i = 0; i < tilesets.size(); ++i)
            if (tilesets[i])
                wanted[i].push_back(gnomon::select(tilesets[i]->tree(), coming.views,
                                                   {coming.screenSpaceError, false}));
    }
    for (std::size_t i = 0; i < wanted.size(); ++i)
        scene.layers[i].tileset->requestAhead(wanted[i]);
}

void FrameRenderer::State::drawSurfaces(Frame& frame) {
    const Camera& camera = frame.request.camera;
    const bool kept = frame.request.keepSurfaces;
    if (!kept) {
        frame.facts.triangles = visibilityPass.draw(camera, frame.items, meshAxes());
        last.surfaceCamera = camera;
    }
    timer.mark();
    if (!kept || frame.request.withoutWater)
        waterPass.clear();
    if (!kept && !waters.items().empty())
        frame.facts.waterTriangles = waterPass.draw(
            visibilityPass, {camera, meshAxes(), waters.items(), groundErrors(frame)});
    timer.mark();
}

// A value a tile number. Only of terrain: what stands on it is what it is at any level.
std::vector<float> FrameRenderer::State::groundErrors(const Frame& frame) const {
    std::vector<float> errors(cache.names().size(), 0.0f);
    for (std::size_t i = 0; i < frame.selections.size(); ++i)
        if (scene.layers[i].terrain)
            for (const TileIndex tile : frame.selections[i].draw)
                if (const auto id = cache.idOf(i, tile))
                    errors[*id] =
                        float(scene.layers[i].tileset->tree().node(tile).geometricErrorMetres);
    return errors;
}

// A map a cascade; these fitted closer, if so wished, to what is seen. And maps in the eye's
// perspective, for planes that are seen.
void FrameRenderer::State::drawMaps(Frame& frame) {
    const bool perspective = frame.shadows.method == ShadowMethod::Perspective;
    if (perspective)
        frame.cascades.cascades.clear();
    if (!frame.cascades.cascades.empty() && fitsTightly(frame.shadows, frame.request))
        frame.cascades = tightened(frame);
    last.drawn.clear();
    if (!frame.cascades.cascades.empty())
        last.drawn = cascadePass.draw(frame.cascades, frame.shadows, frame.items, timer);
    last.towardsSun = glm::transpose(meshAxes()) * frame.request.sun.towards.xyz;
    last.projective.clear();
    if (perspective || frame.shadows.method == ShadowMethod::PlaneOptimal)
        last.projective = projectiveMaps(frame);
    if (!last.projective.empty())
        for (DrawnCasters& drawn :
             projectivePass.draw({last.projective, frame.request.camera, last.surfaceCamera,
                                  meshAxes(), last.towardsSun},
                                 frame.shadows, frame.items, timer))
            last.drawn.push_back(std::move(drawn));
}

// The casters' tiles were chosen for the looser cascades, which hold these.
CascadeSet FrameRenderer::State::tightened(Frame& frame) {
    const Transform<Light, Light> turn =
        turnedTowards(last.surfaceCamera, frame.input.lightFromEcef);
    frame.input.lightFromEcef = turn * frame.input.lightFromEcef;
    frame.casters.lightFromAnchor = turn * frame.casters.lightFromAnchor;
    const auto seenIn = [&](const std::vector<float>& viewDepth) {
        return seenReceivers(last.surfaceCamera, viewDepth, frame.input.lightFromEcef,
                             frame.casters.lightFromAnchor, frame.input.farMetres);
    };
    SeenReceivers seen = seenIn(visibilityPass.readViewDepth());
    if (waterPass.any())
        add(seen, seenIn(waterPass.readViewDepth()));
    CascadeSet set = fitTightCascades(frame.input, frame.shadows, seen, frame.casters);
    for (Cascade& cascade : set.cascades)
        setDepthRange(cascade, set.mapSize, frame.casters);
    return set;
}

// For the planes most seen, or one for all.
std::vector<ProjectiveMap> FrameRenderer::State::projectiveMaps(const Frame& frame) {
    const Camera& camera = frame.input.camera;
    const double range = frame.cascades.rangeMetres;
    const glm::dvec4 reach =
        casterReach(frame.casters, frame.cascades.lightFromEcef, meshAxes(), camera.position);
    if (frame.shadows.method == ShadowMethod::Perspective) {
        const auto map =
            perspectiveMap({camera, meshAxes(), last.towardsSun, frame.input.nearMetres, range,
                            reach, frame.shadows.mapSize});
        return map ? std::vector{*map} : std::vector<ProjectiveMap>();
    }
    const NearestSurfaces seen = nearestSurfaces();
    return planeOptimalMaps({{last.surfaceCamera, meshAxes(), seen.viewDepth, seen.normals},
                             camera,
                             last.towardsSun,
                             reach,
                             range},
                            frame.shadows);
}

void FrameRenderer::State::drawLight(Frame& frame) {
    SunPassInput input{last.surfaceCamera,
                       frame.request.camera,
                       frame.request.sun.towards,
                       nullptr,
                       nullptr,
                       frame.casters,
                       meshAxes()};
    if (frame.shadows.method != ShadowMethod::Off)
        input.cascades = &frame.cascades;
    if (!frame.cascades.cascades.empty())
        input.maps = &cascadePass;
    if (!last.projective.empty())
        input.projective = &projectivePass;
    input.rough = std::any_of(scene.layers.begin(), scene.layers.end(),
                              [](const Layer& layer) { return layer.terrain != nullptr; });
    sunPass.draw(visibilityPass, input, frame.shadows, sun);
    timer.mark();
    if (waterPass.any())
        sunPass.draw(waterPass, input, frame.shadows, waterSun);
    timer.mark();
    if (lamps.live() > 0)
        lamps.draw(visibilityPass, last.surfaceCamera, lampCasters(frame));
    timer.mark();
}

void FrameRenderer::State::drawPicture(const Frame& frame) {
    render::CompositeInput input{visibilityPass, sun.visibility(),
                                 daylight(frame.request.sun, last.surfaceCamera, meshAxes())};
    input.lampLight = lamps.light();
    if (waterPass.any()) {
        input.water = &waterPass;
        input.waterSunVisibility = &waterSun.visibility();
        input.waterLook = waterLook(last.surfaceCamera, scene.ecefFromAnchor);
    }
    compositePass.draw(input);
    timer.mark();
}

void FrameRenderer::State::noteTiles(Frame& frame) const {
    FrameFacts& facts = frame.facts;
    facts.screenSpaceError = frame.screenSpaceError;
    for (std::size_t i = 0; i < frame.selections.size(); ++i) {
        const Selection& selection = frame.selections[i];
        const StreamedTileset& tileset = *scene.layers[i].tileset;
        facts.tilesSelected += std::uint32_t(selection.draw.size());
        facts.tilesLoaded += tileset.tilesLoaded();
        facts.decodedBytes += tileset.decodedBytes();
        for (const TileIndex tile : selection.failed)
            facts.missing.push_back(tileset.tree().name(tile));
        for (const LoadRequest& request : selection.load) {
            facts.missing.push_back(tileset.tree().name(request.tile));
            facts.late.push_back(facts.missing.back());
            const Error* fault = tileset.lastFault(request.tile);
            facts.lateReasons.push_back(fault ? fault->reason : "");
        }
        facts.mostTileBytes = tileset.ledger().most();
    }
    facts.gpuBytes = cache.gpuBytes() + (ground ? ground->bytes() : 0) + waters.bytes();
}

// The timer's marks stand after the visibility pass, the water, each map, the sun, the sun on the
// water, the lamps and the composite pass.
void FrameRenderer::State::noteCost(Frame& frame) {
    FrameFacts& facts = frame.facts;
    const std::vector<Cascade>& cascades = frame.cascades.cascades;
    facts.draws = visibilityPass.draws();
    const std::vector<double> times = timer.milliseconds();
    facts.visibilityMs = times.front();
    // The second mark of a cascade, where it has two, stands after its resolve.
    const auto perMap = std::size_t(CascadePass::marksPerMap(options.shadows));
    std::size_t at = 2;
    for (std::size_t i = 0; i < cascades.size(); ++i, at += perMap) {
        facts.depthMs.push_back(times[at]);
        facts.resolveMs += perMap == 2 ? times[at + 1] : 0.0;
    }
    for (; at + 4 < times.size(); ++at)
        facts.depthMs.push_back(times[at]);
    facts.sunMs = times[times.size() - 4];
    facts.waterMs = times[1] + times[times.size() - 3];
    facts.lampMs = times[times.size() - 2];
    facts.lamps = std::uint32_t(lamps.live());
    facts.lampMapsDrawn = std::uint32_t(lamps.mapsDrawn());
    facts.compositeMs = times.back();
    for (const double ms : times)
        facts.gpuTotalMs += ms;
    facts.shadowBytes = (cascades.empty() ? 0 : cascadePass.bytes()) +
                        (last.projective.empty() ? 0 : projectivePass.bytes()) + lamps.bytes();
    facts.shadowRangeMetres = frame.cascades.rangeMetres;
    facts.shadowFadeMetres = frame.cascades.fadeMetres;
    for (std::size_t i = 0; i < cascades.size(); ++i)
        facts.cascades.push_back(
            {cascades[i].nearMetres, cascades[i].farMetres, cascades[i].texelMetres,
             std::uint32_t(std::count(last.drawn[i].begin(), last.drawn[i].end(), true))});
}

FrameFacts FrameRenderer::State::keep(Frame frame) {
    last.camera = frame.request.camera;
    last.cascades = std::move(frame.cascades);
    last.items = std::move(frame.items);
    last.selections = std::move(frame.selections);
    frame.facts.complete = frame.facts.complete && !cache.leftOut();
    return std::move(frame.facts);
}

std::vector<LampCaster> FrameRenderer::State::lampCasters(const Frame& frame) const {
    std::map<std::uint32_t, std::shared_ptr<const TileContent>> contents;
    for (ResidentTile& tile : residentTiles(frame.selections))
        contents.emplace(tile.id, std::move(tile.content));
    std::vector<LampCaster> casters;
    for (const render::DrawItem& item : frame.items)
        if (const auto at = contents.find(item.tileId); at != contents.end())
            casters.push_back(
                {at->second, std::uint32_t(item.mesh - item.tile->meshes().data()), item.tile});
    return casters;
}

Failure FrameRenderer::State::chooseGround() {
    groundHeight = options.groundHeightMetres;
    if (options.groundAuto && !groundHeight) {
        const Clock::time_point deadline =
            Clock::now() + std::chrono::duration_cast<Clock::duration>(options.groundPatience);
        const auto found = findGroundHeight(scene, deadline, options.groundMustBeKnown);
        if (!found)
            return found.error();
        groundHeight = *found;
    }
    ground.reset();
    if (!groundHeight)
        return {};
    groundContent = std::make_shared<TileContent>(makeGround(scene, *groundHeight));
    std::vector<std::string> warnings;
    ground = std::make_unique<render::GpuTile>(*groundContent, warnings);
    return {};
}

FrameRenderer::FrameRenderer(std::unique_ptr<State> state) : state_(std::move(state)) {}
FrameRenderer::~FrameRenderer() = default;

Result<std::unique_ptr<FrameRenderer>> FrameRenderer::create(render::Context& context, Scene& scene,
                                                             const FrameOptions& options) {
    std::unique_ptr<FrameRenderer> renderer(
        new FrameRenderer(std::make_unique<State>(context, scene, options)));
    if (Failure unknown = renderer->state_->chooseGround())
        return *unknown;
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

glm::dmat3 FrameRenderer::meshAxes() const {
    return state_->meshAxes();
}

void FrameRenderer::present(int windowWidth, int windowHeight) {
    state_->compositePass.present(windowWidth, windowHeight);
}

} // namespace gnomon
