// Draws antialiased shapes and text over a picture. Colours are sRGB and are mixed as they are
// stored, as people expect of plates and text.
#pragma once

#include "viewer/font.h"
#include "viewer/frame.h"

#include <glm/vec2.hpp>

#include <vector>

namespace gnomon {

struct OverlayColor {
    std::uint8_t red = 0, green = 0, blue = 0, alpha = 255;
};

// In pixels, y down; a pixel's own square is from its index to the next.
struct OverlayBox {
    double left = 0, top = 0, right = 0, bottom = 0;
    double width() const { return right - left; }
    double height() const { return bottom - top; }
    bool meets(const OverlayBox& other) const {
        return left < other.right && other.left < right && top < other.bottom && other.top < bottom;
    }
};

class OverlayCanvas {
  public:
    OverlayCanvas(Picture& picture, const Font& font) : picture_(picture), font_(font) {}

    // Even-odd. What lies outside the picture is cut off.
    void fill(const std::vector<glm::dvec2>& outline, OverlayColor color);
    void fill(const OverlayBox& box, OverlayColor color, double cornerRadius = 0.0);
    void line(glm::dvec2 from, glm::dvec2 to, double width, OverlayColor color);
    // A closed band inside the outline of an ellipse: its half axes, as vectors.
    void ring(glm::dvec2 centre, glm::dvec2 a, glm::dvec2 b, double width, OverlayColor color);
    // From `x` on, standing on `baseline`, which is rounded to a whole row.
    void text(std::string_view text, TextStyle style, double x, double baseline,
              OverlayColor color);

  private:
    void blend(int x, int y, double share, OverlayColor color);

    Picture& picture_;
    const Font& font_;
    std::vector<float> row_; // coverage, kept between calls
    std::vector<double> crossings_;
};

std::vector<glm::dvec2> ellipse(glm::dvec2 centre, glm::dvec2 a, glm::dvec2 b);

} // namespace gnomon
