// What INPUT may be on the web, and scenes of it.
#include "tests/faults/fault_server.h"
#include "tests/streaming/glb_builder.h"
#include "tests/streaming/http_support.h"
#include "tests/viewer/files.h"
#include "viewer/input.h"
#include "viewer/scene.h"

#include <gtest/gtest.h>

#include <algorithm>

using namespace gnomon;
using test::Fault;
using test::FaultServer;

namespace {

std::string box() {
    test::GlbBuilder builder;
    builder.triangles(test::boxCorners({0, 0, 0}, {10, 10, 10}), test::boxTriangles());
    return builder.text();
}

// Where a box of ten metres stands on the Earth.
constexpr const char* kTileset =
    R"({"asset":{"version":"1.1"},"geometricError":10,"root":{"refine":"ADD","geometricError":0,
        "transform":[-0.1219,0.9925,0,0, -0.7721,-0.0948,0.6284,0, 0.6237,0.0766,0.7779,0,
                     3985000,489600,4937000,1],
        "boundingVolume":{"box":[5,5,5,5,0,0,0,5,0,0,0,5]},"content":{"uri":"box.glb"}}})";

class WebInput : public testing::Test {
  protected:
    WebInput() {
        for (const char* name :
             {"http_proxy", "https_proxy", "HTTPS_PROXY", "all_proxy", "ALL_PROXY"})
            ::unsetenv(name);
        folder_.write("tiles/tileset.json", kTileset);
        folder_.write("tiles/box.glb", box());
        folder_.write("terrain/layer.json", R"({"tilejson":"2.1.0","tiles":["{z}/{x}/{y}"]})");
        folder_.write("a.geojson", R"({"type":"FeatureCollection","features":[]})");
        folder_.write("c.json", R"({"type":"CityJSON"})");
        folder_.write("s.scene.json", R"({"layers":[]})");
        folder_.write("a.tif", std::string("II*\0", 4));
        folder_.write("a.html", "<!DOCTYPE html>");
        folder_.write("empty.json", "");
        folder_.write("broken.json", "{\"asset\":");
        served_.folder = folder_.path();
        server_ = std::make_unique<FaultServer>(served_);
        client_ = *HttpClient::create(test::impatient());
    }
    // The kind and what is opened, or the error without the address.
    std::string found(const std::string& path, const std::string& prefix = "") {
        const auto input =
            identifyInput(prefix + server_->url() + path, {},
                          [&](const std::string& url) { return httpSource(client_, url); });
        if (input)
            return std::string(nameOf(input->kind)) + " " +
                   input->path.substr(server_->url().size());
        EXPECT_TRUE(input.error().subject.starts_with(server_->url())) << input.error().message();
        return input.error().reason;
    }
    std::string at(const std::string& path) const { return server_->url() + path; }

    test::Folder folder_;
    test::FaultOptions served_;
    std::unique_ptr<FaultServer> server_;
    std::shared_ptr<HttpClient> client_;
};

} // namespace

TEST_F(WebInput, IsKnownByWhatIsInIt) {
    EXPECT_EQ(found("/tiles/tileset.json"), "tileset /tiles/tileset.json");
    EXPECT_EQ(found("/tiles/tileset.json?v=1"), "tileset /tiles/tileset.json");
    EXPECT_EQ(found("/tiles/box.glb"), "model /tiles/box.glb");
    EXPECT_EQ(found("/terrain/layer.json"), "terrain /terrain/layer.json");
    EXPECT_EQ(found("/tiles/tileset.json", "tileset="), "tileset /tiles/tileset.json");
    EXPECT_EQ(found("/tiles/tileset.json", "model="), "this is a tileset, not a model");
}

TEST_F(WebInput, AFolderIsAskedForWhatItMayHold) {
    EXPECT_EQ(found("/tiles/"), "tileset /tiles/tileset.json");
    EXPECT_EQ(found("/terrain/"), "terrain /terrain/layer.json");
    EXPECT_EQ(found("/terrain/", "terrain="), "terrain /terrain/layer.json");
    EXPECT_EQ(found("/none/"), "the server answered 404 Not Found");
    server_->setOffline(true);
    EXPECT_EQ(found("/tiles/"), "the server cannot be reached (3 attempts)");
}

TEST_F(WebInput, WhatGdalReadsIsReadFromFilesOnly) {
    for (const char* path : {"/a.geojson", "/c.json", "/s.scene.json", "/a.tif"})
        EXPECT_NE(found(path).find("is opened from a file only; download it first"),
                  std::string::npos)
            << path << ": " << found(path);
    const std::size_t before = server_->served().size();
    for (const char* prefix : {"imagery=", "depth=", "buildings=", "trees=", "lamps=", "scene="})
        EXPECT_TRUE(
            found("/x.tif", prefix).ends_with("is opened from a file only; download it first"))
            << found("/x.tif", prefix);
    EXPECT_EQ(server_->served().size(), before) << "nobody was asked";
}

TEST_F(WebInput, WhatIsNoneIsSaid) {
    EXPECT_EQ(found("/a.html"), "this is a web page or an XML file, not a tileset, a model or a "
                                "quantized mesh");
    EXPECT_EQ(found("/empty.json"), "the file is empty");
    EXPECT_EQ(found("/broken.json"), "not valid JSON (at byte 10)");
    EXPECT_EQ(found("/none.json"), "the server answered 404 Not Found");
    EXPECT_EQ(identifyInput("http://host/x").error().kind, ErrorKind::Usage) << "without a client";
}

TEST_F(WebInput, ASceneIsThatOfTheFilesAndAsksForNothingTwice) {
    SceneOptions options;
    options.http = test::impatient();
    options.inputs = {at("/tiles/tileset.json?key=s3cret")};
    const auto web = openScene(options);
    ASSERT_TRUE(web) << web.error().message();
    options.inputs = {folder_ / "tiles/tileset.json"};
    const auto file = openScene(options);
    ASSERT_TRUE(file) << file.error().message();
    EXPECT_EQ(web->anchor.longitudeDegrees, file->anchor.longitudeDegrees);
    EXPECT_EQ(web->anchor.heightMetres, file->anchor.heightMetres);
    EXPECT_EQ(web->radiusMetres, file->radiusMetres);
    EXPECT_EQ(web->layers[0].uri, at("/tiles/tileset.json")) << "the key is not in its name";
    const auto served = server_->served();
    EXPECT_EQ(std::count_if(served.begin(), served.end(),
                            [](const auto& r) { return r.target.starts_with("/tiles/tileset"); }),
              1);
    for (const auto& request : served)
        EXPECT_TRUE(request.target.ends_with("?key=s3cret")) << request.target;
}

TEST_F(WebInput, LayersOfASceneFileMayBeOnTheWeb) {
    SceneOptions options;
    options.http = test::impatient();
    options.inputs = {
        folder_.write("mixed.scene.json", R"({"layers":[{"tileset":")" + at("/tiles/tileset.json") +
                                              R"("},{"imagery":")" + at("/a.tif") +
                                              R"("},{"tileset":"tiles/tileset.json"}]})")};
    const auto scene = openScene(options);
    ASSERT_TRUE(scene) << scene.error().message();
    ASSERT_EQ(scene->layers.size(), 2u);
    EXPECT_EQ(scene->layers[0].uri, at("/tiles/tileset.json"));
    const auto refused =
        std::find_if(scene->problems.begin(), scene->problems.end(), [](const Problem& problem) {
            return problem.severity == Problem::Severity::Error;
        });
    ASSERT_NE(refused, scene->problems.end());
    EXPECT_EQ(refused->uri, at("/a.tif"));
    for (const char* layer : {R"({"depth":["a.tif","http://h/b.tif"]})",
                              R"({"terrain":"a.tif","hole":"http://h/b.geojson"})"}) {
        options.inputs = {
            folder_.write("wrong.scene.json", std::string(R"({"layers":[)") + layer + "]}")};
        const auto wrong = openScene(options);
        ASSERT_FALSE(wrong) << layer;
        EXPECT_NE(wrong.error().message().find("must be a file"), std::string::npos)
            << wrong.error().message();
    }
}

TEST_F(WebInput, ASceneThroughPassingFaultsIsWhole) {
    served_.share = 0.5;
    served_.seed = 3;
    served_.faults = {Fault::Status500, Fault::Truncate, Fault::Reset};
    FaultServer server(served_);
    SceneOptions options;
    options.http = test::impatient();
    for (int i = 0; i < 10; ++i) {
        options.inputs = {server.url() + "/tiles/tileset.json?" + std::to_string(i)};
        const auto scene = openScene(options);
        ASSERT_TRUE(scene) << scene.error().message();
        EXPECT_TRUE(scene->layers[0].tileset->failures().empty());
    }
    const auto served = server.served();
    EXPECT_TRUE(std::any_of(served.begin(), served.end(),
                            [](const auto& request) { return request.fault != Fault::None; }));
}

TEST_F(WebInput, AnEarlierRunMakesTheNextOneNeedNoServer) {
    served_.cacheControl = "max-age=600";
    auto server = std::make_unique<FaultServer>(served_);
    SceneOptions options;
    options.http = test::impatient();
    options.http.cacheFolder = folder_ / "cache";
    options.inputs = {server->url() + "/tiles/tileset.json"};
    ASSERT_TRUE(openScene(options));
    server.reset();
    options.http.offline = true;
    const auto scene = openScene(options);
    ASSERT_TRUE(scene) << scene.error().message();
    EXPECT_TRUE(scene->layers[0].tileset->failures().empty());
}
