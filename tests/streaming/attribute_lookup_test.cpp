// Attributes by their usual names, and numbers as people write them.
#include "streaming/features/attribute_lookup.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>

using namespace gnomon;

TEST(AttributeLookup, NamesAreOneHoweverSpelt) {
    EXPECT_EQ(plainText("Höhe (m)"), "hoehem");
    EXPECT_EQ(plainText("HOEHE"), "hoehe");
    EXPECT_EQ(plainText("HÖHE"), "hoehe");
    EXPECT_EQ(plainText("Crown_Width"), "crownwidth");
    EXPECT_EQ(plainText("Straße"), "strasse");
    EXPECT_EQ(plainText("hauteur réelle"), "hauteurreelle");
    EXPECT_EQ(plainText(std::string("\xc3")), "");
}

TEST(AttributeLookup, TheBestNameWinsAndBlankValuesAreNone) {
    constexpr std::array<std::string_view, 3> names{"height", "hoehe", "kronendurchmesser"};
    Feature feature;
    feature.attributes = {{"id", 1.0}, {"hoehe", 2.0}, {"Height", 3.0}};
    EXPECT_EQ(findAttribute(feature, names).name, "Height");
    feature.attributes = {
        {"height", std::monostate()}, {"HEIGHT", std::string("  ")}, {"hoehe_m", 2.0}};
    EXPECT_EQ(findAttribute(feature, names).name, "hoehe_m");
    feature.attributes = {{"kronendurc", 4.0}};
    EXPECT_EQ(findAttribute(feature, names).name, "kronendurc");
    feature.attributes = {{"heights", 4.0}, {"height_class", 2.0}, {"hoehenlinie", 9.0}};
    EXPECT_FALSE(findAttribute(feature, names));
}

TEST(AttributeLookup, NumbersAreReadAsPeopleWriteThem) {
    const std::pair<const char*, double> good[] = {
        {"12.5", 12.5}, {" 12,5 m", 12.5}, {"12m", 12.0},      {"6-9 m", 7.5},
        {"6 – 9", 7.5}, {"10 ft", 3.048},  {"10'", 3.048},     {"250 cm", 2.5},
        {"-3", -3.0},   {"1e2", 100.0},    {"12 Metres", 12.0}};
    for (const auto& [text, value] : good) {
        const auto metres = metresIn(std::string(text));
        ASSERT_TRUE(metres) << text;
        EXPECT_DOUBLE_EQ(*metres, value) << text;
    }
    for (const char* text : {"", "tall", "m", "5-", "5 apples", "nan", "inf", "12 m high", "3 - m"})
        EXPECT_FALSE(metresIn(std::string(text))) << text;
    EXPECT_FALSE(metresIn(AttributeValue(NAN)));
    EXPECT_FALSE(metresIn(AttributeValue(true)));
    EXPECT_EQ(textOf(AttributeValue(2.5)), "2.5");
}
