#include "viewer/font.h"

#include <ft2build.h>
#include FT_FREETYPE_H
#include FT_OUTLINE_H

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <optional>
#include <unordered_map>

namespace gnomon {

namespace {

namespace fs = std::filesystem;

constexpr const char* kRegular = "DejaVuSans.ttf";
constexpr const char* kBold = "DejaVuSans-Bold.ttf";
constexpr char32_t kNoCharacter = 0xFFFD;
constexpr int kPositions = 4; // of a glyph between two pixel columns
constexpr int kUnit = 64;     // FreeType counts in 1/64 pixels

// The roots of what the freedesktop and Debian, Fedora, Arch and macOS agree on.
std::vector<std::string> fontFolders() {
    std::vector<std::string> folders;
    const auto add = [&](const char* variable, const char* rest, const char* otherwise) {
        const char* value = std::getenv(variable);
        std::string list = value && *value ? value : otherwise;
        for (std::size_t begin = 0; begin < list.size();) {
            const std::size_t end = std::min(list.find(':', begin), list.size());
            if (end > begin)
                folders.push_back(list.substr(begin, end - begin) + rest);
            begin = end + 1;
        }
    };
    add("XDG_DATA_DIRS", "/fonts", "/usr/local/share:/usr/share");
    folders.insert(folders.end(), {"/usr/share/fonts", "/usr/local/share/fonts", "/Library/Fonts"});
    add("XDG_DATA_HOME", "/fonts", "");
    add("HOME", "/.local/share/fonts", "");
    add("HOME", "/.fonts", "");
    return folders;
}

// A folder that cannot be read has none; deep or endless ones are left.
std::optional<fs::path> findBelow(const std::string& folder, const char* name) {
    constexpr int kDeepest = 6, kMostFiles = 100'000;
    std::error_code wrong;
    fs::recursive_directory_iterator at(folder, fs::directory_options::skip_permission_denied,
                                        wrong);
    for (int seen = 0; !wrong && at != fs::end(at) && seen < kMostFiles; ++seen) {
        if (at->path().filename() == name && at->is_regular_file(wrong))
            return at->path();
        if (at.depth() >= kDeepest)
            at.disable_recursion_pending();
        at.increment(wrong);
    }
    return {};
}

std::optional<fs::path> findFont(const std::vector<std::string>& folders, const char* name) {
    for (const std::string& folder : folders)
        if (auto found = findBelow(folder, name))
            return found;
    return {};
}

// Takes one character from the front of `text`.
char32_t takeCharacter(std::string_view& text) {
    const auto byte = [&](std::size_t i) { return static_cast<unsigned char>(text[i]); };
    const unsigned char first = byte(0);
    const std::size_t length = first < 0x80             ? 1
                               : (first & 0xE0) == 0xC0 ? 2
                               : (first & 0xF0) == 0xE0 ? 3
                               : (first & 0xF8) == 0xF0 ? 4
                                                        : 0;
    if (length == 0 || length > text.size()) {
        text.remove_prefix(1);
        return kNoCharacter;
    }
    char32_t code = length == 1 ? first : first & (0x7Fu >> length);
    for (std::size_t i = 1; i < length; ++i) {
        if ((byte(i) & 0xC0) != 0x80) {
            text.remove_prefix(1);
            return kNoCharacter;
        }
        code = code << 6 | (byte(i) & 0x3Fu);
    }
    text.remove_prefix(length);
    const bool control = code < 0x20 || (code >= 0x7F && code < 0xA0);
    return control ? kNoCharacter : code;
}

} // namespace

struct Font::State {
    FT_Library library = nullptr;
    FT_Face regular = nullptr, bold = nullptr;
    struct Glyph {
        FT_UInt index = 0;
        double advance = 0.0; // pixels
        GlyphPicture picture;
    };
    // By character, size, weight and position between two columns.
    std::unordered_map<std::uint64_t, Glyph> glyphs;

    ~State() {
        if (bold)
            FT_Done_Face(bold);
        if (regular)
            FT_Done_Face(regular);
        if (library)
            FT_Done_FreeType(library);
    }

    FT_Face face(TextStyle style) {
        const FT_Face chosen = style.bold && bold ? bold : regular;
        if (chosen->size->metrics.y_ppem != style.pixels)
            FT_Set_Pixel_Sizes(chosen, 0, FT_UInt(style.pixels));
        return chosen;
    }

    const Glyph& glyph(char32_t character, TextStyle style, int position) {
        const std::uint64_t key = std::uint64_t(character) | std::uint64_t(style.pixels) << 21 |
                                  std::uint64_t(style.bold) << 40 | std::uint64_t(position) << 41;
        const auto [at, fresh] = glyphs.try_emplace(key);
        if (fresh)
            draw(character, style, position, at->second);
        return at->second;
    }

    void draw(char32_t character, TextStyle style, int position, Glyph& into) {
        const FT_Face from = face(style);
        into.index = FT_Get_Char_Index(from, character);
        // Light: hinted in height only, so that what stands beside it may be anywhere.
        if (FT_Load_Glyph(from, into.index, FT_LOAD_TARGET_LIGHT | FT_LOAD_NO_BITMAP) != 0)
            return;
        constexpr double kFixed = 65536.0; // 16.16
        into.advance = double(from->glyph->linearHoriAdvance) / kFixed;
        FT_Outline_Translate(&from->glyph->outline, position * kUnit / kPositions, 0);
        if (FT_Render_Glyph(from->glyph, FT_RENDER_MODE_NORMAL) != 0)
            return;
        const FT_Bitmap& bitmap = from->glyph->bitmap;
        into.picture.left = from->glyph->bitmap_left;
        into.picture.top = from->glyph->bitmap_top;
        into.picture.width = int(bitmap.width);
        into.picture.height = int(bitmap.rows);
        for (int row = 0; row < int(bitmap.rows); ++row) {
            const std::uint8_t* line = bitmap.buffer + std::ptrdiff_t(row) * bitmap.pitch;
            into.picture.coverage.insert(into.picture.coverage.end(), line, line + bitmap.width);
        }
    }

    double kerning(FT_UInt left, FT_UInt right, TextStyle style) {
        FT_Vector shift{0, 0};
        const FT_Face from = face(style);
        if (left == 0 || right == 0 || !FT_HAS_KERNING(from) ||
            FT_Get_Kerning(from, left, right, FT_KERNING_UNFITTED, &shift) != 0)
            return 0.0;
        return double(shift.x) / kUnit;
    }

    // Goes along a text: `at(pen before the character, character, bytes taken with it)` until it
    // says no. Gives where the pen ends.
    template <class At>
    double walk(std::string_view text, TextStyle style, const At& at) {
        double pen = 0.0;
        FT_UInt before = 0;
        const std::size_t whole = text.size();
        while (!text.empty()) {
            const char32_t character = takeCharacter(text);
            const Glyph& next = glyph(character, style, 0);
            pen += kerning(before, next.index, style);
            before = next.index;
            const double begin = pen;
            pen += next.advance;
            if (!at(begin, pen, character, whole - text.size()))
                break;
        }
        return pen;
    }
};

Font::Font(std::unique_ptr<State> state) : state_(std::move(state)) {}
Font::~Font() = default;

Result<std::unique_ptr<Font>> Font::find(const std::vector<std::string>& folders) {
    const std::vector<std::string> searched = folders.empty() ? fontFolders() : folders;
    const auto regular = findFont(searched, kRegular);
    if (!regular)
        return Error{kRegular, "is not installed (in Debian, fonts-dejavu-core has it)"};
    auto state = std::make_unique<State>();
    if (FT_Init_FreeType(&state->library) != 0)
        return Error{regular->string(), "FreeType cannot be started"};
    if (FT_New_Face(state->library, regular->c_str(), 0, &state->regular) != 0)
        return Error{regular->string(), "is no font that can be read"};
    if (const auto bold = findFont({regular->parent_path().string()}, kBold))
        if (FT_New_Face(state->library, bold->c_str(), 0, &state->bold) != 0)
            state->bold = nullptr;
    return std::unique_ptr<Font>(new Font(std::move(state)));
}

double Font::width(std::string_view text, TextStyle style) const {
    return state_->walk(text, style, [](double, double, char32_t, std::size_t) { return true; });
}

double Font::capHeight(TextStyle style) const {
    return state_->glyph(U'H', style, 0).picture.top;
}

std::string Font::elided(std::string_view text, TextStyle style, double most) const {
    static constexpr const char* kEllipsis = "\u2026";
    const double room = most - width(kEllipsis, style);
    std::size_t kept = 0;
    const double all =
        state_->walk(text, style, [&](double, double end, char32_t character, std::size_t taken) {
            if (end <= room && character != U' ')
                kept = taken;
            return end <= most;
        });
    if (all <= most)
        return std::string(text);
    return kept == 0 ? "" : std::string(text.substr(0, kept)) + kEllipsis;
}

void Font::layOut(std::string_view text, TextStyle style, double x,
                  const std::function<void(const GlyphPicture&, int column)>& draw) const {
    state_->walk(text, style, [&](double begin, double, char32_t character, std::size_t) {
        const long long place = std::llround((x + begin) * kPositions);
        const long long column = place >= 0 ? place / kPositions : -((-place + 3) / kPositions);
        const int position = int(place - column * kPositions);
        draw(state_->glyph(character, style, position).picture, int(column));
        return true;
    });
}

} // namespace gnomon
