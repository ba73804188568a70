#include "streaming/terrain/terrain_texture.h"

#include "streaming/color_map.h"

#include <cmath>

namespace gnomon {

namespace {

constexpr int kRampTexels = 256;

std::uint8_t byteOf(float share) {
    return std::uint8_t(std::lround(std::clamp(share, 0.0f, 1.0f) * 255.0f));
}

void setTexel(std::uint8_t* texel, const glm::vec3& color) {
    texel[0] = byteOf(color.r);
    texel[1] = byteOf(color.g);
    texel[2] = byteOf(color.b);
    texel[3] = 255;
}

// Along one side: for each texel the vertex before it and how far it is on the way to the next.
struct Along {
    std::vector<int> vertex;
    std::vector<double> share;

    // `lines`: of the tile's vertices, the ring left out. Texels lie evenly in pixels.
    Along(const std::vector<double>& lines, int before, int cells, int texels) {
        const auto line = [&](int i) { return lines[std::size_t(i + before)]; };
        int at = 0;
        for (int t = 0; t < texels; ++t) {
            const double pixel =
                line(0) + (line(cells) - line(0)) * (double(t) / std::max(texels - 1, 1));
            while (at + 1 < cells && pixel > line(at + 1))
                ++at;
            vertex.push_back(at);
            share.push_back(std::clamp((pixel - line(at)) / (line(at + 1) - line(at)), 0.0, 1.0));
        }
    }
};

// A texel's own colour where no drape is: by height, or plain.
glm::vec3 groundColor(const TerrainScene& scene, const TerrainPatch& patch, int column, int row,
                      double u, double v) {
    const TerrainData& data = *scene.data;
    if (data.look == TerrainLook::Plain)
        return kTerrainColor;
    double sum = 0.0, weight = 0.0;
    for (int j = 0; j < 2; ++j)
        for (int i = 0; i < 2; ++i) {
            const float h = patch.heights[patch.index(column + i, row + j)];
            const double w = (i ? u : 1.0 - u) * (j ? v : 1.0 - v);
            if (!std::isnan(h) && w > 0.0) {
                sum += w * double(h);
                weight += w;
            }
        }
    const double range = std::max(data.highest - data.lowest, 1e-9);
    return colorAt(ColorMap::Elevation, weight > 0.0 ? (sum / weight - data.lowest) / range : 0.0);
}

} // namespace

Image rampImage() {
    Image image;
    image.width = kRampTexels;
    image.height = 1;
    image.rgba.resize(std::size_t(kRampTexels) * 4);
    for (int i = 0; i < kRampTexels; ++i)
        setTexel(&image.rgba[std::size_t(i) * 4],
                 colorAt(ColorMap::Elevation, double(i) / (kRampTexels - 1)));
    return image;
}

float texelShare(double share, int texels) {
    return float((0.5 + share * (texels - 1)) / texels);
}

Result<Image> paintTile(const TerrainScene& scene, const TileName& name, const TerrainPatch& patch,
                        glm::ivec2 texels) {
    Image image;
    image.width = texels.x;
    image.height = texels.y;
    image.rgba.assign(std::size_t(texels.x) * std::size_t(texels.y) * 4, 0);
    const Along across(patch.columns, patch.before.x, patch.cells.x, texels.x);
    const Along down(patch.rows, patch.before.y, patch.cells.y, texels.y);
    // Places between vertices are linear between theirs: the texture lies on the mesh.
    std::vector<glm::dvec2> lonLat;
    lonLat.reserve(std::size_t(texels.x) * std::size_t(texels.y));
    std::vector<PlacedPixel> lineAbove, lineBelow;
    for (int y = 0; y < texels.y; ++y) {
        const int row = down.vertex[std::size_t(y)];
        const double v = down.share[std::size_t(y)];
        for (int x = 0; x < texels.x; ++x) {
            const int column = across.vertex[std::size_t(x)];
            const double u = across.share[std::size_t(x)];
            const auto up = [&](int i, int j) -> const glm::dvec3& {
                return patch.places[patch.index(column + i, row + j)].up;
            };
            const PlacedPixel place{(1 - v) * ((1 - u) * up(0, 0) + u * up(1, 0)) +
                                        v * ((1 - u) * up(0, 1) + u * up(1, 1)),
                                    0.0};
            lonLat.push_back(place.lonLat());
        }
    }
    const GeographicBox box = scene.boxOf(name.level, name.tile);
    for (const auto& drape : scene.drapes)
        if (overlap(box, drape->extent()))
            if (const Failure wrong = drape->paint(lonLat, texels.x, image.rgba))
                return *wrong;
    std::size_t at = 0;
    for (int y = 0; y < texels.y; ++y)
        for (int x = 0; x < texels.x; ++x, at += 4)
            if (image.rgba[at + 3] == 0)
                setTexel(&image.rgba[at],
                         groundColor(scene, patch, across.vertex[std::size_t(x)],
                                     down.vertex[std::size_t(y)], across.share[std::size_t(x)],
                                     down.share[std::size_t(y)]));
    return image;
}

} // namespace gnomon
