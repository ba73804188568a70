#include "viewer/place/picture.h"

#include <OpenImageIO/filesystem.h>
#include <OpenImageIO/imageio.h>

#include <algorithm>
#include <cmath>
#include <cstring>

namespace gnomon::builtin {
namespace {

glm::vec3 rgb(int r, int g, int b) {
    return {float(r), float(g), float(b)};
}

const glm::vec3 kLawn = rgb(132, 154, 92), kPark = rgb(118, 146, 82), kGravel = rgb(196, 186, 164),
                kYard = rgb(178, 172, 158), kAsphalt = rgb(116, 117, 121),
                kPavement = rgb(186, 182, 174), kKerb = rgb(150, 148, 144),
                kPaint = rgb(226, 226, 220), kWater = rgb(86, 124, 148), kDeep = rgb(66, 104, 134),
                kSand = rgb(190, 176, 142), kSquare = rgb(204, 192, 172), kWood = rgb(92, 112, 66);
const std::array kFields{rgb(192, 180, 116), rgb(146, 160, 94), rgb(128, 148, 84),
                         rgb(168, 150, 112), rgb(176, 174, 104)};

glm::vec3 blend(glm::vec3 a, glm::vec3 b, double t) {
    return a + (b - a) * float(t);
}

// What the ground looks like in one cell. Widths in metres.
class Painter {
  public:
    Painter(const Plan& plan, const Cell& cell)
        : plan_(plan), cell_(cell), nearRiver_(plan.riverDistance(cell.rect.centre()) <
                                               plan.riverHalfWidth() + 2 * kCellMetres) {}

    glm::vec3 color(glm::dvec2 p) const;

  private:
    glm::vec3 surface(glm::dvec2 p) const;
    glm::vec3 street(glm::dvec2 p, double fromBlock) const;
    glm::vec3 insideBlock(glm::dvec2 p, const Block& block) const;
    glm::vec3 country(glm::dvec2 p) const;
    glm::vec3 park(glm::dvec2 p) const;
    glm::vec3 square(glm::dvec2 p) const;
    double noise(glm::dvec2 p, double metres) const {
        return valueNoise(plan_.seed() + 60, p.x / metres, p.y / metres);
    }
    // A line of paint 15 cm wide, dashes of 3 m with gaps of 4 m. A pixel is 25 cm and the line
    // runs between two, so both get a third of its colour.
    static glm::vec3 centreLine(double across, double along) {
        const bool dash = along - 7 * std::floor(along / 7) < 3;
        return blend(kAsphalt, kPaint, dash && std::abs(across) < 0.15 ? 0.45 : 0.0);
    }

    const Plan& plan_;
    const Cell& cell_;
    bool nearRiver_; // elsewhere it need not be asked, which is most of the work
};

glm::vec3 Painter::country(glm::dvec2 p) const {
    const double wood = noise(p, 190);
    // Fields: strips of a cell, each of its own crop, with furrows.
    const double strip = 42 + 20 * unitOf(hash(plan_.seed(), std::int64_t(cell_.rect.west),
                                               std::int64_t(cell_.rect.south), 61));
    const bool along =
        hash(plan_.seed(), std::int64_t(cell_.rect.west), std::int64_t(cell_.rect.south), 62) & 1;
    const double across = (along ? p.x - cell_.rect.west : p.y - cell_.rect.south) / strip;
    const auto crop = hash(plan_.seed(), std::int64_t(cell_.rect.west) + int(across),
                           std::int64_t(cell_.rect.south), 63) %
                      kFields.size();
    glm::vec3 c = kFields[crop];
    c *= float(1 + 0.03 * std::sin(across * strip * 2.1));
    if (across - std::floor(across) < 0.03)
        c = kLawn;
    return blend(c, kWood,
                 smoothstep(0.58, 0.64, valueNoise(plan_.seed() + 50, p.x / 190, p.y / 190)) *
                     (0.7 + 0.3 * wood));
}

glm::vec3 Painter::park(glm::dvec2 p) const {
    const glm::dvec2 q = p - cell_.rect.centre(), d = glm::abs(q);
    const double r = glm::length(q);
    const bool path = std::abs(d.x - d.y) < 2.2 || std::abs(r - 20) < 1.8;
    return path ? kGravel : r < 18 ? blend(kPark, kLawn, 0.7) : kPark;
}

glm::vec3 Painter::square(glm::dvec2 p) const {
    const glm::dvec2 q = p - cell_.rect.centre();
    const double r = std::max(std::abs(q.x), std::abs(q.y)) +
                     0.41421356 * std::min(std::abs(q.x), std::abs(q.y)); // octagons
    if (r < 17)
        return blend(kSquare, kPaint, 0.25);
    const double ring = r - 8 * std::floor(r / 8);
    if (ring < 0.5)
        return kGravel * 0.84f;
    const glm::dvec2 slab{q.x / 2 - std::floor(q.x / 2), q.y / 2 - std::floor(q.y / 2)};
    return kSquare * (slab.x < 0.06 || slab.y < 0.06 ? 0.93f : 1.0f);
}

glm::vec3 Painter::insideBlock(glm::dvec2 p, const Block& block) const {
    switch (cell_.kind) {
    case CellKind::Country:
        return country(p);
    case CellKind::Park:
        return park(p);
    case CellKind::Square:
        return square(p);
    default:
        break;
    }
    const double patch = noise(p, 9);
    return block.green ? blend(kLawn, kGravel, smoothstep(0.66, 0.74, patch))
                       : blend(kYard, kLawn, smoothstep(0.55, 0.63, patch));
}

glm::vec3 Painter::street(glm::dvec2 p, double fromBlock) const {
    if (fromBlock < 2.3)
        return kPavement;
    if (fromBlock < 2.55)
        return kKerb;
    // Distances to the lines this street may run along.
    const Rect& r = cell_.rect;
    const double dx = std::min(p.x - r.west, r.east - p.x),
                 dy = std::min(p.y - r.south, r.north - p.y);
    if (dx < 12 && dy < 12) // a crossing
        return kAsphalt;
    const auto lane = [&](double across, double along, double toCrossing) {
        if (toCrossing < 15 && toCrossing > 12.2 && cell_.kind != CellKind::Country)
            return across - std::floor(across) < 0.5 ? kPaint : kAsphalt; // a zebra
        return centreLine(across, along);
    };
    if (dx < 12)
        return lane(dx, p.y, dy);
    if (dy < 12)
        return lane(dy, p.x, dx);
    for (const glm::dvec2 line : cell_.innerLines) {
        const bool vertical = std::isnan(line.y);
        const double across = vertical ? p.x - line.x : p.y - line.y;
        if (std::abs(across) < 5 && (vertical ? dy : dx) > 14)
            return centreLine(across, vertical ? p.y : p.x);
    }
    return kAsphalt;
}

glm::vec3 Painter::surface(glm::dvec2 p) const {
    const double bank = nearRiver_ ? plan_.riverDistance(p) - plan_.riverHalfWidth() : 1e9;
    if (bank < 0)
        return blend(kWater, kDeep, smoothstep(0, -10, bank) * (0.7 + 0.3 * noise(p, 14)));
    if (bank < 2.5)
        return kSand;
    const bool onBridgeRoad = std::abs(p.x - Plan::axisX()) < 5 &&
                              std::abs(p.y - plan_.bridgeY()) > plan_.deckHalfLength();
    if (bank < 26 && !onBridgeRoad && cell_.kind != CellKind::Country) {
        if (bank > 8 && bank < 11.5)
            return kGravel;
        if (bank < 20)
            return kPark;
    } else if (bank < 14 && cell_.kind == CellKind::Country) {
        return kPark;
    }
    if (cell_.kind != CellKind::Country) {
        const double avenue = std::abs(plan_.avenueDistance(p));
        const double along = glm::dot(p, glm::dvec2(0.8, 0.6));
        if (avenue < 7)
            return centreLine(avenue, along);
        if (avenue < 11)
            return avenue < 7.25 ? kKerb : kPavement;
    }
    double fromBlock = 1e9;
    for (const Block& b : cell_.blocks) {
        const glm::dvec2 q = glm::max(glm::dvec2(b.rect.west, b.rect.south) - p,
                                      p - glm::dvec2(b.rect.east, b.rect.north));
        const double d = std::max(q.x, q.y);
        if (d <= 0)
            return insideBlock(p, b);
        fromBlock = std::min(fromBlock, d);
    }
    return street(p, fromBlock);
}

glm::vec3 Painter::color(glm::dvec2 p) const {
    const double grain = 0.97 + 0.06 * (0.6 * noise(p, 2.3) + 0.4 * noise(p, 17));
    return surface(p) * float(grain);
}

} // namespace

void paintGround(Pixels& pixels, const Rect& shown, const Plan& plan, const Cell& cell) {
    const Painter painter(plan, cell);
    const double metres = shown.width() / pixels.size;
    const int x0 = int((cell.rect.west - shown.west) / metres);
    const int x1 = int((cell.rect.east - shown.west) / metres);
    const int y0 = int((shown.north - cell.rect.north) / metres);
    const int y1 = int((shown.north - cell.rect.south) / metres);
    for (int y = y0; y < y1; ++y)
        for (int x = x0; x < x1; ++x) {
            const glm::vec3 c =
                painter.color({shown.west + (x + 0.5) * metres, shown.north - (y + 0.5) * metres});
            for (int k = 0; k < 3; ++k)
                pixels.at(x, y)[k] = std::uint8_t(std::clamp(c[k], 0.0f, 255.0f) + 0.5f);
        }
}

void shrinkInto(Pixels& parent, const Pixels& child, bool east, bool north) {
    const int half = parent.size / 2;
    for (int y = 0; y < half; ++y)
        for (int x = 0; x < half; ++x)
            for (int k = 0; k < 3; ++k) {
                const int sum = child.at(2 * x, 2 * y)[k] + child.at(2 * x + 1, 2 * y)[k] +
                                child.at(2 * x, 2 * y + 1)[k] + child.at(2 * x + 1, 2 * y + 1)[k];
                parent.at(x + (east ? half : 0), y + (north ? 0 : half))[k] =
                    std::uint8_t((sum + 2) / 4);
            }
}

Pixels facadePixels(Facade facade, std::uint64_t seed) {
    constexpr int kBay = 32; // pixels a bay and a storey
    Pixels pixels(4 * kBay);
    const auto paint = [&](int x, int y, glm::vec3 c) {
        for (int k = 0; k < 3; ++k)
            pixels.at(x, y)[k] = std::uint8_t(std::clamp(c[k], 0.0f, 255.0f));
    };
    for (int y = 0; y < pixels.size; ++y)
        for (int x = 0; x < pixels.size; ++x) {
            const int bx = x % kBay, by = y % kBay;
            Random random(hash(seed, x / kBay, y / kBay, facade == Facade::Houses ? 70 : 71));
            const auto shade = float(random.in(0.8, 1.15));
            const bool curtain = random.chance(0.3);
            glm::vec3 c = rgb(255, 255, 255);
            if (facade == Facade::Houses) {
                const bool frame = bx >= 9 && bx < 23 && by >= 7 && by < 25;
                const bool glass = bx >= 10 && bx < 22 && by >= 8 && by < 24 && bx != 16;
                if (frame)
                    c = rgb(244, 242, 238);
                if (glass)
                    c = curtain && by < 16 ? rgb(196, 194, 186)
                                           : rgb(74, 86, 100) * (shade + 0.012f * float(24 - by));
                if (by >= 25 && by < 27 && bx >= 8 && bx < 24)
                    c = rgb(200, 196, 188); // the sill
            } else {
                const bool band = by >= 8 && by < 26;
                if (band)
                    c = bx == 0 || bx == 16 ? rgb(206, 210, 212)
                                            : rgb(84, 104, 122) * (shade + 0.015f * float(26 - by));
            }
            paint(x, y, c);
        }
    return pixels;
}

namespace {

Result<std::vector<std::byte>> encode(const Pixels& pixels, const char* format, const char* setting,
                                      int value) {
    auto out = OIIO::ImageOutput::create(format);
    if (!out)
        return Error{format, OIIO::geterror(), ErrorKind::Output};
    std::vector<unsigned char> bytes;
    OIIO::Filesystem::IOVecOutput file(bytes);
    OIIO::ImageSpec spec(pixels.size, pixels.size, pixels.channels, OIIO::TypeDesc::UINT8);
    spec.attribute("oiio:ColorSpace", "sRGB");
    spec.attribute("oiio:UnassociatedAlpha", 1);
    if (std::strcmp(setting, "Compression") == 0)
        spec.attribute(setting, "jpeg:" + std::to_string(value));
    else
        spec.attribute(setting, value);
    if (!out->set_ioproxy(&file) || !out->open(std::string("memory.") + format, spec) ||
        !out->write_image(OIIO::TypeDesc::UINT8, pixels.rgb.data()) || !out->close())
        return Error{format, out->geterror(), ErrorKind::Output};
    std::vector<std::byte> result(bytes.size());
    std::memcpy(result.data(), bytes.data(), bytes.size());
    return result;
}

} // namespace

Result<std::vector<std::byte>> encodeJpeg(const Pixels& pixels, int quality) {
    return encode(pixels, "jpg", "Compression", quality);
}

Result<std::vector<std::byte>> encodePng(const Pixels& pixels) {
    return encode(pixels, "png", "png:compressionLevel", 9);
}

} // namespace gnomon::builtin
