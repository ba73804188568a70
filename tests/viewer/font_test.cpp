#include "viewer/font.h"

#include "tests/viewer/files.h"

#include <gtest/gtest.h>

using namespace gnomon;

namespace {

constexpr TextStyle kStyle{16, false};

class FontTest : public testing::Test {
  protected:
    void SetUp() override {
        auto font = Font::find();
        if (!font)
            GTEST_SKIP() << font.error().message();
        font_ = std::move(*font);
    }
    // The sum of what the glyphs cover.
    long long ink(std::string_view text, TextStyle style = kStyle) const {
        long long sum = 0;
        font_->layOut(text, style, 0.0, [&](const GlyphPicture& glyph, int) {
            for (const std::uint8_t covered : glyph.coverage)
                sum += covered;
        });
        return sum;
    }
    std::unique_ptr<Font> font_;
};

} // namespace

TEST(FontSearch, SaysInALineWhichFontIsNotThere) {
    const test::Folder folder;
    const auto font = Font::find({folder.path(), folder / "not there"});
    ASSERT_FALSE(font);
    EXPECT_NE(font.error().message().find("DejaVuSans.ttf"), std::string::npos);
    EXPECT_NE(font.error().message().find("fonts-dejavu-core"), std::string::npos);
}

TEST(FontSearch, TakesNoFileOfThatNameThatIsNoFont) {
    const test::Folder folder;
    folder.write("deep/er/DejaVuSans.ttf", "no font");
    const auto font = Font::find({folder.path()});
    ASSERT_FALSE(font);
    EXPECT_NE(font.error().message().find("deep/er/DejaVuSans.ttf"), std::string::npos);
}

TEST_F(FontTest, IsWiderForMoreTextAndForLargerText) {
    EXPECT_EQ(font_->width("", kStyle), 0.0);
    EXPECT_GT(font_->width("nn", kStyle), 1.9 * font_->width("n", kStyle));
    EXPECT_NEAR(font_->width("gnomon", {32, false}), 2.0 * font_->width("gnomon", {16, false}),
                0.5);
    EXPECT_GT(font_->width("gnomon", {16, true}), font_->width("gnomon", {16, false}));
    EXPECT_GT(ink("gnomon", {16, true}), ink("gnomon"));
}

TEST_F(FontTest, HasAllDigitsOfOneWidthSoThatAClockStandsStill) {
    for (const char* digit : {"1", "2", "3", "4", "5", "6", "7", "8", "9"})
        EXPECT_EQ(font_->width(digit, kStyle), font_->width("0", kStyle)) << digit;
}

TEST_F(FontTest, ShowsWhatIsNotAscii) {
    for (const char* text : {"\u00B0", "\u00A9", "\u00FC", "\u2026", "\u2265", "\u2212"}) {
        EXPECT_GT(ink(text), 0) << text;
        EXPECT_NE(ink(text), ink("\uFFFD")) << text;
    }
}

TEST_F(FontTest, ShowsBytesThatAreNoTextAsSuch) {
    const double unknown = font_->width("\uFFFD", kStyle);
    for (const std::string text : {"\xFF", "\xC3", "\x80", "\x01", "\n", "\xF8"})
        EXPECT_EQ(font_->width(text, kStyle), unknown) << int(text[0]);
    EXPECT_EQ(font_->width("\xE2\x80", kStyle), 2.0 * unknown); // cut short
    EXPECT_EQ(font_->width(std::string("\0", 1), kStyle), unknown);
}

TEST_F(FontTest, LeavesTextThatFitsAndEndsTheRestWithAnEllipsis) {
    const std::string text = "\u00A9 Geobasis NRW, dl-de/by-2-0";
    const double whole = font_->width(text, kStyle);
    EXPECT_EQ(font_->elided(text, kStyle, whole), text);
    EXPECT_EQ(font_->elided("", kStyle, 10.0), "");
    for (double most = 0.0; most < whole; most += 7.7) {
        const std::string cut = font_->elided(text, kStyle, most);
        if (cut.empty())
            continue;
        EXPECT_LE(font_->width(cut, kStyle), most);
        ASSERT_TRUE(cut.ends_with("\u2026"));
        const std::string kept = cut.substr(0, cut.size() - 3);
        EXPECT_TRUE(text.starts_with(kept));
        EXPECT_NE(kept.back(), ' ');
        EXPECT_NE(kept.back(), '\xC2'); // no half of the first character
    }
    EXPECT_GT(font_->elided(text, kStyle, 0.8 * whole).size(), text.size() / 2);
}

TEST_F(FontTest, ReadsNoMoreOfEndlessTextThanFits) {
    const std::string text(std::size_t(64) << 20, 'x');
    EXPECT_LT(font_->elided(text, kStyle, 1000.0).size(), 200u);
}

TEST_F(FontTest, PutsAGlyphAtTheSamePlaceBesideEveryColumn) {
    const auto columns = [&](double x) {
        std::vector<int> found;
        font_->layOut("A", kStyle, x,
                      [&](const GlyphPicture&, int column) { found.push_back(column); });
        return found;
    };
    EXPECT_EQ(columns(0.0), std::vector{0});
    EXPECT_EQ(columns(7.74), std::vector{7});
    EXPECT_EQ(columns(7.9), std::vector{8});
    EXPECT_EQ(columns(-0.25), std::vector{-1});
    EXPECT_EQ(columns(-1.0), std::vector{-1});
    EXPECT_EQ(columns(-1.25), std::vector{-2});
}
