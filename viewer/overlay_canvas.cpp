#include "viewer/overlay_canvas.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace gnomon {

namespace {

constexpr int kLinesPerRow = 4; // coverage is exact along these, and their mean across

// Adds to `row`, which begins at pixel `first`, how much of each pixel is between two columns.
void addSpan(std::vector<float>& row, int first, double begin, double end) {
    begin = std::max(begin - first, 0.0);
    end = std::min(end - first, double(row.size()));
    if (!(begin < end))
        return;
    const auto from = std::size_t(begin), to = std::min(std::size_t(end), row.size() - 1);
    if (from == to) {
        row[from] += float(end - begin);
        return;
    }
    row[from] += float(double(from) + 1.0 - begin);
    for (std::size_t x = from + 1; x < to; ++x)
        row[x] += 1.0f;
    row[to] += float(end - double(to));
}

void crossingsAt(const std::vector<glm::dvec2>& outline, double y, std::vector<double>& found) {
    found.clear();
    for (std::size_t i = 0; i < outline.size(); ++i) {
        const glm::dvec2 a = outline[i], b = outline[(i + 1) % outline.size()];
        if ((a.y <= y) != (b.y <= y))
            found.push_back(a.x + (y - a.y) * (b.x - a.x) / (b.y - a.y));
    }
    std::sort(found.begin(), found.end());
}

} // namespace

void OverlayCanvas::blend(int x, int y, double share, OverlayColor color) {
    const int alpha = int(share * color.alpha + 0.5);
    std::uint8_t* pixel =
        &picture_.rgb[3 * (std::size_t(y) * std::size_t(picture_.width) + std::size_t(x))];
    const auto mix = [alpha](std::uint8_t& under, std::uint8_t over) {
        under = std::uint8_t((under * (255 - alpha) + over * alpha + 127) / 255);
    };
    mix(pixel[0], color.red);
    mix(pixel[1], color.green);
    mix(pixel[2], color.blue);
}

void OverlayCanvas::fill(const std::vector<glm::dvec2>& outline, OverlayColor color) {
    if (outline.empty())
        return;
    glm::dvec2 least = outline.front(), most = outline.front();
    for (const glm::dvec2 p : outline) {
        least = {std::min(least.x, p.x), std::min(least.y, p.y)};
        most = {std::max(most.x, p.x), std::max(most.y, p.y)};
    }
    const int left = int(std::clamp(std::floor(least.x), 0.0, double(picture_.width)));
    const int right = int(std::clamp(std::ceil(most.x), 0.0, double(picture_.width)));
    const int top = int(std::clamp(std::floor(least.y), 0.0, double(picture_.height)));
    const int bottom = int(std::clamp(std::ceil(most.y), 0.0, double(picture_.height)));
    if (left >= right)
        return;
    for (int y = top; y < bottom; ++y) {
        row_.assign(std::size_t(right - left), 0.0f);
        for (int line = 0; line < kLinesPerRow; ++line) {
            crossingsAt(outline, y + (line + 0.5) / kLinesPerRow, crossings_);
            for (std::size_t i = 0; i + 1 < crossings_.size(); i += 2)
                addSpan(row_, left, crossings_[i], crossings_[i + 1]);
        }
        for (int x = left; x < right; ++x)
            if (const float covered = row_[std::size_t(x - left)]; covered > 0.0f)
                blend(x, y, std::min(double(covered) / kLinesPerRow, 1.0), color);
    }
}

void OverlayCanvas::fill(const OverlayBox& box, OverlayColor color, double cornerRadius) {
    constexpr int kSteps = 8; // of a corner: off by r (1 - cos 5.6°), 0.1 pixel at r = 20
    const double r = std::clamp(cornerRadius, 0.0, 0.5 * std::min(box.width(), box.height()));
    if (r == 0.0)
        return fill({{box.left, box.top},
                     {box.right, box.top},
                     {box.right, box.bottom},
                     {box.left, box.bottom}},
                    color);
    std::vector<glm::dvec2> outline;
    for (int corner = 0; corner < 4; ++corner) {
        const glm::dvec2 centre(corner == 0 || corner == 3 ? box.right - r : box.left + r,
                                corner < 2 ? box.bottom - r : box.top + r);
        for (int i = 0; i <= kSteps; ++i) {
            const double angle = (corner + double(i) / kSteps) * std::numbers::pi / 2.0;
            outline.push_back(centre + r * glm::dvec2(std::cos(angle), std::sin(angle)));
        }
    }
    fill(outline, color);
}

void OverlayCanvas::line(glm::dvec2 from, glm::dvec2 to, double width, OverlayColor color) {
    const glm::dvec2 along = to - from;
    const double length = std::hypot(along.x, along.y);
    if (length == 0.0)
        return;
    const glm::dvec2 side = glm::dvec2(-along.y, along.x) * (0.5 * width / length);
    fill({from + side, to + side, to - side, from - side}, color);
}

std::vector<glm::dvec2> ellipse(glm::dvec2 centre, glm::dvec2 a, glm::dvec2 b) {
    constexpr int kSides = 64;
    std::vector<glm::dvec2> outline;
    for (int i = 0; i < kSides; ++i) {
        const double angle = 2.0 * std::numbers::pi * i / kSides;
        outline.push_back(centre + std::cos(angle) * a + std::sin(angle) * b);
    }
    return outline;
}

void OverlayCanvas::ring(glm::dvec2 centre, glm::dvec2 a, glm::dvec2 b, double width,
                         OverlayColor color) {
    const auto shorter = [width](glm::dvec2 axis) {
        const double length = std::hypot(axis.x, axis.y);
        return length > width ? axis * (1.0 - width / length) : glm::dvec2(0.0);
    };
    // One outline there and back again: the way between is walked twice and cuts out nothing.
    std::vector<glm::dvec2> band = ellipse(centre, a, b);
    band.push_back(band.front());
    const std::vector<glm::dvec2> inner = ellipse(centre, shorter(a), shorter(b));
    band.insert(band.end(), inner.begin(), inner.end());
    band.push_back(inner.front());
    fill(band, color);
}

void OverlayCanvas::text(std::string_view text, TextStyle style, double x, double baseline,
                         OverlayColor color) {
    const int base = int(std::lround(baseline));
    font_.layOut(text, style, x, [&](const GlyphPicture& glyph, int column) {
        for (int j = 0; j < glyph.height; ++j)
            for (int i = 0; i < glyph.width; ++i) {
                const int px = column + glyph.left + i, py = base - glyph.top + j;
                const std::uint8_t covered =
                    glyph.coverage[std::size_t(j) * std::size_t(glyph.width) + std::size_t(i)];
                if (covered != 0 && px >= 0 && py >= 0 && px < picture_.width &&
                    py < picture_.height)
                    blend(px, py, covered / 255.0, color);
            }
    });
}

} // namespace gnomon
