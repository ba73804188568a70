#include "viewer/open_tileset.h"

#include "viewer/crs_frame.h"
#include "viewer/scene_placement.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

namespace gnomon {

namespace {

// Enough to know where the ground is and which way is up; the same tiles are drawn later anyway.
constexpr std::size_t kContentsLookedAt = 4;
// A vertex in twenty may lie below the base: cellars, moats, stray points.
constexpr double kBelowBase = 0.05;

std::string inWords(const glm::dvec3& p) {
    char text[96];
    std::snprintf(text, sizeof text, "%.6g, %.6g, %.6g", p.x, p.y, p.z);
    return text;
}

Result<TilePlacement> frameFromCrs(const LayerFacts& facts, const Sphere& local) {
    Result<CrsToEcef> crs =
        CrsToEcef::create(*facts.crs, facts.heights.value_or(Heights::Ellipsoidal));
    if (!crs)
        return Error{"--crs", crs.error().message(), ErrorKind::Usage};
    TilePlacement placement;
    placement.curved = crsFrame(std::move(*crs), facts.raiseMetres.value_or(0.0));
    const auto frame = placement.curved->near(local.centre.xyz);
    if (!frame)
        return frame.error();
    placement.frame = *frame;
    return placement;
}

// What to say to somebody whose coordinates are not the Earth's.
std::string inWhatSystem(const glm::dvec3& centre) {
    std::string text;
    for (const std::string& system : likelySystems(glm::dvec2(centre)))
        text += (text.empty() ? "; coordinates like these are found in " : ", ") + system;
    return text;
}

Result<Transform<Ecef, Tile>> frameFromPlace(const Input& input, const LayerFacts& facts,
                                             StreamedTileset& local, Opening& opening) {
    const ModelUp said = facts.up.value_or(ModelUp::Auto);
    FrameUp up = said == ModelUp::Y ? FrameUp::Y : FrameUp::Z;
    if (input.kind == InputKind::Model) {
        // glTF says y is up, and decoding has turned that to z.
        up = said == ModelUp::Z ? FrameUp::MinusY : FrameUp::Z;
    } else if (said == ModelUp::Auto) {
        const auto contents = firstContents(local, 1, opening.deadline);
        if (!contents)
            return contents.error();
        if (upFromGeometry(*contents) == ModelUp::Y) {
            up = FrameUp::Y;
            opening.note(input.uri, "up axis y found from its geometry; --up z overrides");
        }
    }
    const Sphere bounds = boundingSphere(local.tree().node(TileTree::root()).volume);
    const double fromOrigin = glm::length(bounds.centre.xyz);
    constexpr double kFar = 10.0; // times its own size: hardly meant
    if (fromOrigin > kFar * 2.0 * bounds.radiusMetres)
        opening.warn(input.uri, "it lies " + std::to_string(std::llround(fromOrigin)) +
                                    " m from its own origin, which is what --place puts at the "
                                    "place given; perhaps it needs --crs");
    return placedFrame(*facts.placement, facts.raiseMetres.value_or(0.0), up);
}

Result<TilePlacement> frameFor(const Input& input, const LayerFacts& facts, StreamedTileset& local,
                               Opening& opening) {
    if (facts.placement) {
        const auto frame = frameFromPlace(input, facts, local, opening);
        return frame ? Result<TilePlacement>(TilePlacement(*frame)) : frame.error();
    }
    const Sphere bounds = boundingSphere(local.tree().node(TileTree::root()).volume);
    if (facts.crs)
        return frameFromCrs(facts, bounds);
    return Error{input.uri, "not on the Earth: it has a frame of its own (centred at " +
                                inWords(bounds.centre.xyz) +
                                "); say where it is with --place LON,LAT,H or --crs EPSG:n" +
                                inWhatSystem(bounds.centre.xyz)};
}

// Heights above the ellipsoid near `centre`, to second order: about a millimetre per kilometre off,
// and the same for a place moved rigidly over the Earth, which exact heights are not.
class HeightsNear {
  public:
    explicit HeightsNear(Point<Ecef> centre)
        : centre_(centre), up_(ellipsoidNormal(centre)), height_(geodeticOf(centre).heightMetres) {}
    double operator()(Point<Ecef> p) const {
        constexpr double kMeanRadiusMetres = 6371000.0;
        const Vector<Ecef> d = p - centre_;
        const double above = dot(d, up_);
        return height_ + above + (dot(d, d) - above * above) / (2.0 * kMeanRadiusMetres);
    }

  private:
    Point<Ecef> centre_;
    Vector<Ecef> up_;
    double height_;
};

} // namespace

Result<std::optional<HeightRange>> heightsOf(StreamedTileset& tileset, Point<Ecef> centre,
                                             const Opening& opening) {
    const HeightsNear heightOf(centre);
    std::vector<double> heights;
    const auto contents = firstContents(tileset, kContentsLookedAt, opening.deadline);
    if (!contents)
        return contents.error();
    for (const auto& content : *contents)
        for (const Mesh& mesh : content->meshes)
            for (const glm::vec3& p : mesh.positions)
                heights.push_back(heightOf({mesh.origin.xyz + glm::dvec3(p)}));
    if (heights.empty())
        return std::optional<HeightRange>();
    std::sort(heights.begin(), heights.end());
    return std::optional(
        HeightRange{heights[std::size_t(kBelowBase * double(heights.size()))], heights.back()});
}

Result<OpenedLayer> openTileset(const Input& input, const std::shared_ptr<const Source>& source,
                                const std::string& path, const LayerFacts& facts,
                                Opening& opening) {
    auto tileset = StreamedTileset::open(source, path, Transform<Ecef, Tile>{}, opening.loader);
    if (!tileset)
        return tileset.error();
    OpenedLayer opened;
    opened.layer.uri = input.uri;
    opened.layer.kind = nameOf(input.kind);
    if (!standsOnEarth((*tileset)->tree().node(TileTree::root()).volume)) {
        const auto frame = frameFor(input, facts, **tileset, opening);
        if (!frame && opening.unplaced) {
            opening.warn(input.uri, frame.error().reason);
            opened.layer.onEarth = false;
            opened.layer.tileset = std::move(*tileset);
            return opened;
        }
        if (!frame)
            return frame.error();
        tileset = StreamedTileset::open(source, path, *frame, opening.loader);
        if (!tileset)
            return tileset.error();
        if (!standsOnEarth((*tileset)->tree().node(TileTree::root()).volume))
            return Error{input.uri, "what was said about its place puts it off the Earth's "
                                    "surface; check --place or --crs"};
        opened.layer.placedByUser = true;
    } else if (!opening.several && (facts.placement || facts.crs || facts.raiseMetres)) {
        opening.warn(input.uri, "it has its own place on the Earth; --place, --crs and --raise "
                                "are not applied to it");
    }
    opened.layer.tileset = std::move(*tileset);
    opened.bounds = boundingSphere(opened.layer.tileset->tree().node(TileTree::root()).volume);
    opened.origin = uprightOrigin(opened.layer.tileset->tree().ecefFromTile(TileTree::root()));
    if (opened.layer.placedByUser && facts.placement) {
        opened.origin = facts.placement->origin;
        opened.origin->heightMetres += facts.raiseMetres.value_or(0.0);
    }
    if (!opening.unplaced) { // else nobody asks for the scene's anchor
        const auto heights = heightsOf(*opened.layer.tileset, opened.bounds.centre, opening);
        if (!heights)
            return heights.error();
        opened.heights = *heights;
    }
    return opened;
}

} // namespace gnomon
