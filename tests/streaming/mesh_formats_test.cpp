// ANUGA, TELEMAC and TUFLOW FV files written small, for what the published ones do not show.
#include "mesh_flood_support.h"

namespace gnomon {

namespace {

std::shared_ptr<const FloodData> open(const std::string& path, const FloodOptions& options = {}) {
    EXPECT_TRUE(isUnstructuredFlood(path));
    const auto data = openUnstructuredFlood(path, options);
    if (!data)
        throw std::runtime_error(data.error().message());
    return *data;
}

struct SwwSpec {
    std::vector<double> x{0, 100, 100, 0, 100, 0}, y{0, 0, 100, 0, 100, 100};
    std::vector<double> elevation{0, 0, 0, 0, 0, 0};
    bool elevationChanges = false; // then two steps of it are given
    std::vector<double> stage{1, 1, 1, 1, 1, 1, 2, 2, 2, 2, 2, 4};
    std::vector<double> momentum = std::vector<double>(12, 0.5);
    double zone = 56, startTime = 0.0, falseNorthing = 10000000.0;
};

// Two triangles of a square of 100 m that share no corner.
void writeSww(const std::string& path, const SwwSpec& spec) {
    NetCdf file(path);
    file.dimension("number_of_volumes", 2);
    file.dimension("number_of_vertices", 3);
    file.dimension("number_of_points", 6);
    file.dimension("number_of_timesteps", 2);
    file.number("", "xllcorner", 300000.0);
    file.number("", "yllcorner", 6200000.0);
    file.number("", "zone", spec.zone, NC_INT);
    file.number("", "false_northing", spec.falseNorthing);
    file.number("", "starttime", spec.startTime);
    file.text("", "datum", "wgs84");
    const std::vector<std::string> steps{"number_of_timesteps", "number_of_points"};
    file.variable("x", NC_FLOAT, {"number_of_points"});
    file.variable("y", NC_FLOAT, {"number_of_points"});
    file.variable("volumes", NC_INT, {"number_of_volumes", "number_of_vertices"});
    file.variable("time", NC_DOUBLE, {"number_of_timesteps"});
    file.variable("elevation", NC_FLOAT,
                  spec.elevationChanges ? steps : std::vector<std::string>{"number_of_points"});
    for (const char* name : {"stage", "xmomentum", "ymomentum"})
        file.variable(name, NC_FLOAT, steps);
    file.endDefinition();
    file.put("x", spec.x);
    file.put("y", spec.y);
    file.put("volumes", {0, 1, 2, 3, 4, 5});
    file.put("time", {0, 60});
    file.put("elevation", spec.elevation);
    file.put("stage", spec.stage);
    file.put("xmomentum", spec.momentum);
    file.put("ymomentum", std::vector<double>(12, 0.0));
}

// Big- or little-endian records of float or double.
class SelafinWriter {
  public:
    SelafinWriter(bool big, bool twice) : swap_(big), twice_(twice) {}

    void record(const std::string& bytes) {
        integerTo(out_, std::int32_t(bytes.size()));
        out_ += bytes;
        integerTo(out_, std::int32_t(bytes.size()));
    }
    void text(std::string text, std::size_t length) {
        text.resize(length, ' ');
        record(text);
    }
    void integers(const std::vector<std::int32_t>& values) {
        std::string bytes;
        for (const std::int32_t value : values)
            integerTo(bytes, value);
        record(bytes);
    }
    void reals(const std::vector<double>& values) {
        std::string bytes;
        for (const double value : values)
            if (twice_)
                append(bytes, std::bit_cast<std::array<char, 8>>(value));
            else
                append(bytes, std::bit_cast<std::array<char, 4>>(float(value)));
        record(bytes);
    }
    void save(const std::string& path) const {
        std::ofstream(path, std::ios::binary).write(out_.data(), std::streamsize(out_.size()));
    }

  private:
    template <std::size_t N>
    void append(std::string& to, std::array<char, N> bytes) const {
        if (swap_)
            std::reverse(bytes.begin(), bytes.end());
        to.append(bytes.data(), N);
    }
    void integerTo(std::string& to, std::int32_t value) const {
        append(to, std::bit_cast<std::array<char, 4>>(value));
    }
    bool swap_, twice_;
    std::string out_;
};

void writeSelafin(const std::string& path, bool big, bool twice, int planes = 0) {
    SelafinWriter out(big, twice);
    out.text("a square", 80);
    out.integers({2, 0});
    out.text("WATER DEPTH     M", 32);
    out.text("BOTTOM          M", 32);
    // The origin, 290000 and 5050000, is among the parameters.
    out.integers({1, 0, 290000, 5050000, 0, 0, planes, 0, 0, 1});
    out.integers({2021, 7, 14, 18, 30, 0});
    out.integers({2, 4, 3, 1});
    out.integers({1, 2, 3, 1, 3, 4});
    out.integers({1, 2, 3, 4});
    out.reals({0, 100, 100, 0});
    out.reals({0, 0, 100, 100});
    for (const double step : {0.0, 1.0}) {
        out.reals({600.0 * step});
        out.reals({1 + step, 1 + step, 1 + step, 1 + step});
        out.reals({7, 7, 7, 7});
    }
    out.save(path);
}

} // namespace

TEST(Sww, CornersAtOnePlaceAreOneNode) {
    const TemporaryFolder folder;
    writeSww(folder / "a.sww", {});
    const auto data = open(folder / "a.sww");
    EXPECT_EQ(data->crs, "EPSG:32756");
    EXPECT_EQ(data->kind(), WaterKind::Stage);
    EXPECT_EQ(data->geometry().lonLat.size(), 4u);
    EXPECT_EQ(data->geometry().triangles.size(), 2u);
    const double square = sumsOf(*data, 0).cellArea;
    EXPECT_NEAR(sumsOf(*data, 0).volume, square, square * 1e-5);
    // One corner of six has 4 m, the others 2.
    EXPECT_NEAR(sumsOf(*data, 1).volume, square * (2.0 + 2.0 / 6.0), square * 1e-5);
    const auto velocities = data->velocities(0);
    ASSERT_TRUE(velocities);
    EXPECT_NEAR(glm::length((*velocities)[0]), 0.5, 1e-5); // momentum over depth
}

TEST(Sww, WhereTheGroundJumpsTheTrianglesHaveTheValues) {
    const TemporaryFolder folder;
    SwwSpec spec;
    spec.elevation = {0, 0, 0, 3, 3, 3};
    spec.stage = {1, 1, 1, 3, 3, 3, 2, 2, 2, 3.5, 3.5, 3.5};
    writeSww(folder / "a.sww", spec);
    const auto data = open(folder / "a.sww");
    const auto first = data->values(0), second = data->values(1);
    ASSERT_TRUE(first && second);
    EXPECT_FLOAT_EQ((*first)[0], 1.0f);
    EXPECT_TRUE(std::isnan((*first)[1])); // dry, a step higher
    EXPECT_FLOAT_EQ((*second)[1], 3.5f);
    const MeshSums sums = sumsOf(*data, 1);
    EXPECT_NEAR(sums.volume, sums.cellArea * (2.0 + 0.5) / 2.0, sums.cellArea * 1e-5);
}

TEST(Sww, GroundThatChangesGivesDepthsAboveThatOfTheirStep) {
    const TemporaryFolder folder;
    SwwSpec spec;
    spec.elevationChanges = true;
    spec.elevation = {0, 0, 0, 0, 0, 0, 0.5, 0.5, 0.5, 0.5, 0.5, 0.5};
    spec.stage = std::vector<double>(12, 2.0);
    writeSww(folder / "a.sww", spec);
    const auto data = open(folder / "a.sww");
    EXPECT_EQ(data->kind(), WaterKind::Depth);
    EXPECT_FALSE(data->notes.empty());
    EXPECT_NEAR(sumsOf(*data, 0).maxDepth, 2.0, 1e-6);
    EXPECT_NEAR(sumsOf(*data, 1).maxDepth, 1.5, 1e-6);
}

TEST(Sww, TheZoneTheStartAndTheHemisphereAreTaken) {
    const TemporaryFolder folder;
    SwwSpec spec;
    spec.falseNorthing = 0.0;
    spec.startTime = 1626285600.0;
    writeSww(folder / "north.sww", spec);
    const auto data = open(folder / "north.sww");
    EXPECT_EQ(data->crs, "EPSG:32656");
    EXPECT_TRUE(data->stepsAreAbsolute());
    EXPECT_EQ(formatUtc({data->stepSeconds()[1]}), "2021-07-14T18:01:00Z");
    spec.zone = -1;
    writeSww(folder / "nowhere.sww", spec);
    EXPECT_FALSE(openUnstructuredFlood(folder / "nowhere.sww", {}));
}

TEST(Selafin, EitherPrecisionAndByteOrderReadTheSame) {
    const TemporaryFolder folder;
    FloodOptions options;
    options.crs = "EPSG:32633";
    for (const bool big : {true, false})
        for (const bool twice : {true, false}) {
            writeSelafin(folder / "a.slf", big, twice);
            const auto data = open(folder / "a.slf", options);
            EXPECT_EQ(data->kind(), WaterKind::Depth);
            EXPECT_EQ(formatUtc({data->stepSeconds().at(1)}), "2021-07-14T18:40:00Z");
            EXPECT_EQ(data->geometry().lonLat.size(), 4u);
            EXPECT_FLOAT_EQ(data->geometry().bed.at(2), 7.0f);
            const MeshSums sums = sumsOf(*data, 1);
            EXPECT_NEAR(sums.volume, 2.0 * sums.cellArea, 1e-6 * sums.cellArea);
            EXPECT_NEAR(sums.cellArea, 10000.0, 50.0);
            EXPECT_NEAR(data->geometry().lonLat[0].y, 45.57, 0.05); // the origin counts
        }
}

TEST(Selafin, ThreeDimensionsAndMissingVariablesAreNamed) {
    const TemporaryFolder folder;
    FloodOptions options;
    options.crs = "EPSG:32633";
    writeSelafin(folder / "3d.slf", true, false, 10);
    const auto deep = openUnstructuredFlood(folder / "3d.slf", options);
    ASSERT_FALSE(deep);
    EXPECT_NE(deep.error().reason.find("10 planes"), std::string::npos);
    writeSelafin(folder / "a.slf", true, false);
    options.kind = WaterKind::Stage;
    const auto stage = openUnstructuredFlood(folder / "a.slf", options);
    ASSERT_FALSE(stage);
    EXPECT_NE(stage.error().reason.find("WATER DEPTH, BOTTOM"), std::string::npos);
}

TEST(TuflowFv, ItsOwnLayoutIsRead) {
    const TemporaryFolder folder;
    {
        NetCdf file(folder / "tuflow.nc");
        file.dimension("Time", 2);
        file.dimension("NumCells2D", 2);
        file.dimension("NumVert2D", 6);
        file.dimension("MaxNumCellVert", 4);
        file.variable("ResTime", NC_DOUBLE, {"Time"});
        file.text("ResTime", "units", "hours");
        file.variable("cell_node", NC_INT, {"NumCells2D", "MaxNumCellVert"});
        file.variable("cell_Zb", NC_FLOAT, {"NumCells2D"});
        file.variable("node_X", NC_DOUBLE, {"NumVert2D"});
        file.variable("node_Y", NC_DOUBLE, {"NumVert2D"});
        file.variable("H", NC_FLOAT, {"Time", "NumCells2D"});
        file.variable("D", NC_FLOAT, {"Time", "NumCells2D"});
        file.endDefinition();
        file.put("ResTime", {0, 1.5});
        file.put("cell_node", {1, 2, 5, 4, 2, 3, 5, 0}); // from 1, zeros fill up
        file.put("cell_Zb", {1, 2});
        file.put("node_X", {290000, 290010, 290020, 290000, 290010, 290020});
        file.put("node_Y", {5050000, 5050000, 5050000, 5050010, 5050010, 5050010});
        file.put("H", {3, 3, 4, 4});
        file.put("D", {2, 1, 3, 2});
    }
    FloodOptions options;
    options.crs = "EPSG:32633";
    const auto data = open(folder / "tuflow.nc", options);
    EXPECT_EQ(data->kind(), WaterKind::Stage);
    EXPECT_EQ(data->stepSeconds(), (std::vector<double>{0.0, 5400.0}));
    const MeshSums sums = sumsOf(*data, 0);
    EXPECT_NEAR(sums.cellArea, 150.0, 0.5);
    EXPECT_NEAR(sums.volume / sums.cellArea, (100.0 * 2 + 50.0 * 1) / 150.0, 1e-5);
}

} // namespace gnomon
