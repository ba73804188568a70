// Text as coverage, for the overlay: DejaVu Sans through FreeType. The same text gives the same
// pixels. (OpenImageIO's own render_text loses everything that is not ASCII: °, ©, ü.)
#pragma once

#include "geo/result.h"

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

namespace gnomon {

struct TextStyle {
    int pixels = 16; // of an em
    bool bold = false;
};

// A glyph's picture: 0…255 a pixel, rows top to bottom.
struct GlyphPicture {
    int left = 0, top = 0; // of its upper left pixel, right of the pen and above the base line
    int width = 0, height = 0;
    std::vector<std::uint8_t> coverage;
};

// Keeps the glyphs it has drawn; for one thread.
class Font {
  public:
    // Looked for where systems keep fonts; `folders` are searched instead where given. Fails when
    // there is none. Without a bold one the regular stands in.
    static Result<std::unique_ptr<Font>> find(const std::vector<std::string>& folders = {});
    ~Font();

    // Text is UTF-8; what is none, and control characters, are shown as such.
    double width(std::string_view text, TextStyle style) const;
    double capHeight(TextStyle style) const; // of an H above the base line
    // The text, or as much of its beginning as fits `most` pixels together with "…".
    std::string elided(std::string_view text, TextStyle style, double most) const;
    // Calls `draw` with every glyph and the pixel column of its pen, for a text from `x` on.
    void layOut(std::string_view text, TextStyle style, double x,
                const std::function<void(const GlyphPicture&, int column)>& draw) const;

  private:
    struct State;
    explicit Font(std::unique_ptr<State> state);
    std::unique_ptr<State> state_;
};

} // namespace gnomon
