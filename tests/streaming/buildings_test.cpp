#include "buildings_support.h"

namespace gnomon::test {
namespace {

constexpr double kDepth = 1.0; // how far bodies reach into the ground

TEST(Buildings, AreAsLargeAsTheirOutlineTimesTheirHeight) {
    FeatureRing hole = box(10, 10, 5, 5);
    const auto buildings =
        buildingsOf({feature(FeatureShape::Polygon, {box(0, 0, 40, 20), hole}, {{"height", 12.0}})},
                    flatGround(50.0));
    ASSERT_TRUE(buildings);
    const Measured m = measured(*buildings);
    EXPECT_EQ(m.closed, m.triangles) << "with its underside it is a solid";
    EXPECT_EQ(m.triangles, 2 * 8u + 2 * 8u); // walls; roof and underside of 8 vertices, one hole
    EXPECT_NEAR(m.volume, (40.0 * 20.0 - 25.0) * (12.0 + kDepth), 1.0);
    EXPECT_NEAR(m.highest, 62.0, 1e-3);
    EXPECT_NEAR(m.lowest, 50.0 - kDepth, 1e-3);
}

TEST(Buildings, AreSolidHoweverTheirRingsRun) {
    FeatureRing outer = box(0, 0, 20, 20), hole = box(5, 5, 5, 5);
    for (int turn = 0; turn < 4; ++turn) {
        FeaturePart part{outer, hole};
        if (turn & 1)
            std::reverse(part[0].begin(), part[0].end());
        if (turn & 2)
            std::reverse(part[1].begin(), part[1].end());
        const auto buildings =
            buildingsOf({feature(FeatureShape::Polygon, part, {{"height", 9.0}})}, flatGround(0.0));
        const Measured m = measured(*buildings);
        EXPECT_EQ(m.closed, m.triangles);
        EXPECT_NEAR(m.volume, 375.0 * 10.0, 0.5);
    }
}

TEST(Buildings, StaySolidWhereTheyShareWalls) {
    std::vector<Feature> row;
    for (int i = 0; i < 6; ++i) // of different heights, some half a wall apart
        row.push_back(feature(FeatureShape::Polygon, {box(10.0 * i, i % 2 ? 0.0 : 5.0, 10, 10)},
                              {{"height", 6.0 + i % 3}}));
    const Measured m = measured(*buildingsOf(row, flatGround(10.0)));
    EXPECT_EQ(m.triangles, 6 * 12u);
    EXPECT_EQ(m.closed, m.triangles);
}

TEST(Buildings, MendOutlinesThatCrossThemselves) {
    const FeatureRing bow{at(0, 0), at(20, 20), at(20, 0), at(0, 20)};
    const auto buildings =
        buildingsOf({feature(FeatureShape::Polygon, {bow}, {{"height", 9.0}})}, flatGround(0.0));
    ASSERT_TRUE(buildings);
    EXPECT_TRUE(says(buildings->file().notes, "0: its outline crosses itself; mended"));
    const Measured m = measured(*buildings);
    EXPECT_EQ(m.closed, m.triangles);
    EXPECT_NEAR(m.volume, 200.0 * 10.0, 2.0);
}

TEST(Buildings, WithoutAreaAreLeftOutByName) {
    const FeatureRing line{at(0, 0), at(20, 20), at(0, 0)}, dot{at(0, 0), at(0, 0), at(0, 0)};
    const auto buildings =
        buildingsOf({feature(FeatureShape::Polygon, {line}), feature(FeatureShape::Polygon, {dot}),
                     feature(FeatureShape::Polygon, {box(0, 0, 9, 9)}),
                     feature(FeatureShape::Point, {{at(0, 0)}})},
                    flatGround(0.0));
    ASSERT_TRUE(buildings);
    EXPECT_EQ(buildings->size(), 1u);
    EXPECT_TRUE(says(buildings->file().leftOut, "test, 0: its outline has no area"));
    EXPECT_TRUE(says(buildings->file().leftOut, "test, 1: its outline has no area"));
    EXPECT_TRUE(says(buildings->file().notes, "1 points and lines are no outlines"));
    const auto none =
        Buildings::of(fileOf({feature(FeatureShape::Polygon, {dot})}), "test", {}, flatGround(0.0));
    ASSERT_FALSE(none);
    EXPECT_NE(none.error().message().find("no area"), std::string::npos);
    EXPECT_FALSE(Buildings::of({}, "test", {}, nullptr));
}

TEST(Buildings, TangledBeyondUseAreLeftOutSoon) {
    FeatureRing tangle;
    std::uint32_t seed = 3;
    for (int i = 0; i < 3000; ++i) {
        seed = seed * 1664525u + 1013904223u;
        tangle.push_back(at(double(seed >> 20), double(seed >> 8 & 4095)));
    }
    const auto buildings = buildingsOf({feature(FeatureShape::Polygon, {tangle}),
                                        feature(FeatureShape::Polygon, {box(0, 0, 9, 9)})},
                                       flatGround(0.0));
    ASSERT_TRUE(buildings);
    EXPECT_EQ(buildings->size(), 1u);
    EXPECT_TRUE(says(buildings->file().leftOut, "crosses itself too often"));
}

// What the tops of one building of these attributes are, on ground at 100 m.
struct Height {
    double top = 0.0;
    bool assumed = false;
};
Height heightOf(Attributes attributes, const BuildingOptions& options = {}) {
    const auto buildings =
        buildingsOf({feature(FeatureShape::Polygon, {box(0, 0, 9, 9)}, std::move(attributes))},
                    flatGround(100.0), options);
    const BuildingFound found = buildings->building(0);
    return {found.topMetres - found.groundMetres, found.heightAssumed};
}

TEST(BuildingHeights, AreFoundUnderTheirUsualNames) {
    EXPECT_DOUBLE_EQ(heightOf({{"height", 12.5}}).top, 12.5);
    EXPECT_DOUBLE_EQ(heightOf({{"building:height", std::string("12,5 m")}}).top, 12.5);
    EXPECT_DOUBLE_EQ(heightOf({{"HEIGHT", std::string("40 ft")}}).top, 12.192);
    EXPECT_DOUBLE_EQ(heightOf({{"Höhe (m)", 7.0}}).top, 7.0);
    EXPECT_DOUBLE_EQ(heightOf({{"measuredHeight", 7.0}}).top, 7.0);
    EXPECT_DOUBLE_EQ(heightOf({{"HAUTEUR", 7.0}}).top, 7.0);
    EXPECT_DOUBLE_EQ(heightOf({{"height_ft", 10.0}}).top, 3.048);
    EXPECT_DOUBLE_EQ(heightOf({{"building:levels", std::string("4")}}).top, 12.0);
    EXPECT_DOUBLE_EQ(heightOf({{"num_floors", 2.0}}).top, 6.0);
    EXPECT_DOUBLE_EQ(heightOf({{"num_floors", 2.0}, {"height", 7.0}}).top, 7.0) << "the better";
    EXPECT_DOUBLE_EQ(heightOf({{"b3_h_dak_70p", 14.5}, {"b3_h_maaiveld", 2.0}}).top, 12.5)
        << "levels of the sea, of roof and ground";
    EXPECT_FALSE(heightOf({{"height", 12.5}}).assumed);
}

TEST(BuildingHeights, AreTheStatedOnesElseAssumed) {
    EXPECT_DOUBLE_EQ(heightOf({}).top, 6.0);
    EXPECT_TRUE(heightOf({}).assumed);
    EXPECT_TRUE(heightOf({{"height", 0.0}}).assumed);
    EXPECT_TRUE(heightOf({{"height", 9999.0}}).assumed);
    EXPECT_TRUE(heightOf({{"height", std::string("high")}}).assumed);
    EXPECT_TRUE(heightOf({{"b3_h_dak_70p", 14.5}}).assumed) << "above the sea, not the ground";
    BuildingOptions options;
    options.heightMetres = 4.5;
    EXPECT_DOUBLE_EQ(heightOf({}, options).top, 4.5);
    EXPECT_TRUE(heightOf({}, options).assumed);
    EXPECT_DOUBLE_EQ(heightOf({{"height", 8.0}}, options).top, 8.0);
    options.heightAttribute = "eaves";
    EXPECT_DOUBLE_EQ(heightOf({{"height", 8.0}, {"EAVES", 3.0}}, options).top, 3.0);
    EXPECT_DOUBLE_EQ(heightOf({{"height", 8.0}, {"eaves", std::monostate()}}, options).top, 4.5);
    const auto buildings =
        buildingsOf({feature(FeatureShape::Polygon, {box(0, 0, 9, 9)}),
                     feature(FeatureShape::Polygon, {box(20, 0, 9, 9)}, {{"height", 8.0}}),
                     feature(FeatureShape::Polygon, {box(40, 0, 9, 9)}, {{"height", -1.0}})},
                    flatGround(0.0));
    EXPECT_TRUE(says(buildings->file().notes, "heights from height (1)"));
    EXPECT_TRUE(says(buildings->file().notes, "2 of 3 buildings have no height: 6.0 m assumed"));
    EXPECT_TRUE(says(buildings->file().notes, "1 heights that no building has"));
}

TEST(BuildingHeights, AskedForByANameThatNothingHasAreAnError) {
    BuildingOptions options;
    options.heightAttribute = "tallness";
    const auto made = Buildings::of(
        fileOf({feature(FeatureShape::Polygon, {box(0, 0, 9, 9)}, {{"height", 8.0}})}), "test",
        options, flatGround(0.0));
    ASSERT_FALSE(made);
    EXPECT_NE(made.error().message().find("'tallness': they have height"), std::string::npos);
    EXPECT_EQ(made.error().kind, ErrorKind::Usage);
}

TEST(BuildingHeights, OfPartsBeginAboveTheGround) {
    const auto buildings = buildingsOf({feature(FeatureShape::Polygon, {box(0, 0, 10, 10)},
                                                {{"height", 30.0}, {"min_height", 20.0}})},
                                       flatGround(5.0));
    const Measured m = measured(*buildings);
    EXPECT_NEAR(m.lowest, 25.0, 1e-3);
    EXPECT_NEAR(m.highest, 35.0, 1e-3);
}

TEST(BuildingsOnASlope, ReachIntoTheGroundEverywhere) {
    const auto ground = test::ground(slope);
    // Lowest at (0, 20), highest at (40, 0).
    const double lowest = slope({0, 20}), mean = slope({20, 10});
    const auto stated = buildingsOf(
        {feature(FeatureShape::Polygon, {box(0, 0, 40, 20)}, {{"height", 12.0}})}, ground);
    const BuildingFound found = stated->building(0);
    EXPECT_NEAR(found.groundMetres, lowest, 0.01);
    EXPECT_NEAR(found.topMetres, lowest + 12.0, 0.01) << "from the lowest ground";
    EXPECT_NEAR(measured(*stated).lowest, lowest - kDepth, 0.01);
    const auto assumed = buildingsOf({feature(FeatureShape::Polygon, {box(0, 0, 40, 20)})}, ground);
    EXPECT_NEAR(assumed->building(0).topMetres, mean + 6.0, 0.3) << "from the mean";
}

TEST(BuildingsWhoseVerticesHaveHeights, TakeThemForTheRoofOrTheGround) {
    const auto one = [](double z, Attributes attributes,
                        const std::shared_ptr<const GroundHeights>& ground) {
        return buildingsOf(
                   {feature(FeatureShape::Polygon, {box(0, 0, 9, 9, z)}, std::move(attributes))},
                   ground)
            ->building(0);
    };
    const auto ground = flatGround(100.0);
    EXPECT_NEAR(one(109.0, {}, ground).topMetres, 109.0, 1e-9) << "a roof: it is high up";
    EXPECT_FALSE(one(109.0, {}, ground).heightAssumed);
    EXPECT_NEAR(one(100.5, {}, ground).topMetres, 106.5, 1e-9) << "the ground";
    EXPECT_NEAR(one(109.0, {{"height", 10.0}}, ground).topMetres, 109.0, 1e-9);
    EXPECT_NEAR(one(101.0, {{"height", 10.0}}, ground).topMetres, 111.0, 1e-9);
    EXPECT_NEAR(one(109.0, {{"height", 10.0}}, nullptr).topMetres, 119.0, 1e-9);
    EXPECT_NEAR(one(109.0, {{"height", 10.0}}, nullptr).groundMetres, 109.0, 1e-9);
}

TEST(BuildingsWithoutGround, StandOnTheNearestThereIs) {
    const auto east = test::ground([](glm::dvec2 p) { return p.x > 100.0 ? 30.0 + p.y : NAN; });
    const auto buildings = buildingsOf({feature(FeatureShape::Polygon, {box(0, 0, 9, 9)}),
                                        feature(FeatureShape::Polygon, {box(200, 0, 9, 9)}),
                                        feature(FeatureShape::Polygon, {box(200, 500, 9, 9)})},
                                       east);
    EXPECT_NEAR(buildings->building(0).groundMetres, 30.0, 0.1);
    EXPECT_TRUE(says(buildings->file().notes, "1 buildings stand where the ground has no height"));
    for (const auto& none : {std::shared_ptr<const GroundHeights>(), flatGround(NAN)}) {
        const auto lost = buildingsOf({feature(FeatureShape::Polygon, {box(0, 0, 9, 9)})}, none);
        EXPECT_EQ(lost->building(0).groundMetres, 0.0);
        EXPECT_EQ(lost->building(0).topMetres, 6.0);
        EXPECT_TRUE(says(lost->file().notes, "no ground is known: 1 buildings stand at 0 m"));
    }
}

TEST(BuildingsInSpace, AreWarnedOfWhenTheyFloat) {
    FeaturePart roof{box(0, 0, 9, 9, 150.0)};
    Feature floating = feature(FeatureShape::Surface, roof);
    const auto buildings = buildingsOf({floating}, flatGround(100.0));
    EXPECT_TRUE(says(buildings->file().notes, "begin 50.0 m above the ground"));
    EXPECT_NEAR(buildings->building(0).topMetres, 150.0, 1e-9) << "they stay where they are";
}

TEST(Outlines, ThatAreThereTwiceAreShownOnce) {
    FeatureRing turned = box(0, 0, 9, 9);
    std::rotate(turned.begin(), turned.begin() + 2, turned.end());
    const auto buildings = buildingsOf({feature(FeatureShape::Polygon, {box(0, 0, 9, 9)}),
                                        feature(FeatureShape::Polygon, {turned}),
                                        feature(FeatureShape::Polygon, {box(20, 0, 9, 9)})},
                                       flatGround(0.0));
    EXPECT_EQ(buildings->size(), 2u);
    EXPECT_TRUE(says(buildings->file().notes, "1: the same outline is there twice"));
}

TEST(Outlines, ThatTheirPartsCoverGiveWay) {
    const auto buildings = buildingsOf({feature(FeatureShape::Polygon, {box(0, 0, 20, 10)}),
                                        feature(FeatureShape::Polygon, {box(0, 0, 10, 10)}),
                                        feature(FeatureShape::Polygon, {box(10, 0, 10, 10)}),
                                        // A tower on its own base does not cover it.
                                        feature(FeatureShape::Polygon, {box(100, 0, 20, 20)}),
                                        feature(FeatureShape::Polygon, {box(105, 5, 9, 9)})},
                                       flatGround(0.0));
    EXPECT_EQ(buildings->size(), 4u);
    EXPECT_EQ(buildings->building(0).id, "1");
    EXPECT_TRUE(says(buildings->file().notes, "0: smaller outlines cover it wholly"));
}

TEST(Outlines, LargerThanAnyBuildingAreSaid) {
    const auto buildings =
        buildingsOf({feature(FeatureShape::Polygon, {box(0, 0, 1100, 1100)})}, flatGround(0.0));
    EXPECT_TRUE(says(buildings->file().notes, "larger than any building"));
}

} // namespace
} // namespace gnomon::test
