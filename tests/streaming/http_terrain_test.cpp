// Quantized meshes from a web server are those from a folder.
#include "tests/faults/fault_server.h"
#include "tests/streaming/http_support.h"
#include "tests/streaming/quantized_mesh_folders.h"
#include "tests/viewer/files.h"

#include <map>

using namespace gnomon;
using test::Fault;
using test::FaultServer;

namespace {

class WebTerrain : public testing::Test {
  protected:
    WebTerrain() {
        for (const char* name :
             {"http_proxy", "https_proxy", "HTTPS_PROXY", "all_proxy", "ALL_PROXY"})
            ::unsetenv(name);
        served_.folder = folder_.path();
    }
    Result<std::shared_ptr<const Terrain>> openServed(const FaultServer& server,
                                                      const std::string& name) {
        web_.emplace(test::impatient(), server.url());
        return openQuantizedMesh(web_->source, server.url() + "/" + name, {});
    }
    test::Folder folder_;
    test::FaultOptions served_;
    std::optional<test::Web> web_;
};

} // namespace

TEST_F(WebTerrain, IsThatOfTheFolder) {
    folder_.write("layer.json", layerText("\"available\":" + availableOf(kSparse)));
    writeTiles(folder_.path(), kSparse);
    FaultServer server(served_);
    const auto web = openServed(server, "layer.json");
    ASSERT_TRUE(web) << web.error().message();
    const auto file = opened(folder_ / "layer.json");
    EXPECT_EQ((*web)->facts().extent, file->facts().extent);
    EXPECT_EQ((*web)->facts().minHeightMetres, file->facts().minHeightMetres);
    EXPECT_EQ((*web)->at({10.0, 20.0}), file->at({10.0, 20.0}));
    const Shown a = shown((*web)->tiles({}, {})), b = shown(file->tiles({}, {}));
    EXPECT_TRUE(a.complete);
    EXPECT_EQ(a.paths, b.paths);
    ASSERT_EQ(a.contents.size(), b.contents.size());
    for (std::size_t i = 0; i < a.contents.size(); ++i)
        EXPECT_EQ(a.contents[i]->meshes[0].positions, b.contents[i]->meshes[0].positions);
    std::map<std::string, int> times;
    int most = 0;
    for (const auto& request : server.served())
        most = std::max(most, ++times[request.target]);
    EXPECT_EQ(most, 2) << "layer.json to know what it is; no tile is asked for twice";
    EXPECT_EQ(times.erase("/layer.json"), 1u);
    for (const auto& [target, asked] : times)
        EXPECT_EQ(asked, 1) << target;
}

TEST_F(WebTerrain, FindsTilesThatNothingTellsOf) {
    folder_.write("layer.json", layerText("\"x\":0"));
    writeTiles(folder_.path(), kSparse);
    FaultServer server(served_);
    const auto web = openServed(server, "layer.json");
    ASSERT_TRUE(web) << web.error().message();
    EXPECT_EQ(shown((*web)->tiles({}, {})).paths,
              shown(opened(folder_ / "layer.json")->tiles({}, {})).paths);
}

TEST_F(WebTerrain, SaysWhichTileIsNotThere) {
    folder_.write("layer.json", layerText("\"available\":" + availableOf(kSparse)));
    {
        FaultServer server(served_);
        const auto none = openServed(server, "layer.json");
        ASSERT_FALSE(none);
        EXPECT_EQ(none.error().message(),
                  server.url() + "/layer.json: tells of tiles, but none of the first of them is "
                                 "there");
    }
    Tiles some = kSparse;
    some.erase({2, 4, 2});
    writeTiles(folder_.path(), some);
    FaultServer server(served_);
    const auto web = openServed(server, "layer.json");
    ASSERT_TRUE(web);
    const Shown seen = shown((*web)->tiles({}, {}));
    ASSERT_EQ(seen.tileset->failures().size(), 1u);
    EXPECT_NE(seen.tileset->failures()[0].error.message().find(
                  server.url() + "/2/4/2.terrain?v=1.1.0: the server answered 404 Not Found"),
              std::string::npos)
        << seen.tileset->failures()[0].error.message();
}

TEST_F(WebTerrain, OfAServerThatFailsInPassingIsWhole) {
    folder_.write("layer.json", layerText("\"available\":" + availableOf(kSparse)));
    writeTiles(folder_.path(), kSparse);
    served_.share = 0.3;
    served_.faults = {Fault::Status500, Fault::Truncate, Fault::Reset};
    FaultServer server(served_);
    const auto web = openServed(server, "layer.json");
    ASSERT_TRUE(web) << web.error().message();
    const Shown seen = shown((*web)->tiles({}, {}));
    EXPECT_EQ(seen.paths, shown(opened(folder_ / "layer.json")->tiles({}, {})).paths);
    EXPECT_TRUE(seen.tileset->failures().empty());
    EXPECT_GT(web_->client->counts().retries, 0u);
}
