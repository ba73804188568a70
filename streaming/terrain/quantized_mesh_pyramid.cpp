#include "streaming/terrain/quantized_mesh_pyramid.h"

#include "streaming/terrain/gzip.h"

#include <algorithm>
#include <filesystem>

namespace gnomon {

namespace {

namespace fs = std::filesystem;

constexpr unsigned kMostParents = 8;
constexpr std::size_t kMostRecentBytes = std::size_t(16) << 20, kMostRecent = 256;
constexpr std::size_t kMostRoots = 20000;
// Of the finest level, to say which are missing.
constexpr std::uint64_t kMostChecked = 20000;

bool holds(const TileRanges& ranges, std::uint32_t x, std::uint32_t y) {
    return std::any_of(ranges.begin(), ranges.end(), [&](const TileRange& r) {
        return x >= r.startX && x <= r.endX && y >= r.startY && y <= r.endY;
    });
}

// Every tile of a level that is in its ranges, at most `most` of them.
template <class Take>
void eachOf(const TileRanges& ranges, unsigned level, bool webMercator, std::uint64_t most,
            const Take& take) {
    const std::uint64_t columns = columnsOf(level, webMercator), rows = rowsOf(level);
    for (const TileRange& r : ranges)
        for (std::uint64_t y = r.startY; y <= r.endY && y < rows; ++y)
            for (std::uint64_t x = r.startX; x <= r.endX && x < columns; ++x) {
                if (most-- == 0)
                    return;
                take(QuantizedPlace{level, std::uint32_t(x), std::uint32_t(y)});
            }
}

bool looksLikeJson(std::span<const std::byte> bytes) {
    for (const std::byte b : bytes.first(std::min<std::size_t>(bytes.size(), 64)))
        if (b == std::byte('{'))
            return true;
        else if (b != std::byte(' ') && b != std::byte('\n') && b != std::byte('\r') &&
                 b != std::byte('\t') && b < std::byte(0x80))
            return false;
    return false;
}

} // namespace

std::shared_ptr<const Bytes> RecentBytes::find(const std::string& path) const {
    const std::lock_guard lock(mutex_);
    for (const auto& [kept, bytes] : kept_)
        if (kept == path)
            return bytes;
    return nullptr;
}

void RecentBytes::add(const std::string& path, std::shared_ptr<const Bytes> bytes) {
    const std::lock_guard lock(mutex_);
    bytes_ += bytes->size();
    kept_.emplace_back(path, std::move(bytes));
    while (bytes_ > kMostRecentBytes || kept_.size() > kMostRecent) {
        bytes_ -= kept_.front().second->size();
        kept_.pop_front();
    }
}

Result<std::shared_ptr<const Bytes>> QuantizedPyramid::bytesOf(const std::string& path) const {
    if (!folder_)
        if (auto recent = recent_.find(path))
            return recent;
    Result<Bytes> bytes = source_->read(path);
    if (!bytes)
        return bytes.error();
    auto kept = std::make_shared<const Bytes>(std::move(*bytes));
    if (!folder_)
        recent_.add(path, kept);
    return kept;
}

Result<std::unique_ptr<const QuantizedPyramid>> QuantizedPyramid::open(const std::string& path) {
    std::unique_ptr<QuantizedPyramid> pyramid(new QuantizedPyramid);
    std::error_code error;
    fs::path file = path;
    if (fs::is_directory(file, error))
        file /= "layer.json";
    pyramid->folder_ = file.parent_path().string();
    pyramid->source_ = fileSource(*pyramid->folder_);
    return openAll(std::move(pyramid), file.filename().string(), path);
}

Result<std::unique_ptr<const QuantizedPyramid>>
QuantizedPyramid::open(std::shared_ptr<const Source> source, const std::string& path) {
    std::unique_ptr<QuantizedPyramid> pyramid(new QuantizedPyramid);
    pyramid->source_ = std::move(source);
    const std::string shown = pyramid->source_->describe(path);
    return openAll(std::move(pyramid), path, shown);
}

Result<std::unique_ptr<const QuantizedPyramid>>
QuantizedPyramid::openAll(std::unique_ptr<QuantizedPyramid> pyramid, const std::string& name,
                          const std::string& shown) {
    const Result<Bytes> bytes = pyramid->source_->read(name);
    if (!bytes)
        return bytes.error();
    Failure wrong = looksLikeJson(*bytes) ? pyramid->addLayers(name) : pyramid->placeSingle(name);
    if (!wrong)
        wrong = pyramid->findRoots(shown);
    if (wrong)
        return *wrong;
    pyramid->findExtent();
    if (pyramid->folder_)
        pyramid->noteMissing();
    return std::unique_ptr<const QuantizedPyramid>(std::move(pyramid));
}

// The layer, the one it leans on, and so on.
Failure QuantizedPyramid::addLayers(const std::string& first) {
    for (std::string document = first; !document.empty();) {
        const auto known = std::find_if(layers_.begin(), layers_.end(), [&](const Layer& layer) {
            return layer.document == document;
        });
        const std::string name = source_->describe(document);
        if (known != layers_.end() || layers_.size() > kMostParents) {
            notes_.push_back(name + ": is its own parent, or one of too many; not looked at again");
            break;
        }
        const Result<Bytes> bytes = source_->read(document);
        Result<LayerJson> json =
            bytes ? parseLayerJson(*bytes, name) : Result<LayerJson>(bytes.error());
        if (json && !layers_.empty() && json->webMercator != webMercator_)
            json = Error{name, "is a parent of another projection"};
        if (!json) {
            if (layers_.empty())
                return json.error();
            notes_.push_back("its parent is left out: " + json.error().message());
            break;
        }
        webMercator_ = json->webMercator;
        for (const std::string& warning : json->warnings)
            notes_.push_back((layers_.empty() ? "" : name + ": ") + warning);
        if (!json->attribution.empty())
            credits_.push_back(json->attribution);
        layers_.push_back({document, std::move(*json)});
        const std::string parent = layers_.back().json.parentUrl;
        document.clear();
        if (parent.empty())
            break;
        const bool named = parent.ends_with(".json");
        const Result<std::string> next =
            resolveUri(layers_.back().document, named ? parent : parent + "/layer.json");
        if (next)
            document = *next;
        else
            notes_.push_back("its parent is left out: " + next.error().message());
    }
    return {};
}

Failure QuantizedPyramid::placeSingle(const std::string& name) {
    const std::string shown = source_->describe(name);
    const Result<Bytes> bytes = source_->read(name);
    if (!bytes)
        return bytes.error();
    const Result<QuantizedTile> tile = decodeQuantizedTile(*bytes, shown);
    if (!tile)
        return tile.error();
    std::error_code error;
    const fs::path whole = folder_ ? fs::absolute(shown, error) : fs::path(shown);
    const auto found = placeOf(*tile, error ? shown : whole.generic_string());
    if (!found)
        return Error{shown, "does not tell where it belongs: neither its path (z/x/y.terrain) nor "
                            "its bounding sphere fits a place in the tree"};
    single_ = found->place;
    singlePath_ = name;
    webMercator_ = found->webMercator;
    const QuantizedPlace& p = found->place;
    notes_.push_back("one tile by itself, taken for " + std::to_string(p.level) + "/" +
                     std::to_string(p.x) + "/" + std::to_string(p.y) + " of " +
                     (webMercator_ ? "EPSG:3857" : "EPSG:4326") +
                     (found->byPath ? " by its path" : " by its bounding sphere"));
    return {};
}

std::string QuantizedPyramid::pathOf(const Layer& layer, const QuantizedPlace& place) const {
    const Result<std::string> path =
        resolveUri(layer.document, layer.json.uriOf(place.level, place.x, place.y));
    return path ? *path : std::string();
}

bool QuantizedPyramid::isFile(const std::string& path) const {
    std::error_code error;
    return !path.empty() && fs::is_regular_file(fs::path(*folder_) / path, error);
}

bool QuantizedPyramid::isThere(const Layer& layer, const QuantizedPlace& place) const {
    const std::string path = pathOf(layer, place);
    if (folder_)
        return isFile(path);
    if (path.empty())
        return false;
    const bool told = layer.json.saysAvailable || layer.json.metadataLevels > 0;
    return told || bool(bytesOf(path));
}

bool QuantizedPyramid::claims(const Layer& layer, const QuantizedPlace& place) const {
    const LayerJson& json = layer.json;
    if (json.saysAvailable && place.level < json.available.size() &&
        holds(json.available[place.level], place.x, place.y))
        return true;
    if (json.metadataLevels == 0)
        return !json.saysAvailable;
    if (place.level == 0)
        return true;
    // The tile above that tells of this level.
    const unsigned teller = (place.level - 1) / json.metadataLevels * json.metadataLevels;
    const unsigned up = place.level - teller;
    const QuantizedPlace above{teller, place.x >> up, place.y >> up};
    if (layerOf(above) < 0)
        return false;
    const auto told = summary(above);
    return told && told->availableBelow && up - 1 < told->availableBelow->size() &&
           holds((*told->availableBelow)[up - 1], place.x, place.y);
}

int QuantizedPyramid::layerOf(const QuantizedPlace& place) const {
    if (single_)
        return place == *single_ ? 0 : -1;
    if (place.level > kDeepestLevel || place.x >= columnsOf(place.level, webMercator_) ||
        place.y >= rowsOf(place.level))
        return -1;
    {
        const std::lock_guard lock(mutex_);
        if (const auto it = known_.find(place); it != known_.end() && it->second.looked)
            return it->second.layer;
    }
    int found = -1;
    for (std::size_t i = 0; i < layers_.size() && found < 0; ++i)
        if (claims(layers_[i], place) && isThere(layers_[i], place))
            found = int(i);
    const std::lock_guard lock(mutex_);
    Known& known = known_[place];
    known.looked = true;
    known.layer = found;
    return found;
}

bool QuantizedPyramid::has(const QuantizedPlace& place) const {
    return layerOf(place) >= 0;
}

bool QuantizedPyramid::hasChild(const QuantizedPlace& place) const {
    for (unsigned i = 0; i < 4 && place.level < kDeepestLevel; ++i)
        if (has(place.child(i)))
            return true;
    return false;
}

std::optional<QuantizedPlace> QuantizedPyramid::sourceOf(QuantizedPlace place) const {
    while (!has(place)) {
        if (place.level == 0)
            return {};
        place = place.parent();
    }
    return place;
}

std::string QuantizedPyramid::describe(const QuantizedPlace& place) const {
    if (single_)
        return source_->describe(singlePath_);
    const int layer = layerOf(place);
    const std::string path = layer >= 0 ? pathOf(layers_[std::size_t(layer)], place) : "";
    return source_->describe(path.empty() ? layers_[0].document : path) +
           (path.empty() ? " (tile " + std::to_string(place.level) + "/" + std::to_string(place.x) +
                               "/" + std::to_string(place.y) + ")"
                         : "");
}

Result<QuantizedTile> QuantizedPyramid::read(const QuantizedPlace& place) const {
    const int layer = layerOf(place);
    if (layer < 0)
        return Error{describe(place), "there is no such tile"};
    const auto bytes = bytesOf(single_ ? singlePath_ : pathOf(layers_[std::size_t(layer)], place));
    if (!bytes)
        return bytes.error();
    return decodeQuantizedTile(**bytes, describe(place));
}

std::shared_ptr<const QuantizedSummary>
QuantizedPyramid::summary(const QuantizedPlace& place) const {
    {
        const std::lock_guard lock(mutex_);
        if (const auto it = known_.find(place); it != known_.end() && it->second.summary)
            return it->second.summary;
    }
    const int layer = layerOf(place);
    if (layer < 0)
        return nullptr;
    const auto bytes = bytesOf(single_ ? singlePath_ : pathOf(layers_[std::size_t(layer)], place));
    Result<QuantizedSummary> read = bytes ? readQuantizedSummary(**bytes, describe(place))
                                          : Result<QuantizedSummary>(bytes.error());
    if (!read)
        return nullptr;
    auto out = std::make_shared<const QuantizedSummary>(std::move(*read));
    const std::lock_guard lock(mutex_);
    known_[place].summary = out;
    return out;
}

// What is told of and cannot be looked for is asked for, until one is there.
Failure QuantizedPyramid::dropMissingRoots() {
    constexpr std::size_t kMostAsked = 64; // a server that has none of these has none
    for (std::size_t asked = 0; !roots_.empty(); ++asked) {
        const auto bytes =
            bytesOf(pathOf(layers_[std::size_t(layerOf(roots_.front()))], roots_.front()));
        if (bytes)
            return {};
        if (bytes.error().kind == ErrorKind::Transient)
            return bytes.error();
        roots_.erase(roots_.begin(), asked < kMostAsked ? roots_.begin() + 1 : roots_.end());
    }
    return {};
}

// The first level that has any tile.
Failure QuantizedPyramid::findRoots(const std::string& path) {
    if (single_) {
        roots_ = {*single_};
        return {};
    }
    const auto take = [&](const QuantizedPlace& place) {
        if (has(place) && std::find(roots_.begin(), roots_.end(), place) == roots_.end())
            roots_.push_back(place);
    };
    std::uint64_t told = 0;
    for (unsigned level = 0; level <= kDeepestLevel && roots_.empty(); ++level) {
        if (level == 0)
            eachOf({{0, 0, 1, 0}}, 0, webMercator_, 2, take);
        for (const Layer& layer : layers_)
            if (level < layer.json.available.size()) {
                for (const TileRange& r : layer.json.available[level])
                    told += (std::uint64_t(r.endX) - r.startX + 1) *
                            (std::uint64_t(r.endY) - r.startY + 1);
                eachOf(layer.json.available[level], level, webMercator_, kMostRoots, take);
            }
    }
    if (!folder_)
        if (Failure wrong = dropMissingRoots())
            return wrong;
    if (roots_.empty())
        return Error{path, told > 0 ? "tells of tiles, but none of the first of them is there"
                                    : "has no tile where its first should be (" +
                                          source_->describe(pathOf(layers_[0], {0, 0, 0})) + ")"};
    return {};
}

void QuantizedPyramid::findExtent() {
    TileRanges finest;
    for (const Layer& layer : layers_)
        for (std::size_t level = 0; level < layer.json.available.size(); ++level)
            if (!layer.json.available[level].empty() && level >= deepest_ &&
                level <= kDeepestLevel) {
                deepest_ = unsigned(level);
                finest = layer.json.available[level];
            }
    deepest_ = std::max(deepest_, roots_[0].level);
    bool any = false;
    const auto add = [&](const QuantizedPlace& place) {
        const std::array<double, 4> e = extentOf(place, webMercator_);
        extent_ =
            any ? std::array<double, 4>{std::min(extent_[0], e[0]), std::min(extent_[1], e[1]),
                                        std::max(extent_[2], e[2]), std::max(extent_[3], e[3])}
                : e;
        any = true;
    };
    const std::uint64_t columns = columnsOf(deepest_, webMercator_), rows = rowsOf(deepest_);
    for (const TileRange& r : finest) {
        if (r.startX >= columns || r.startY >= rows)
            continue;
        add({deepest_, r.startX, r.startY});
        add({deepest_, std::uint32_t(std::min<std::uint64_t>(r.endX, columns - 1)),
             std::uint32_t(std::min<std::uint64_t>(r.endY, rows - 1))});
    }
    if (!any)
        for (const QuantizedPlace& root : roots_)
            add(root);
}

// Tiles that are told of and not there are shown as their parents have them: said once.
void QuantizedPyramid::noteMissing() {
    std::uint64_t told = 0, missing = 0;
    std::string first;
    for (const Layer& layer : layers_)
        for (std::size_t level = 0; level < layer.json.available.size() && level <= kDeepestLevel;
             ++level)
            eachOf(layer.json.available[level], unsigned(level), webMercator_,
                   told < kMostChecked ? kMostChecked - told : 0, [&](const QuantizedPlace& place) {
                       ++told;
                       const std::string path = pathOf(layer, place);
                       if (isFile(path))
                           return;
                       first = missing++ == 0 ? path : first;
                   });
    if (missing > 0)
        notes_.push_back(std::to_string(missing) + " of the " +
                         (told == kMostChecked ? "first " : "") + std::to_string(told) +
                         " tiles it tells of are not there (first " + first +
                         "); their parents are shown instead");
    for (const Layer& layer : layers_)
        if (layer.json.uriOf(0, 0, 0).find("://") != std::string::npos)
            notes_.push_back("its tiles are on a network, which is not looked at");
}

} // namespace gnomon
