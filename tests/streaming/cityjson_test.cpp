#include "buildings_support.h"

namespace gnomon::test {
namespace {

// A cube of 10 m at (400000, 5600000) in UTM zone 32, its vertices in millimetres.
const std::string kVertices = R"([[0,0,0],[10000,0,0],[10000,10000,0],[0,10000,0],
    [0,0,10000],[10000,0,10000],[10000,10000,10000],[0,10000,10000]])";
const std::string kCube = R"([[[[0,3,2,1]],[[4,5,6,7]],[[0,1,5,4]],[[1,2,6,5]],[[2,3,7,6]],
    [[3,0,4,7]]]])";
const std::string kHead = R"("type":"CityJSON","version":"2.0",
    "transform":{"scale":[0.001,0.001,0.001],"translate":[400000,5600000,50]})";
const std::string kUtm =
    R"("metadata":{"referenceSystem":"https://www.opengis.net/def/crs/EPSG/0/25832"})";

std::string city(const std::string& objects, const std::string& metadata = kUtm) {
    return "{" + kHead + "," + metadata + R"(,"CityObjects":{)" + objects + R"(},"vertices":)" +
           kVertices + "}";
}
std::string solid(const std::string& lod, const std::string& boundaries = kCube) {
    return R"({"type":"Solid","lod":)" + lod + R"(,"boundaries":)" + boundaries + "}";
}
std::string building(const std::string& id, const std::string& geometry,
                     const std::string& more = "", const std::string& type = "Building") {
    return "\"" + id + R"(":{"type":")" + type + "\"" + more + R"(,"geometry":[)" + geometry + "]}";
}

Result<FeatureFile> read(const std::string& text, const FeatureOptions& options = {}) {
    const Folder folder;
    return readFeatures(folder.write("a.json", text), options);
}

TEST(CityJson, GivesSolidsAsClosedBodies) {
    const Folder folder;
    const auto opened =
        Buildings::open(folder.write("a.json", city(building("b", solid("\"1\"")))), {}, nullptr);
    ASSERT_TRUE(opened) << opened.error().message();
    ASSERT_EQ((*opened)->size(), 1u);
    EXPECT_EQ((*opened)->file().crs, "EPSG:25832");
    EXPECT_EQ((*opened)->file().format, "CityJSON");
    const Measured m = measured(**opened);
    EXPECT_EQ(m.triangles, 12u);
    EXPECT_EQ(m.closed, 12u);
    // UTM's scale at this place: 0.9996 at the central meridian, a little more away from it.
    EXPECT_NEAR(m.volume, 1000.0 / (0.99972 * 0.99972), 0.1);
    EXPECT_NEAR(m.lowest, 50.0, 1e-3);
    EXPECT_NEAR(m.highest, 60.0, 1e-3);
}

TEST(CityJson, GetsTheUndersideThatItLacks) {
    const std::string open = R"([[[[4,5,6,7]],[[0,1,5,4]],[[1,2,6,5]],[[2,3,7,6]],[[3,0,4,7]]]])";
    const std::string noRoof = R"([[[[0,3,2,1]],[[0,1,5,4]],[[1,2,6,5]],[[2,3,7,6]],[[3,0,4,7]]]])";
    const Folder folder;
    const auto made = [&](const std::string& boundaries) {
        return measured(**Buildings::open(
            folder.write("a.json", city(building("b", solid("1", boundaries)))), {}, nullptr));
    };
    EXPECT_EQ(made(open).closed, 12u);
    EXPECT_EQ(made(noRoof).triangles, 10u) << "what is high up stays open";
    EXPECT_EQ(made(noRoof).closed, 0u);
}

TEST(CityJson, IsReadAtTheHighestDetail) {
    const std::string one = R"([[[[0,3,2,1]],[[4,5,6,7]]]])";
    const auto file = read(city(
        building("b", solid("\"1.2\"", one) + "," + solid("\"2.2\"") + "," + solid("1.3", one))));
    ASSERT_TRUE(file) << file.error().message();
    EXPECT_EQ(file->features.at(0).parts.size(), 6u);
    EXPECT_EQ(file->features[0].shape, FeatureShape::Surface);
}

TEST(CityJson, PartsBelongToTheirBuilding) {
    const std::string footprint = R"({"type":"MultiSurface","lod":"0","boundaries":[[[0,1,2,3]]]})";
    const auto file = read(city(
        building("b", footprint, R"(,"attributes":{"year":1900,"height":9},"children":["p","q"])") +
        "," +
        building("p", solid("\"2\""), R"(,"attributes":{"roof":"flat","year":1}, "parents":["b"])",
                 "BuildingPart") +
        "," + building("q", solid("\"2\""), R"(,"parents":["b"])", "BuildingInstallation")));
    ASSERT_TRUE(file) << file.error().message();
    ASSERT_EQ(file->features.size(), 1u);
    const Feature& b = file->features[0];
    EXPECT_EQ(b.id, "b");
    EXPECT_EQ(b.shape, FeatureShape::Surface);
    EXPECT_EQ(b.parts.size(), 12u) << "the footprint is the same building once more";
    EXPECT_EQ(b.number("year"), 1900.0);
    EXPECT_EQ(std::get<std::string>(*b.attribute("roof")), "flat");
}

TEST(CityJson, FootprintsAloneArePutUp) {
    const auto file =
        read(city(building("b", R"({"type":"MultiSurface","lod":"0","boundaries":[[[0,1,2,3]]]})",
                           R"(,"attributes":{"measuredHeight":7})")));
    ASSERT_TRUE(file);
    EXPECT_EQ(file->features[0].shape, FeatureShape::Polygon);
}

TEST(CityJson, KnowsItsSystemHoweverItIsWritten) {
    for (const char* name :
         {"urn:ogc:def:crs:EPSG::25832", "http://www.opengis.net/def/crs/EPSG/0/25832",
          "EPSG:25832", "urn:ogc:def:crs:EPSG:9.9:25832"}) {
        const auto file =
            read(city(building("b", solid("1")),
                      R"("metadata":{"referenceSystem":")" + std::string(name) + "\"}"));
        ASSERT_TRUE(file) << name << ": " << file.error().message();
        EXPECT_EQ(file->crs, "EPSG:25832");
    }
    const auto without = read(city(building("b", solid("1")), R"("metadata":{})"));
    ASSERT_FALSE(without);
    EXPECT_NE(without.error().message().find("--crs EPSG:n"), std::string::npos);
}

TEST(CityJson, SaysWhichObjectsAreNoBuildings) {
    const auto file = read(city(
        building("b", solid("1")) + "," + building("r", solid("1"), "", "Road") + "," +
        building("s", solid("1"), "", "Road") + "," + building("t", solid("1"), "", "TINRelief")));
    ASSERT_TRUE(file);
    EXPECT_EQ(file->features.size(), 1u);
    EXPECT_TRUE(says(file->notes, "left out: 2 Road, 1 TINRelief"));
}

TEST(CityJson, HolesAndManySolidsAreKept) {
    const auto file = read(city(building("b", R"({"type":"MultiSolid","lod":"2","boundaries":[)" +
                                                  kCube + "," + kCube + R"(]})") +
                                "," + building("c", R"({"type":"CompositeSurface","lod":"2",
                                    "boundaries":[[[0,1,2,3],[4,5,6]]]})")));
    ASSERT_TRUE(file) << file.error().message();
    EXPECT_EQ(file->features.at(0).parts.size(), 12u);
    EXPECT_EQ(file->features.at(1).parts.at(0).size(), 2u);
}

TEST(CityJson, IsReadInLines) {
    const std::string line = R"({"type":"CityJSONFeature","id":"b","CityObjects":{)" +
                             building("b", R"({"type":"Solid","lod":1,"boundaries":)" +
                                               std::string("[[[[0,3,2,1]],[[4,5,6,7]]]]") + "}") +
                             R"(},"vertices":[[0,0,0],[10000,0,0],[10000,10000,0],[0,10000,0],
                              [0,0,10000],[10000,0,10000],[10000,10000,10000],[0,10000,10000]]})";
    std::string flat;
    for (const char c : line)
        flat += c == '\n' ? ' ' : c;
    std::string head;
    for (const char c : "{" + kHead + "," + kUtm + R"(,"CityObjects":{},"vertices":[]})")
        head += c == '\n' ? ' ' : c;
    std::string other = flat;
    other.replace(other.find("\"b\":{"), 3, "\"c\"");
    const auto file = read(head + "\n" + flat + "\nnonsense\n" + other + "\n");
    ASSERT_TRUE(file) << file.error().message();
    ASSERT_EQ(file->features.size(), 2u);
    EXPECT_EQ(file->features[1].id, "c");
    EXPECT_TRUE(says(file->leftOut, "line 3: it is not JSON"));
}

TEST(CityJson, ThatLiesIsOneLine) {
    const auto fails = [](const std::string& text, const std::string& reason) {
        const auto file = read(text);
        ASSERT_FALSE(file);
        EXPECT_NE(file.error().message().find(reason), std::string::npos) << file.error().message();
        EXPECT_EQ(file.error().message().find('\n'), std::string::npos);
    };
    fails(city(building("b", solid("1", "[[[[0,1,99]]]]"))), "refers to a vertex that is not");
    fails(city(building("b", solid("1", "[[[[0,1,-1]]]]"))), "refers to a vertex that is not");
    fails(city(building("b", solid("1", "[[7]]"))), "its boundaries are no arrays");
    fails(R"({"type":"CityJSON","CityObjects":{}})", "it has no vertices");
    fails(R"({"type":"CityJSON","CityObjects":7,"vertices":[]})", "it has no CityObjects");
    fails(R"({"type":"CityJSON","CityObjects":{},"vertices":[[0,0]]})", "is not three numbers");
    fails(R"({"type":"CityJSON","CityObjects":{},"vertices":[],"transform":{"scale":1}})",
          "transform");
    fails(R"({"type":"CityJSON","CityObjects":)" + std::string(100000, '['), "deep");
    // Parents and children in a circle.
    const auto circle = read(city(building("b", solid("1"), R"(,"children":["b","c"])") + "," +
                                  building("c", solid("1"), R"(,"children":["b"])")));
    ASSERT_TRUE(circle);
}

TEST(CityJson, CutShortNeverBringsTheReaderDown) {
    const std::string whole = city(building("b", solid("\"2\""), R"(,"attributes":{"a":[1,{}]})"));
    for (std::size_t cut = 0; cut < whole.size(); cut += 3)
        EXPECT_FALSE(read(whole.substr(0, cut)));
}

} // namespace
} // namespace gnomon::test
