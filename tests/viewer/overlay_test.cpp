#include "viewer/overlay.h"

#include "viewer/overlay_marks.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

using namespace gnomon;

namespace {

using Rgb = std::array<std::uint8_t, 3>;

constexpr Geodetic kPlace{6.96, 50.94, 50.0};
constexpr Rgb kGrey{120, 120, 120};

Picture grey(int width, int height) {
    return {width, height, std::vector<std::uint8_t>(3 * std::size_t(width) * height, kGrey[0])};
}

Rgb at(const Picture& picture, int x, int y) {
    const std::uint8_t* p = &picture.rgb[3 * (std::size_t(y) * picture.width + x)];
    return {p[0], p[1], p[2]};
}

struct Bounds {
    int left = std::numeric_limits<int>::max(), top = left, right = -1, bottom = -1;
    int count = 0;
    glm::dvec2 middle{0.0}; // of the pixels' centres
};
// Of the pixels that are `chosen`.
template <class Chosen>
Bounds where(const Picture& picture, const Chosen& chosen) {
    Bounds found;
    for (int y = 0; y < picture.height; ++y)
        for (int x = 0; x < picture.width; ++x)
            if (chosen(x, y, at(picture, x, y))) {
                found.left = std::min(found.left, x), found.right = std::max(found.right, x);
                found.top = std::min(found.top, y), found.bottom = std::max(found.bottom, y);
                found.middle += glm::dvec2(x + 0.5, y + 0.5);
                ++found.count;
            }
    found.middle /= std::max(found.count, 1);
    return found;
}
bool changed(int, int, Rgb pixel) {
    return pixel != kGrey;
}

OverlayFacts lookingDown(int width, int height, double heading = 0.0, double distance = 500.0) {
    OverlayFacts facts;
    place(facts.camera, kPlace, {heading, -90.0, 0.0});
    facts.camera.position = facts.camera.position - distance * facts.camera.forward;
    facts.camera.widthPixels = width;
    facts.camera.heightPixels = height;
    facts.sun = {215.0, 35.0};
    return facts;
}

OverlayFacts everything(int width, int height) {
    OverlayFacts facts = lookingDown(width, height, 30.0);
    facts.time = *parseTime("2021-07-14T16:00Z");
    facts.timeZone = "Europe/Berlin";
    facts.groundAtCentre = ecefOf(kPlace);
    facts.flood = FloodTimes{*parseTime("2021-07-14T12:00Z"), *parseTime("2021-07-15T02:00Z")};
    facts.legends = {{"Water depth", "m", 0, 4, ColorMap::Depth, true, false},
                     {"Water speed", "m/s", 0, 1.5, ColorMap::Speed, false, true},
                     {"Terrain height", "m", 38.3, 121.7, ColorMap::Elevation, false, false}};
    facts.credits = {"\u00A9 Geobasis NRW", "\u00A9 OpenStreetMap contributors"};
    return facts;
}

class OverlayTest : public testing::Test {
  protected:
    void SetUp() override {
        auto overlay = Overlay::create();
        if (!overlay)
            GTEST_SKIP() << overlay.error().message();
        overlay_ = std::move(*overlay);
    }
    Picture drawn(const OverlayFacts& facts, int width = 1280, int height = 720) const {
        Picture picture = grey(width, height);
        EXPECT_TRUE(overlay_->draw(picture, facts).empty());
        return picture;
    }
    std::unique_ptr<Overlay> overlay_;
};

} // namespace

TEST_F(OverlayTest, IsTheSameToTheByteForTheSameFacts) {
    const OverlayFacts facts = everything(1280, 720);
    const Picture first = drawn(facts);
    drawn(lookingDown(640, 360), 640, 360);
    EXPECT_EQ(drawn(facts).rgb, first.rgb);
    Picture other = grey(1280, 720);
    (*Overlay::create())->draw(other, facts);
    EXPECT_EQ(other.rgb, first.rgb);
}

TEST_F(OverlayTest, LeavesTheMiddleOfThePictureAlone) {
    for (const auto& [width, height] :
         {std::pair{1280, 720}, {640, 360}, {3840, 2160}, {720, 1280}, {800, 800}, {480, 270}}) {
        OverlayFacts facts = everything(width, height);
        for (int i = 0; i < 20; ++i) {
            facts.legends.push_back(facts.legends[std::size_t(i % 3)]);
            facts.credits.push_back(std::string(200, 'x'));
        }
        Picture picture = grey(width, height);
        overlay_->draw(picture, facts);
        const Bounds inMiddle = where(picture, [&](int x, int y, Rgb pixel) {
            return pixel != kGrey && x >= 0.3 * width && x < 0.7 * width && y >= 0.3 * height &&
                   y < 0.7 * height;
        });
        EXPECT_EQ(inMiddle.count, 0) << width;
        EXPECT_GT(where(picture, changed).count, 0) << width;
    }
}

TEST_F(OverlayTest, ChangesOnlyThePlatesAtItsEdges) {
    const Picture picture = drawn(lookingDown(1280, 720));
    // Without time, ground, water and credits: the sun at the upper left, the compass opposite.
    const Bounds sun = where(picture, [](int x, int, Rgb p) { return p != kGrey && x < 640; });
    EXPECT_EQ(sun.left, 13); // 0.8 of the text's 16 pixels
    EXPECT_EQ(sun.top, 13);
    EXPECT_LT(sun.right, 320);
    EXPECT_LT(sun.bottom, 60);
    const Bounds compass = where(picture, [](int x, int, Rgb p) { return p != kGrey && x >= 640; });
    EXPECT_EQ(compass.right, 1280 - 13 - 1);
    EXPECT_EQ(compass.top, 13);
    EXPECT_EQ(compass.right - compass.left, compass.bottom - compass.top);
    EXPECT_LT(compass.bottom, 100);
}

TEST_F(OverlayTest, TheScaleBarIsAsLongAsItSays) {
    for (const auto& [width, height, distance] : {std::tuple{1280, 720, 500.0},
                                                  {1920, 1080, 500.0},
                                                  {1280, 720, 1234.0},
                                                  {3840, 2160, 90.0}}) {
        OverlayFacts facts = lookingDown(width, height, 0.0, distance);
        facts.groundAtCentre = ecefOf(kPlace);
        const Picture picture = drawn(facts, width, height);
        // The bar is the longest row of its own white below the middle.
        int longest = 0;
        for (int y = height / 2; y < height; ++y)
            for (int x = 0, run = 0; x < width; ++x) {
                run = at(picture, x, y) == Rgb{248, 248, 248} ? run + 1 : 0;
                longest = std::max(longest, run);
            }
        const double metresPerPixel = 2.0 * distance * facts.camera.tanHalfHeight() / height;
        const auto bar = scaleBar(metresPerPixel, 12.0 * overlayTextPixels(width, height));
        ASSERT_TRUE(bar);
        EXPECT_NEAR(longest, bar->pixels, 1.0) << width << ' ' << distance;
    }
}

TEST_F(OverlayTest, HasNoScaleBarWhereTheHorizonIs) {
    OverlayFacts facts = lookingDown(1280, 720);
    facts.groundAtCentre = ecefOf(kPlace);
    const auto lowerRight = [](int x, int y, Rgb p) { return p != kGrey && x > 640 && y > 360; };
    EXPECT_GT(where(drawn(facts), lowerRight).count, 0);
    place(facts.camera, {6.96, 50.94, 300.0}, {0, -10, 0});
    EXPECT_EQ(where(drawn(facts), lowerRight).count, 0);
}

TEST_F(OverlayTest, TheCompassNeedlePointsNorth) {
    for (const double heading : {0.0, 30.0, 90.0, 135.0, 240.0, 330.0}) {
        const Picture picture = drawn(lookingDown(1280, 720, heading));
        const Bounds dial = where(picture, [](int x, int, Rgb p) { return p != kGrey && x > 640; });
        const glm::dvec2 centre(0.5 * (dial.left + dial.right + 1),
                                0.5 * (dial.top + dial.bottom + 1));
        const Bounds tip = where(picture, [](int x, int, Rgb p) {
            return x > 640 && p == Rgb{240, 120, 60};
        });
        ASSERT_GT(tip.count, 10);
        const glm::dvec2 to = tip.middle - centre;
        const double angle = std::atan2(to.x, -to.y) / kRadiansPerDegree; // clockwise from up
        EXPECT_NEAR(std::remainder(angle + heading, 360.0), 0.0, 3.0) << heading;
    }
}

TEST_F(OverlayTest, ALegendsBarRunsThroughItsColours) {
    OverlayFacts facts = lookingDown(1280, 720);
    for (const ColorMap map : {ColorMap::Depth, ColorMap::Speed, ColorMap::Elevation}) {
        facts.legends = {{"Water depth", "m", 0, 4, map, false, false}};
        const Picture picture = drawn(facts);
        const auto color = [map](double share) {
            const glm::vec3 c = colorAt(map, share);
            return Rgb{std::uint8_t(std::lround(c.r * 255)), std::uint8_t(std::lround(c.g * 255)),
                       std::uint8_t(std::lround(c.b * 255))};
        };
        const Bounds plate =
            where(picture, [](int x, int y, Rgb p) { return p != kGrey && x < 640 && y > 360; });
        const int from = plate.left + 10, to = plate.right + 1 - 10; // 0.65 of 16 pixels inside
        for (const int x : {from, (from + to) / 2, to - 1}) {
            const Rgb wanted = color((x + 0.5 - from) / (to - from));
            const Bounds column = where(
                picture, [&](int px, int py, Rgb p) { return px == x && py > 360 && p == wanted; });
            EXPECT_GE(column.count, 8) << x;
        }
    }
}

TEST_F(OverlayTest, SaysWhichWaterIsInterpolated) {
    OverlayFacts facts = lookingDown(1280, 720);
    const auto orange = [](int x, int y, Rgb p) {
        return x < 640 && y > 360 && p[0] > 200 && p[1] > 130 && p[2] < 140;
    };
    facts.legends = {{"Water depth", "m", 0, 4, ColorMap::Depth, false, false}};
    EXPECT_EQ(where(drawn(facts), orange).count, 0);
    facts.legends[0].interpolated = true;
    EXPECT_GT(where(drawn(facts), orange).count, 50);
    facts.legends[0].most = 0.0; // of no number
    EXPECT_GT(where(drawn(facts), orange).count, 50);
}

TEST_F(OverlayTest, TheClocksPlateStaysWhereItIsFromFrameToFrame) {
    OverlayFacts facts = everything(1280, 720);
    const auto clock = [&] {
        const Bounds b = where(
            drawn(facts), [](int x, int y, Rgb p) { return p != kGrey && x < 640 && y < 200; });
        return std::array{b.left, b.top, b.right, b.bottom};
    };
    for (const bool timed : {true, false}) {
        if (!timed)
            facts.time = {}; // the sun's angles are the widest line then
        facts.sun = {215.0, 35.0};
        const auto before = clock();
        facts.sun = {7.0, 1.0};
        if (timed)
            facts.time->seconds += 3600.0;
        EXPECT_EQ(clock(), before);
        facts.sun = {288.8, -88.8};
        EXPECT_EQ(clock(), before);
    }
}

TEST_F(OverlayTest, TellsTheTimeByTheZonesClock) {
    OverlayFacts facts = everything(1280, 720);
    facts.flood = {};
    const Picture berlin = drawn(facts);
    facts.timeZone = "+02:00";
    EXPECT_NE(drawn(facts).rgb, berlin.rgb);
    facts.timeZone = {};
    const Picture utc = drawn(facts);
    EXPECT_NE(utc.rgb, berlin.rgb);
    facts.timeZone = "Nowhere/Land"; // told by UTC then
    EXPECT_EQ(drawn(facts).rgb, utc.rgb);
}

TEST_F(OverlayTest, ShowsHowFarTheFloodIs) {
    OverlayFacts facts = everything(1280, 720);
    const auto past = [&] { // the part of the line that is over, by its colour
        return where(drawn(facts), [](int x, int y, Rgb p) {
            return x < 640 && y < 200 && p[2] > 180 && p[0] < 150;
        });
    };
    const double first = facts.flood->first.seconds, last = facts.flood->last.seconds;
    facts.time = UtcTime{first};
    EXPECT_EQ(past().count, 0);
    facts.time = UtcTime{first + 0.5 * (last - first)};
    const Bounds half = past();
    facts.time = UtcTime{first + 0.75 * (last - first)};
    const Bounds more = past();
    EXPECT_EQ(half.left, more.left);
    EXPECT_NEAR(double(more.right - more.left) / (half.right - half.left), 1.5, 0.06);
    // Beyond its end it is said that this is not the water of then.
    const auto orange = [](int x, int y, Rgb p) {
        return x < 640 && y < 200 && p[0] > 200 && p[1] > 130 && p[2] < 140;
    };
    EXPECT_EQ(where(drawn(facts), orange).count, 0);
    facts.time = UtcTime{last + 60.0};
    EXPECT_GT(where(drawn(facts), orange).count, 50);
}

TEST_F(OverlayTest, NamesTheLegendsThatFindNoRoom) {
    OverlayFacts facts = lookingDown(400, 225);
    for (const char* title : {"A", "B", "C", "D", "E", "F"})
        facts.legends.push_back({title, "m", 0, 1, ColorMap::Depth, false, false});
    Picture picture = grey(400, 225);
    const std::vector<std::string> left = overlay_->draw(picture, facts);
    ASSERT_FALSE(left.empty());
    EXPECT_LT(left.size(), 6u);
    EXPECT_EQ(left.back(), "the legend of F");
}

TEST_F(OverlayTest, TextGrowsWithThePictureAndStaysLegible) {
    EXPECT_EQ(overlayTextPixels(1280, 720), 16);
    EXPECT_EQ(overlayTextPixels(3840, 2160), 48);
    EXPECT_EQ(overlayTextPixels(640, 360), 11);
    EXPECT_EQ(overlayTextPixels(1080, 1920), 18);
}

TEST_F(OverlayTest, DrawsAnySizeAndAnyFacts) {
    const double nan = std::numeric_limits<double>::quiet_NaN(), huge = 1e308;
    OverlayFacts facts = everything(100, 100);
    facts.credits = {std::string(1 << 20, '\xFF'), "\x1b[31m\n", std::string(1 << 20, 'y')};
    facts.legends = {{std::string(1 << 16, 'z'), "\xC3", nan, huge, ColorMap::Depth, true, true},
                     {"", "", -huge, huge, ColorMap::Speed, true, true},
                     {"a", "m", 1e-300, 2e-300, ColorMap::Speed, true, false},
                     {"b", "m", huge / 2, huge, ColorMap::Elevation, true, false}};
    for (const int size : {0, 1, 2, 7, 30, 100, 333})
        for (const int other : {1, 50, 700}) {
            facts.camera.widthPixels = size, facts.camera.heightPixels = other;
            Picture picture = grey(size, other);
            overlay_->draw(picture, facts);
        }
    for (const double wrong : {nan, huge, -huge}) {
        facts.time = UtcTime{wrong};
        facts.sun = {wrong, wrong};
        facts.flood = FloodTimes{{wrong}, {0.0}};
        Picture picture = grey(640, 360);
        overlay_->draw(picture, facts);
        facts.flood = FloodTimes{{0.0}, {huge}};
        overlay_->draw(picture, facts);
    }
}
