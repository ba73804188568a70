#include "bench/plot.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>

using namespace gnomon::bench;

namespace {

std::size_t countOf(const std::string& text, const std::string& what) {
    std::size_t count = 0;
    for (std::size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1))
        ++count;
    return count;
}

// Tags that open and close in order, attributes in quotes, no stray "<" or "&".
void expectWellFormed(const std::string& xml) {
    std::vector<std::string> open;
    for (std::size_t at = 0; at < xml.size(); ++at) {
        if (xml[at] == '&') {
            const std::size_t end = xml.find(';', at);
            ASSERT_LT(end - at, 6u) << xml.substr(at, 20);
        }
        if (xml[at] != '<') {
            ASSERT_NE(xml[at], '\0');
            continue;
        }
        const std::size_t end = xml.find('>', at);
        ASSERT_NE(end, std::string::npos);
        const std::string tag = xml.substr(at + 1, end - at - 1);
        ASSERT_EQ(tag.find('<'), std::string::npos) << tag;
        ASSERT_EQ(countOf(tag, "\"") % 2, 0u) << tag;
        const std::string name = tag.substr(0, tag.find(' '));
        if (name.front() == '/') {
            ASSERT_FALSE(open.empty());
            ASSERT_EQ(open.back(), name.substr(1));
            open.pop_back();
        } else if (tag.back() != '/') {
            open.push_back(name);
        }
        at = end;
    }
    EXPECT_TRUE(open.empty());
}

std::vector<PlotPoint> rows() {
    return {{"csm+receiver-plane+pcss:16,32", 150, 2e-4, 1e-3},
            {"csm+none", 80, 3e-3, 4e-3},
            {"slow & worse", 200, 5e-3, 9e-3},
            {"single<fast>", 60, 2e-2, 2e-2},
            {"perfect", 190, 0.0, 0.0}};
}

} // namespace

TEST(Plot, IsWellFormedWithAPointARowInEachPanel) {
    const std::string svg = plotSvg({"time & \"error\"", "here", 900000}, rows());
    expectWellFormed(svg);
    EXPECT_EQ(countOf(svg, "<circle"), 2 * rows().size());
    EXPECT_EQ(countOf(svg, "class=\"name\""), 2 * rows().size());
    EXPECT_EQ(countOf(svg, "class=\"point best\""), 8u); // all but the slow one, twice
    EXPECT_NE(svg.find("single&lt;fast&gt;"), std::string::npos);
    EXPECT_NE(svg.find("prefers-color-scheme: dark"), std::string::npos);
    EXPECT_EQ(svg.find("nan"), std::string::npos);
    EXPECT_EQ(svg.find("inf"), std::string::npos);
}

TEST(Plot, StandsWithoutRowsWithOneAndWithManyAtOnePlace) {
    expectWellFormed(plotSvg({}, {}));
    const std::vector<PlotPoint> one{{"only", 5.0, 0.0, 0.0}};
    expectWellFormed(plotSvg({"", "", 100}, one));
    const std::vector<PlotPoint> many(40, {"csm+receiver-plane+pcss:16,32", 5.0, 1e-3, 1e-3});
    const std::string svg = plotSvg({"", "", 100}, many);
    expectWellFormed(svg);
    EXPECT_EQ(countOf(svg, "<circle"), 80u);
    EXPECT_EQ(svg.find("nan"), std::string::npos);
}

TEST(Plot, TheFrontIsWhatNothingBeats) {
    const std::vector<double> time{10, 20, 30, 40, 20, 50}, error{5, 3, 4, 1, 2, 1};
    EXPECT_EQ(paretoFront(time, error), (std::vector<std::size_t>{0, 4, 3}));
    EXPECT_TRUE(paretoFront({}, {}).empty());
}

// Each name's box, as the drawing says it is.
TEST(Plot, NamesDoNotOverlapWhereThereIsRoom) {
    std::vector<PlotPoint> points;
    for (int i = 0; i < 14; ++i)
        points.push_back({"csm+receiver-plane+pcf:" + std::to_string(i % 10), 100.0 + 7.0 * (i % 4),
                          1e-3 * (1 + i % 3), 1e-3 * (1 + i)});
    const std::string svg = plotSvg({"", "", 900000}, points);
    struct Box {
        double x, y, width;
    };
    std::vector<Box> boxes;
    const auto number = [&](std::size_t from, const char* name) {
        return std::stod(svg.substr(svg.find(name, from) + std::string(name).size()));
    };
    const std::size_t second = svg.find("id=\"mae\"");
    for (std::size_t at = svg.find("class=\"name\""); at < second;
         at = svg.find("class=\"name\"", at + 1))
        boxes.push_back({number(at, " x=\""), number(at, " y=\""), number(at, "textLength=\"")});
    ASSERT_EQ(boxes.size(), points.size());
    for (std::size_t i = 0; i < boxes.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) {
            const bool apart = std::abs(boxes[i].y - boxes[j].y) > 11.0 ||
                               boxes[i].x > boxes[j].x + boxes[j].width ||
                               boxes[j].x > boxes[i].x + boxes[i].width;
            EXPECT_TRUE(apart) << i << " and " << j;
        }
}
