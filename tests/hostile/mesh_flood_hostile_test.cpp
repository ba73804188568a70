// Files that are cut off or changed: an error in one line or a result, never a crash.
#include "tests/streaming/mesh_flood_support.h"

#include <random>

namespace gnomon {

namespace {

std::string bytesOf(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

void write(const std::string& path, const std::string& bytes) {
    std::ofstream(path, std::ios::binary).write(bytes.data(), std::streamsize(bytes.size()));
}

// Opens and reads all of it; true when it opened.
bool readAll(const std::string& path) {
    FloodOptions options;
    options.crs = "EPSG:32633";
    isUnstructuredFlood(path);
    const auto opened = openUnstructuredFlood(path, options);
    if (!opened) {
        EXPECT_EQ(opened.error().message().find('\n'), std::string::npos)
            << opened.error().message();
        EXPECT_FALSE(opened.error().reason.empty());
        return false;
    }
    const FloodGeometry& geometry = (*opened)->geometry();
    for (const auto& t : geometry.triangles)
        for (const std::uint32_t node : t)
            EXPECT_LT(node, geometry.lonLat.size());
    for (std::size_t step = 0; step < (*opened)->stepSeconds().size(); ++step) {
        if (const auto values = (*opened)->values(step)) {
            EXPECT_EQ(values->size(), geometry.lonLat.size());
        }
        if ((*opened)->hasVelocity()) {
            if (const auto velocities = (*opened)->velocities(step)) {
                EXPECT_EQ(velocities->size(), geometry.lonLat.size());
            }
        }
    }
    return true;
}

std::string writeSample(const TemporaryFolder& folder, int format) {
    UgridSpec spec = gridSpec(6, 5, 50.0, true);
    spec.velocity = [](glm::dvec2, int) { return glm::dvec2(1.0, 0.5); };
    spec.format = format;
    writeUgrid(folder / "whole.nc", spec);
    return bytesOf(folder / "whole.nc");
}

// Every `stride` bytes, and closer together in the header.
std::size_t openCutOff(const TemporaryFolder& folder, const std::string& name,
                       const std::string& whole, std::size_t stride) {
    std::size_t opened = 0;
    for (std::size_t length = 0; length < whole.size();
         length += length < 300 ? stride / 12 + 1 : stride) {
        write(folder / name, whole.substr(0, length));
        opened += readAll(folder / name);
    }
    return opened;
}

} // namespace

TEST(HostileMeshFlood, ClassicNetCdfCutOffAnywhereIsAnError) {
    const TemporaryFolder folder;
    const std::string whole = writeSample(folder, NC_64BIT_OFFSET);
    // All but the padding after the last array.
    EXPECT_EQ(openCutOff(folder, "cut.nc", whole.substr(0, whole.size() - 4), 101), 0u);
    EXPECT_TRUE(readAll(folder / "whole.nc"));
}

TEST(HostileMeshFlood, NetCdf4CutOffAnywhereIsAnError) {
    const TemporaryFolder folder;
    const std::string whole = writeSample(folder, NC_NETCDF4);
    EXPECT_EQ(openCutOff(folder, "cut.nc", whole, whole.size() / 16 + 1), 0u);
    EXPECT_TRUE(readAll(folder / "whole.nc"));
}

TEST(HostileMeshFlood, RealFilesCutOffAnywhereAreErrorsOrLoseTheirLastStep) {
    const TemporaryFolder folder;
    for (const char* name :
         {"Small_catchment_testcase.sww", "baldeagle_multi2d.hdf", "telemac_example_res_fr.slf"}) {
        if (!std::filesystem::exists(meshData(name)))
            GTEST_SKIP() << "no " << meshData(name);
        const std::string whole = bytesOf(meshData(name));
        const std::string cut = std::string("cut-") + name;
        const std::size_t opened = openCutOff(folder, cut, whole, whole.size() / 16 + 1);
        // A Selafin file without its last step still has the first.
        EXPECT_EQ(opened > 0, std::string(name).ends_with(".slf")) << name;
    }
}

TEST(HostileMeshFlood, ChangedBytesNeverCrash) {
    const TemporaryFolder folder;
    std::mt19937 random(7);
    std::string selafin;
    if (std::filesystem::exists(meshData("telemac_example_res_fr.slf")))
        selafin = bytesOf(meshData("telemac_example_res_fr.slf"));
    const std::string classic = writeSample(folder, NC_64BIT_OFFSET);
    for (int round = 0; round < 250; ++round) {
        std::string bytes = round % 4 == 0 && !selafin.empty() ? selafin : classic;
        for (int i = 0; i < 1 + round % 5; ++i) {
            // Where the counts are.
            const std::size_t reach = std::min<std::size_t>(bytes.size(), 2600);
            bytes[random() % reach] = char(random());
        }
        write(folder / "changed.nc", bytes);
        readAll(folder / "changed.nc");
    }
}

TEST(HostileMeshFlood, SelafinCountsThatLieAreErrors) {
    const TemporaryFolder folder;
    if (!std::filesystem::exists(meshData("telemac_example_res_fr.slf")))
        GTEST_SKIP() << "no Selafin sample";
    const std::string whole = bytesOf(meshData("telemac_example_res_fr.slf"));
    // The mesh's four counts, after title, counts, five names, parameters and date.
    const std::size_t counts = 88 + 16 + 5 * 40 + 48 + 32 + 4;
    for (const std::uint32_t lie : {0u, 1u, 13540u, 13542u, 0x7fffffffu, 0xffffffffu})
        for (const std::size_t which : {0u, 1u, 2u}) {
            std::string bytes = whole;
            for (int i = 0; i < 4; ++i)
                bytes[counts + 4 * which + std::size_t(i)] = char(lie >> (24 - 8 * i));
            write(folder / "lie.slf", bytes);
            EXPECT_FALSE(readAll(folder / "lie.slf")) << which << " " << lie;
        }
}

TEST(HostileMeshFlood, FacesOfNonsenseAreLeftOut) {
    const TemporaryFolder folder;
    UgridSpec spec = gridSpec(4, 4, 50.0, false);
    spec.faces.push_back({0, 1, 1});      // two corners
    spec.faces.push_back({0, 1, 2});      // on a line
    spec.faces.push_back({0, 1, 999999}); // no such point
    spec.faces.push_back({0, 0, 0, 0});   // a point
    spec.faces.push_back({12, 11, 6, 7}); // upside down, over another
    writeUgrid(folder / "faces.nc", spec);
    EXPECT_TRUE(readAll(folder / "faces.nc"));
    for (glm::dvec2& point : spec.points)
        point = glm::dvec2(std::nan(""), 0.0);
    writeUgrid(folder / "nowhere.nc", spec);
    EXPECT_FALSE(readAll(folder / "nowhere.nc"));
}

TEST(HostileMeshFlood, CountsBeyondTheFileAreRefusedBeforeTheyTakeMemory) {
    const TemporaryFolder folder;
    // NetCDF-4 that wrote nothing: gigabytes of fill values in some kilobytes.
    {
        NetCdf file(folder / "bomb.nc", NC_NETCDF4);
        file.dimension("n", 2'000'000'000);
        file.dimension("f", 1'000'000'000);
        file.dimension("k", 4);
        file.variable("mesh", NC_INT, {});
        file.text("mesh", "cf_role", "mesh_topology");
        file.text("mesh", "node_coordinates", "x y");
        file.text("mesh", "face_node_connectivity", "c");
        file.variable("x", NC_DOUBLE, {"n"});
        file.variable("y", NC_DOUBLE, {"n"});
        file.variable("c", NC_INT, {"f", "k"});
        file.endDefinition();
    }
    FloodOptions options;
    options.crs = "EPSG:32633";
    const auto opened = openUnstructuredFlood(folder / "bomb.nc", options);
    ASSERT_FALSE(opened);
    EXPECT_NE(opened.error().reason.find("claims more values"), std::string::npos)
        << opened.error().reason;
}

TEST(HostileMeshFlood, OtherFilesAreNotTakenForMeshes) {
    const TemporaryFolder folder;
    write(folder / "text.nc", "no mesh at all");
    write(folder / "empty.slf", "");
    for (const std::string& path :
         {folder / "text.nc", folder / "empty.slf", folder / "missing.sww", folder / ""}) {
        EXPECT_FALSE(isUnstructuredFlood(path)) << path;
        EXPECT_FALSE(openUnstructuredFlood(path, {})) << path;
    }
}

} // namespace gnomon
