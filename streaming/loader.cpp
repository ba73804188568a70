#include "streaming/loader.h"

#include "streaming/loader_state.h"

#include <algorithm>

namespace gnomon {

using Clock = std::chrono::steady_clock;

namespace {

OrientedBox boxAroundMeshes(const TileContent& content, const Transform<Ecef, Tile>& placement) {
    std::vector<Point<Ecef>> points;
    for (const Mesh& mesh : content.meshes)
        for (const Point<Ecef>& corner : corners(mesh.box))
            points.push_back(corner);
    if (points.empty())
        return {placement.origin(), glm::dmat3(0.0)};
    const glm::dvec3 x = glm::normalize(placement.axes()[0]);
    const glm::dvec3 z = glm::normalize(glm::cross(x, placement.axes()[1]));
    return boxAround(points, glm::dmat3(x, glm::cross(z, x), z));
}

} // namespace

StreamedTileset::StreamedTileset(std::unique_ptr<State> state) : state_(std::move(state)) {}
StreamedTileset::~StreamedTileset() = default;

Result<std::unique_ptr<StreamedTileset>> StreamedTileset::open(std::shared_ptr<const Source> source,
                                                               const std::string& path,
                                                               const TilePlacement& placement,
                                                               const LoaderOptions& options) {
    // As an unknown content below nothing: its own bytes say what it is.
    LoadJob job{TileTree::root(), ContentKind::Unknown, path, {}, {}, 1, {}};
    job.inherited.ecefFromTile = placement.frame;
    job.inherited.curved = placement.curved;
    const std::string lower = path.substr(path.size() - std::min<std::size_t>(5, path.size()));
    if (lower == ".json" || lower == ".JSON")
        job.kind = ContentKind::ExternalTileset;
    LoadResult result = runLoadJob(source, job);
    if (auto* error = std::get_if<Error>(&result.value))
        return std::move(*error);
    if (auto* tree = std::get_if<std::unique_ptr<TileTree>>(&result.value))
        return std::unique_ptr<StreamedTileset>(new StreamedTileset(
            std::make_unique<State>(std::move(source), path, std::move(**tree), options)));
    const auto& content = std::get<std::shared_ptr<const TileContent>>(result.value);
    TileTree tree =
        TileTree::ofModel(path, boxAroundMeshes(*content, placement.frame), placement.frame);
    auto state = std::make_unique<State>(std::move(source), path, std::move(tree), options);
    result.decodedBytes = content->bytes();
    // Without room it is read again when it is asked for.
    if (auto hold = state->ledger->take(MemoryLedger::Use::Decoding, result.decodedBytes)) {
        result.hold = std::move(*hold);
        state->keep(std::move(result), true);
    }
    return std::unique_ptr<StreamedTileset>(new StreamedTileset(std::move(state)));
}

Result<std::unique_ptr<StreamedTileset>> StreamedTileset::ofMade(const MadeTileset& made,
                                                                 const std::string& name,
                                                                 const LoaderOptions& options) {
    Result<TileTree> tree = TileTree::ofTiles(name, made.tiles);
    if (!tree)
        return tree.error();
    return std::unique_ptr<StreamedTileset>(
        new StreamedTileset(std::make_unique<State>(made.maker, name, std::move(*tree), options)));
}

const TileTree& StreamedTileset::tree() const {
    return state_->tree;
}
const std::string& StreamedTileset::path() const {
    return state_->path;
}
void StreamedTileset::request(std::span<const LoadRequest> wanted) {
    state_->request(wanted);
}
void StreamedTileset::requestAhead(std::span<const Selection> coming) {
    state_->requestAhead(coming);
}
bool StreamedTileset::idle() const {
    return state_->idle();
}
void StreamedTileset::rest() {
    state_->ahead.clear();
    state_->aheadGrowth.clear();
    state_->request({});
    state_->integrate(Apply::InRounds);
}
bool StreamedTileset::foundNoRoom() const {
    return state_->noRoom;
}
void StreamedTileset::setMeshAxes(const glm::dmat3& axes) {
    state_->meshAxes = axes;
    state_->dropAll();
}
void StreamedTileset::setResidence(const Residence& residence) {
    if (residence == state_->residence)
        return;
    state_->residence = residence;
    state_->queue.setGpuBytes(residence.gpuBytes);
    state_->dropAll();
}
void StreamedTileset::copied(TileIndex tile) {
    state_->copied(tile);
}
std::size_t StreamedTileset::onDrop(std::function<void(TileIndex)> dropped) {
    auto& listeners = state_->dropListeners;
    const std::size_t number = listeners.empty() ? 0 : listeners.rbegin()->first + 1;
    listeners.emplace(number, std::move(dropped));
    return number;
}
void StreamedTileset::stopOnDrop(std::size_t number) {
    state_->dropListeners.erase(number);
}
void StreamedTileset::use(std::span<const TileIndex> tiles) {
    state_->use(tiles);
}
void StreamedTileset::release(TileIndex tile) {
    state_->drop(tile);
}
MemoryLedger& StreamedTileset::ledger() const {
    return *state_->ledger;
}
std::size_t StreamedTileset::decodedBytes() const {
    return state_->decodedBytes;
}
std::size_t StreamedTileset::gpuBytes() const {
    return state_->gpuBytes;
}
std::uint64_t StreamedTileset::tilesLoaded() const {
    return state_->tilesLoaded;
}
const std::vector<FailedTile>& StreamedTileset::failures() const {
    return state_->failures;
}

const Error* StreamedTileset::lastFault(TileIndex tile) const {
    const auto at = state_->attempts.find(tile);
    return at == state_->attempts.end() ? nullptr : &at->second.fault;
}

std::shared_ptr<const TileContent> StreamedTileset::content(TileIndex tile) const {
    const auto it = state_->kept.find(tile);
    return it == state_->kept.end() ? nullptr : it->second.content;
}

StreamedTileset::Need StreamedTileset::needOf(std::span<const TileIndex> tiles) const {
    const bool onlyCopy = state_->residence.gpuBytes && !state_->residence.keepsDecoded;
    Need need;
    for (const TileIndex tile : tiles)
        if (const auto size = state_->sizes.find(tile); size != state_->sizes.end()) {
            need.bytes += size->second.gpu + (onlyCopy ? 0 : size->second.decoded);
            if (onlyCopy)
                need.largestDecoded = std::max(need.largestDecoded, size->second.decoded);
        }
    return need;
}

std::size_t StreamedTileset::poll() {
    const std::size_t changed = state_->integrate(Apply::AtOnce).changed;
    state_->makeWay();
    return changed;
}

bool StreamedTileset::wait(std::chrono::milliseconds timeout) {
    const Clock::time_point until = Clock::now() + timeout;
    for (;;) {
        const std::uint64_t news = state_->ledger->news();
        if (!state_->parkedGrowth.empty() || !state_->parkedFailures.empty() ||
            state_->queue.hasResults())
            return true;
        if (state_->queue.outstanding() == 0)
            return false;
        if (Clock::now() >= until)
            return true;
        state_->makeWay();
        state_->ledger->waitForNews(news, until);
    }
}

void StreamedTileset::waitForAll() {
    constexpr std::chrono::hours kLong{1};
    for (;;) {
        const std::uint64_t news = state_->ledger->news();
        if (state_->queue.quiet())
            return;
        state_->makeWay();
        state_->ledger->waitForNews(news, Clock::now() + kLong);
    }
}

} // namespace gnomon
