#include "streaming/terrain/quantized_mesh_scene.h"
#include "streaming/terrain/terrain_texture.h"

#include "streaming/color_map.h"

#include <algorithm>
#include <cmath>

namespace gnomon {

namespace {

glm::vec4 linear(const glm::vec3& color) {
    const auto one = [](float c) {
        return c <= 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f);
    };
    return {one(color.r), one(color.g), one(color.b), 1.0f};
}

class ContentOfTile {
  public:
    ContentOfTile(const QuantizedScene& scene, const QuantizedPlace& place,
                  const QuantizedPlace& source, QuantizedTile tile)
        : scene_(scene), core_(*scene.core), place_(place), source_(source), tile_(std::move(tile)),
          extent_(extentOf(place, core_.pyramid->webMercator())),
          sourceExtent_(extentOf(source, core_.pyramid->webMercator())),
          shift_(core_.heights, core_.raiseMetres) {}

    Result<TileContent> make(const DecodeOptions& options) {
        const std::string name = core_.pyramid->describe(source_);
        TileContent content;
        content.facts.format = "quantized-mesh";
        content.facts.extensions = tile_.extensions;
        content.facts.warnings = tile_.warnings;
        if (!cut())
            return Error{name, "cannot be cut: its triangles lie over each other"};
        if (const Failure wrong = shift_.prepare(sourceExtent_))
            return *wrong;
        if (core_.look != TerrainLook::Plain)
            own_ = part_.heights;
        for (std::size_t i = 0; i < part_.heights.size(); ++i)
            part_.heights[i] += shift_.at(part_.places[i]);
        makeRoom();
        TerrainSurface surface = surfaceOf(part_, sourceExtent_, content.facts.warnings);
        // Next to a tile of another level the ground lies as far off as both may err: a tile is
        // drawn beside one or two levels coarser.
        constexpr double kLevelsApart = 4.0;
        surface.skirtMetres = kLevelsApart * core_.errorOf(source_);
        if (const Failure wrong = setLook(content, surface))
            return *wrong;
        addMeshes(content, surface, options);
        return content;
    }

  private:
    bool cut() {
        const bool whole = place_ == source_;
        const int cells = scene_.isNearAbove(extent_) ? kRoomCells : 1;
        if (whole && cells == 1) {
            part_ = wholeOf(std::move(tile_));
            return true;
        }
        const auto share = [](double at, double low, double high) {
            return (at - low) / (high - low) * kQuantizedMost;
        };
        const QuantizedWindow window{share(extent_[0], sourceExtent_[0], sourceExtent_[2]),
                                     share(extent_[1], sourceExtent_[1], sourceExtent_[3]),
                                     share(extent_[2], sourceExtent_[0], sourceExtent_[2]),
                                     share(extent_[3], sourceExtent_[1], sourceExtent_[3])};
        std::optional<QuantizedPart> part = cutOut(tile_, window, cells);
        if (part)
            part_ = std::move(*part);
        return part.has_value();
    }

    // Triangles wholly under other ground are left out; those that reach under it bend to it.
    void makeRoom() {
        if (!scene_.isNearAbove(extent_))
            return;
        std::vector<glm::dvec2> lonLat;
        for (const glm::dvec2& place : part_.places)
            lonLat.push_back(lonLatOf(place, sourceExtent_));
        std::vector<char> covered(lonLat.size(), 0);
        std::vector<double> heights(lonLat.size());
        for (const auto& ground : scene_.above) {
            ground->sample(lonLat, heights);
            for (std::size_t i = 0; i < heights.size(); ++i)
                if (!covered[i] && !std::isnan(heights[i])) {
                    covered[i] = 1;
                    part_.heights[i] = heights[i];
                }
        }
        std::vector<std::uint32_t> left;
        for (std::size_t i = 0; i + 2 < part_.indices.size(); i += 3) {
            const std::uint32_t* t = &part_.indices[i];
            if (!(covered[t[0]] && covered[t[1]] && covered[t[2]]))
                left.insert(left.end(), t, t + 3);
        }
        part_.indices = std::move(left);
    }

    double rampShare(double height) const {
        return std::clamp((height - core_.lowest) / std::max(core_.highest - core_.lowest, 1e-9),
                          0.0, 1.0);
    }

    Failure setLook(TileContent& content, TerrainSurface& surface) {
        Material material;
        material.unlit = core_.look == TerrainLook::RampUnlit;
        material.wrapS = material.wrapT = Wrap::ClampToEdge;
        const PictureNeed need = pictureNeed(scene_.drapes, extent_, metresOf(extent_));
        if (!need.drapes.empty()) {
            Result<Image> image = paint(need, surface);
            if (!image)
                return image.error();
            for (const glm::vec2& p : surface.places)
                surface.uvs.push_back({texelShare(double(p.x), image->width),
                                       texelShare(double(p.y), image->height)});
            content.images.push_back(std::move(*image));
        } else if (core_.look != TerrainLook::Plain) {
            content.images.push_back(rampImage());
            for (const double h : own_)
                surface.uvs.push_back({texelShare(rampShare(h), content.images[0].width), 0.5f});
        } else {
            material.baseColor = linear(kTerrainColor);
        }
        material.image = content.images.empty() ? -1 : 0;
        content.materials.push_back(material);
        return {};
    }

    // Texel centres lie on the tile's sides, so that tiles side by side show the same there.
    Result<Image> paint(const PictureNeed& need, const TerrainSurface& surface) const {
        Image image;
        image.width = need.texels.x;
        image.height = need.texels.y;
        std::vector<glm::dvec2> lonLat;
        lonLat.reserve(std::size_t(image.width) * std::size_t(image.height));
        for (int j = 0; j < image.height; ++j)
            for (int i = 0; i < image.width; ++i)
                lonLat.push_back(
                    {std::lerp(extent_[0], extent_[2], double(i) / (image.width - 1)),
                     std::lerp(extent_[3], extent_[1], double(j) / (image.height - 1))});
        image.rgba = ground(lonLat, image.width, surface);
        for (const auto& drape : need.drapes)
            if (Failure wrong = drape->paint(lonLat, image.width, image.rgba))
                return *wrong;
        return image;
    }

    // Its own colour, where no drape is.
    std::vector<std::uint8_t> ground(const std::vector<glm::dvec2>& lonLat, int width,
                                     const TerrainSurface& surface) const {
        const auto byte = [](float c) {
            return std::uint8_t(std::lround(std::clamp(c, 0.0f, 1.0f) * 255.0f));
        };
        std::vector<std::uint8_t> rgba(4 * lonLat.size(), 255);
        const auto set = [&](std::size_t k, const glm::vec3& c) {
            rgba[4 * k] = byte(c.r);
            rgba[4 * k + 1] = byte(c.g);
            rgba[4 * k + 2] = byte(c.b);
        };
        if (core_.look == TerrainLook::Plain) {
            for (std::size_t k = 0; k < lonLat.size(); ++k)
                set(k, kTerrainColor);
            return rgba;
        }
        QuantizedPart bare;
        bare.places = part_.places;
        bare.heights = own_;
        bare.indices = surface.indices;
        const QuantizedHeights heights(std::move(bare), sourceExtent_);
        glm::vec3 last = colorAt(ColorMap::Elevation, 0.0);
        for (std::size_t k = 0; k < lonLat.size(); ++k) {
            // Every fourth is looked up: a ramp is smooth, and the drapes hide most of it.
            const std::size_t row = k / std::size_t(width), column = k % std::size_t(width);
            if (row % 4 != 0) {
                std::copy_n(&rgba[4 * (k - std::size_t(width))], 4, &rgba[4 * k]);
                continue;
            }
            if (column % 4 == 0)
                if (const double h = heights.at(lonLat[k]); !std::isnan(h))
                    last = colorAt(ColorMap::Elevation, rampShare(h));
            set(k, last);
        }
        return rgba;
    }

    const QuantizedScene& scene_;
    const QuantizedCore& core_;
    QuantizedPlace place_, source_;
    QuantizedTile tile_;
    std::array<double, 4> extent_, sourceExtent_;
    HeightShift shift_;
    QuantizedPart part_;
    std::vector<double> own_; // heights as the tile has them
};

} // namespace

Result<TileContent> makeQuantizedTile(const QuantizedScene& scene, const QuantizedPlace& place,
                                      const DecodeOptions& options) {
    const QuantizedPyramid& pyramid = *scene.core->pyramid;
    const std::optional<QuantizedPlace> source = pyramid.sourceOf(place);
    if (!source)
        return Error{pyramid.describe(place), "there is no such tile, nor one above it"};
    Result<QuantizedTile> tile = pyramid.read(*source);
    if (!tile)
        return tile.error();
    return ContentOfTile(scene, place, *source, std::move(*tile)).make(options);
}

} // namespace gnomon
