#include "tests/hostile/family_files.h"

#include "tests/hostile/confined.h"
#include "tests/hostile/families.h"
#include "tests/streaming/draco_builder.h"
#include "tests/streaming/quantized_mesh_support.h"
#include "tests/streaming/tile_builder.h"

#include <OpenImageIO/imageio.h>
#include <draco/point_cloud/point_cloud_builder.h>
#include <meshoptimizer.h>

#include <bit>

namespace gnomon::test {

namespace {

std::string textOf(const Bytes& bytes) {
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::string base64(const std::string& bytes) {
    constexpr const char* kDigits =
        "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
    std::string out;
    for (std::size_t i = 0; i < bytes.size(); i += 3) {
        std::uint32_t word = 0;
        for (std::size_t k = 0; k < 3; ++k)
            word = word << 8 | (i + k < bytes.size() ? std::uint8_t(bytes[i + k]) : 0u);
        for (std::size_t k = 0; k < 4; ++k)
            out += i + k > bytes.size() ? '=' : kDigits[word >> (18 - 6 * k) & 63u];
    }
    return out;
}

std::string put64(std::uint64_t value) {
    std::string out;
    put(out, std::uint32_t(value));
    put(out, std::uint32_t(value >> 32));
    return out;
}

} // namespace

GlbBuilder richGlb() {
    GlbBuilder builder;
    Json& primitive =
        builder.triangles(boxCorners(glm::vec3(0.0f), glm::vec3(1.0f)), boxTriangles());
    const std::string png = pngOf(2, 2, 4, "0123456789abcdef");
    builder.root["images"] = Json::array({{{"bufferView", builder.view(png.data(), png.size())}}});
    builder.root["textures"] = Json::array({{{"source", 0}}});
    builder.root["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"] = {{"index", 0}};
    primitive["material"] = 0;
    primitive["attributes"]["TEXCOORD_0"] = builder.floats(std::vector<float>(16, 0.5f), "VEC2");
    primitive["attributes"]["_BATCHID"] = builder.floats(std::vector<float>(8, 1.0f), "SCALAR");
    const std::vector<std::uint16_t> which = {7};
    const std::vector<float> value = {1, 1, 1};
    const int indexView = builder.view(which.data(), 2), valueView = builder.view(value.data(), 12);
    builder.root["accessors"][0]["sparse"] = {
        {"count", 1},
        {"indices", {{"bufferView", indexView}, {"componentType", 5123}}},
        {"values", {{"bufferView", valueView}}}};
    builder.root["nodes"] = Json::array({{{"children", {1}}}, {{"mesh", 0}}});
    builder.root["scenes"] = Json::array({{{"nodes", {0}}}});
    return builder;
}

std::string gltfText() {
    GlbBuilder builder;
    builder.triangles(boxCorners(glm::vec3(0.0f), glm::vec3(1.0f)), boxTriangles());
    builder.root["buffers"] =
        Json::array({{{"byteLength", builder.bin.size()},
                      {"uri", "data:application/octet-stream;base64," + base64(builder.bin)}}});
    builder.bin.clear();
    return builder.json();
}

std::string b3dmText() {
    std::string centre; // RTC_CENTER in the binary part
    for (const float f : {100.0f, -20.0f, 3.0f})
        put(centre, std::bit_cast<std::uint32_t>(f));
    return b3dmOf(richGlb().text(), R"({"BATCH_LENGTH":2,"RTC_CENTER":{"byteOffset":0}} )",
                  R"({"height":[1.5,2.5],"name":["a","b"],"x":{"a":[1,2]}})", centre);
}

namespace {

std::string floatBytes(std::initializer_list<float> values) {
    std::string out;
    for (const float value : values)
        put(out, std::bit_cast<std::uint32_t>(value));
    return out;
}

// A part of a cmpt says how long it is, padding included.
std::string padded(std::string tile) {
    tile.resize((tile.size() + 7) / 8 * 8, ' ');
    for (std::size_t i = 0; i < 4; ++i)
        tile[8 + i] = char(tile.size() >> (8 * i));
    return tile;
}

} // namespace

std::string i3dmText() {
    TileFile file = i3dmOf(2, richGlb().text());
    file.features.add("POSITION", std::vector<float>{0, 0, 0, 10, 0, 0});
    file.features.add("NORMAL_UP", std::vector<float>{0, 0, 1, 0, 0, 1});
    file.features.add("NORMAL_RIGHT", std::vector<float>{1, 0, 0, 0, 1, 0});
    file.features.add("SCALE", std::vector<float>{1, 2});
    file.features.add("BATCH_ID", std::vector<std::uint16_t>{0, 1});
    file.features.json["BATCH_ID"]["componentType"] = "UNSIGNED_SHORT";
    file.batchJson = R"({"name":["a","b"],"height":[1,2]})";
    return file.text();
}

std::string pntsText() {
    TileFile file = pntsOf({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0.5f});
    file.features.json["RTC_CENTER"] = {1, 2, 3};
    file.features.json["BATCH_LENGTH"] = 2;
    file.features.add("RGB", std::vector<std::uint8_t>(12, 77));
    file.features.add("NORMAL_OCT16P",
                      std::vector<std::uint8_t>{128, 128, 128, 255, 255, 128, 16, 32});
    file.features.add("BATCH_ID", std::vector<std::uint8_t>{0, 1, 0, 1});
    file.features.json["BATCH_ID"]["componentType"] = "UNSIGNED_BYTE";
    file.batchJson = R"({"name":["a","b"]})";
    return file.text();
}

std::string pntsDracoText() {
    draco::PointCloudBuilder builder;
    constexpr std::uint32_t kPoints = 20;
    builder.Start(kPoints);
    const int position =
        builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
    for (std::uint32_t i = 0; i < kPoints; ++i) {
        const std::array<float, 3> at{float(i), float(i * i % 7), float(i % 3)};
        builder.SetAttributeValueForPoint(position, draco::PointIndex(i), at.data());
    }
    const std::unique_ptr<draco::PointCloud> cloud = builder.Finalize(false);
    draco::Encoder encoder;
    draco::EncoderBuffer buffer;
    EXPECT_TRUE(encoder.EncodePointCloudToBuffer(*cloud, &buffer).ok());
    TileFile file;
    file.magic = "pnts";
    file.features.json["POINTS_LENGTH"] = kPoints;
    file.features.json["POSITION"]["byteOffset"] = 0;
    file.features.binary.assign(buffer.data(), buffer.size());
    file.features.json["extensions"]["3DTILES_draco_point_compression"] = {
        {"properties", {{"POSITION", cloud->attribute(position)->unique_id()}}},
        {"byteOffset", 0},
        {"byteLength", buffer.size()}};
    file.features.binary.resize((buffer.size() + 7) / 8 * 8);
    return file.text();
}

std::string cmptText() {
    return cmptOf({padded(b3dmText()), cmptOf({padded(i3dmText())}), padded(pntsText())});
}

std::string meshoptText() {
    const std::vector<float> corners = boxCorners(glm::vec3(0.0f), glm::vec3(1.0f));
    const std::vector<std::uint32_t> indices = boxTriangles();
    constexpr std::size_t kStride = 12;
    const std::size_t vertices = corners.size() / 3;
    std::vector<unsigned char> packed(meshopt_encodeVertexBufferBound(vertices, kStride));
    packed.resize(meshopt_encodeVertexBuffer(packed.data(), packed.size(), corners.data(), vertices,
                                             kStride));
    std::vector<unsigned char> packedIndices(
        meshopt_encodeIndexBufferBound(indices.size(), vertices));
    packedIndices.resize(meshopt_encodeIndexBuffer(packedIndices.data(), packedIndices.size(),
                                                   indices.data(), indices.size()));
    std::string bin(packed.begin(), packed.end());
    bin.resize((bin.size() + 3) / 4 * 4);
    const std::size_t at = bin.size();
    bin.append(packedIndices.begin(), packedIndices.end());
    const auto view = [](std::size_t offset, std::size_t length, std::size_t stride,
                         std::size_t count, std::size_t plainOffset, const char* mode) {
        Json v = {{"buffer", 1}, {"byteOffset", plainOffset}, {"byteLength", stride * count}};
        v["extensions"]["EXT_meshopt_compression"] = {
            {"buffer", 0},          {"byteOffset", offset}, {"byteLength", length},
            {"byteStride", stride}, {"count", count},       {"mode", mode}};
        return v;
    };
    Json root = {{"asset", {{"version", "2.0"}}},
                 {"extensionsRequired", {"EXT_meshopt_compression"}},
                 {"extensionsUsed", {"EXT_meshopt_compression"}},
                 {"scenes", {{{"nodes", {0}}}}},
                 {"nodes", {{{"mesh", 0}}}}};
    root["buffers"] =
        Json::array({{{"byteLength", bin.size()}},
                     {{"byteLength", kStride * vertices + 4 * indices.size()},
                      {"extensions", {{"EXT_meshopt_compression", {{"fallback", true}}}}}}});
    root["bufferViews"] = Json::array(
        {view(0, packed.size(), kStride, vertices, 0, "ATTRIBUTES"),
         view(at, packedIndices.size(), 4, indices.size(), kStride * vertices, "TRIANGLES")});
    root["accessors"] = Json::array(
        {{{"bufferView", 0}, {"componentType", 5126}, {"count", vertices}, {"type", "VEC3"}},
         {{"bufferView", 1},
          {"componentType", 5125},
          {"count", indices.size()},
          {"type", "SCALAR"}}});
    root["meshes"] = Json::array(
        {{{"primitives", Json::array({{{"attributes", {{"POSITION", 0}}}, {"indices", 1}}})}}});
    return GlbBuilder::glbOf(root.dump(), bin);
}

std::string metadataText() {
    GlbBuilder builder;
    Json& primitive =
        builder.triangles(boxCorners(glm::vec3(0.0f), glm::vec3(1.0f)), boxTriangles());
    primitive["attributes"]["_FEATURE_ID_0"] = builder.floats({0, 0, 0, 0, 1, 1, 1, 1}, "SCALAR");
    primitive["extensions"]["EXT_mesh_features"]["featureIds"] =
        Json::array({{{"featureCount", 2}, {"attribute", 0}, {"propertyTable", 0}}});
    const auto view = [&](const std::string& bytes) {
        return builder.view(bytes.data(), bytes.size());
    };
    const auto words = [](std::initializer_list<std::uint32_t> values) {
        std::string out;
        for (const std::uint32_t value : values)
            put(out, value);
        return out;
    };
    const int heights = view(floatBytes({2.5f, 7.0f})), names = view("one and another"),
              nameOffsets = view(words({0, 3, 15})), lists = view("abcde"),
              listOffsets = view(words({0, 2, 5}));
    Json& metadata = builder.root["extensions"]["EXT_structural_metadata"];
    metadata["schema"] = Json::parse(R"({"id":"s","classes":{"house":{"properties":{
        "height":{"type":"SCALAR","componentType":"FLOAT32","noData":-1},
        "name":{"type":"STRING"},
        "list":{"type":"SCALAR","componentType":"UINT8","array":true}}}}})");
    metadata["propertyTables"] =
        Json::array({{{"class", "house"},
                      {"count", 2},
                      {"properties",
                       {{"height", {{"values", heights}}},
                        {"name", {{"values", names}, {"stringOffsets", nameOffsets}}},
                        {"list", {{"values", lists}, {"arrayOffsets", listOffsets}}}}}}});
    builder.root["extensionsUsed"] = {"EXT_structural_metadata", "EXT_mesh_features"};
    return builder.text();
}

std::string dracoGlb(bool edgebreaker) {
    return dracoGlbOf(dracoEncode(
        6, edgebreaker ? draco::MESH_EDGEBREAKER_ENCODING : draco::MESH_SEQUENTIAL_ENCODING, 11));
}

std::string encodedPicture(const std::string& format) {
    const Outcome outcome = runConfined([&] {
        const OneFile file("a." + format);
        constexpr int kSide = 32;
        std::vector<std::uint8_t> pixels;
        for (int i = 0; i < kSide * kSide * 3; ++i)
            pixels.push_back(std::uint8_t(i * i % 251));
        const auto out = OIIO::ImageOutput::create(format);
        if (!out ||
            !out->open(file.path(), OIIO::ImageSpec(kSide, kSide, 3, OIIO::TypeDesc::UINT8)) ||
            !out->write_image(OIIO::TypeDesc::UINT8, pixels.data()) || !out->close())
            return std::string();
        return contentsOf(file.path());
    });
    return outcome.said;
}

std::string tilesetText() {
    return R"({"asset":{"version":"1.1","gltfUpAxis":"Z","generator":"x"},"geometricError":1000,
"extensionsUsed":["3DTILES_multiple_contents"],
"root":{"boundingVolume":{"region":[-1.3197,0.6988,-1.3196,0.6989,0,88]},"geometricError":500,
"refine":"ADD","content":{"uri":"a.b3dm","boundingVolume":{"sphere":[0,0,0,9]}},
"viewerRequestVolume":{"sphere":[1,2,3,4e7]},
"children":[{"boundingVolume":{"box":[6378137,0,0,9,0,0,0,9,0,0,0,9]},"geometricError":20,
"refine":"replace","transform":[1,0,0,0,0,1,0,0,0,0,1,0,7,8,9,1],
"contents":[{"uri":"b.glb"},{"uri":"sub/c.gltf?x=1"}],
"children":[{"boundingVolume":{"sphere":[6378137,0,0,5]},"geometricError":0,"content":{"uri":"d.json"}}]},
{"boundingVolume":{"region":[3.1,-0.2,-3.1,0.2,-5,90]},"geometricError":4,
"content":{"url":"e.i3dm"},"extras":{"a":[1,{"b":null}]}}]}})";
}

std::string implicitTileset() {
    return R"({"asset":{"version":"1.1"},"geometricError":64,"root":{
"boundingVolume":{"box":[0,0,0,100,0,0,0,100,0,0,0,100]},"geometricError":64,"refine":"ADD",
"content":{"uri":"c/{level}_{x}_{y}.glb"},"implicitTiling":{"subdivisionScheme":"QUADTREE",
"subtreeLevels":3,"availableLevels":6,"subtrees":{"uri":"s/{level}_{x}_{y}.subtree"}}}})";
}

std::string binarySubtreeText() {
    std::string json =
        R"({"buffers":[{"byteLength":16}],"bufferViews":[{"buffer":0,"byteOffset":0,"byteLength":3},)"
        R"({"buffer":0,"byteOffset":8,"byteLength":8}],"tileAvailability":{"bitstream":0},)"
        R"("contentAvailability":[{"bitstream":0}],"childSubtreeAvailability":{"bitstream":1}})";
    json.resize((json.size() + 7) / 8 * 8, ' ');
    std::string out = "subt";
    put(out, 1);
    return out + put64(json.size()) + put64(16) + json + std::string(16, '\xff');
}

std::string jsonSubtreeText() {
    return R"({"tileAvailability":{"constant":1},"contentAvailability":[{"constant":1}],)"
           R"("childSubtreeAvailability":{"constant":0}})";
}

std::string quantizedText() {
    PlainTile tile = gridTile({10, 45, 10.01, 45.01}, 6,
                              [](double lon, double lat) { return 100 * (lon + lat); });
    tile.extensions = {
        {1, Bytes(2 * tile.u.size(), std::byte(128))},
        {2, Bytes(1, std::byte(0))},
        {77, Bytes(9, std::byte(5))},
        {4, textBytes(R"({"available":[[{"startX":2,"startY":4,"endX":3,"endY":5}],[]],)"
                      R"("geometricerror":12.5})",
                      true)}};
    return textOf(written(tile));
}

std::string gzippedText(const std::string& text) {
    return textOf(gzipped(test::bytesOf(text)));
}

std::string layerText() {
    return R"({"tilejson":"2.1.0","format":"quantized-mesh-1.0","version":"1.2.0","scheme":"tms",
"tiles":["{z}/{x}/{y}.terrain?v={version}"],"projection":"EPSG:4326","bounds":[-180,-90,180,90],
"attribution":"<a href='x'>Somebody</a>","extensions":["octvertexnormals","metadata"],
"metadataAvailability":10,"parentUrl":"./below","minzoom":0,"maxzoom":2,
"available":[[{"startX":0,"startY":0,"endX":1,"endY":0}],[{"startX":0,"startY":0,"endX":3,"endY":1}],
[{"startX":5,"startY":1,"endX":6,"endY":2},{"startX":0,"startY":0,"endX":0,"endY":3}]]})";
}

std::string cameraPathText() {
    return R"({"interpolation":"smooth","keyframes":[
{"t":0,"lon":6.96,"lat":50.94,"height":300,"heading":30,"pitch":-25,"fov":45},
{"t":2.5,"lon":6.97,"lat":50.945,"height":320.5,"heading":350,"pitch":-20,"roll":3},
{"t":9,"lon":-179.9,"lat":-89,"height":1e6,"heading":-10,"pitch":-90,"fov":60}]})";
}

std::string kmlTourText() {
    return R"(<?xml version="1.0" encoding="UTF-8"?>
<kml xmlns="http://www.opengis.net/kml/2.2" xmlns:gx="http://www.google.com/kml/ext/2.2">
<Document><!-- a tour --><gx:Tour><name>A &amp; B</name><gx:Playlist>
<gx:FlyTo><gx:duration>0.5</gx:duration><gx:flyToMode>smooth</gx:flyToMode>
<Camera><longitude>6.9</longitude><latitude>50.9</latitude><altitude>400</altitude>
<heading>30</heading><tilt>60</tilt><roll>0</roll><altitudeMode>absolute</altitudeMode></Camera>
</gx:FlyTo><gx:Wait><gx:duration>1</gx:duration></gx:Wait>
<gx:FlyTo><gx:duration>4</gx:duration><gx:flyToMode>bounce</gx:flyToMode>
<LookAt><longitude>6.95</longitude><latitude>50.95</latitude><altitude>10</altitude>
<heading>-30</heading><tilt>45</tilt><range>500</range></LookAt></gx:FlyTo>
</gx:Playlist></gx:Tour></Document></kml>
)";
}

std::string sceneText() {
    return R"({"layers":[{"terrain":"dem.tif","crs":"EPSG:25832","heights":"egm96","color":"#336699"},
{"tileset":"buildings/tileset.json","place":[6.9,50.9,40,12]},
{"buildings":"houses.geojson","height":6.0},{"trees":"trees.geojson","raise":1},
{"depth":["a.tif","b.tif"],"step":"15min","dry":0.05},
{"barriers":"walls.geojson","from":"2021-07-14T18:00:00Z"},{"lamps":"lamps.geojson"}],
"time":"2021-07-14T18:00:00Z","ground":44.5,
"camera":{"lon":6.96,"lat":50.94,"height":300,"heading":30,"pitch":-25,"fov":50}})";
}

std::string lampsText() {
    return R"({"type":"FeatureCollection","features":[
{"type":"Feature","properties":{"height":5,"facing":"all","power":[90,80,70],"range":30},
"geometry":{"type":"Point","coordinates":[6.9,50.9]}},
{"type":"Feature","properties":null,"geometry":{"type":"Point","coordinates":[6.91,50.9,55.5]}},
{"type":"Feature","properties":{},"geometry":{"type":"LineString","coordinates":[[1,2],[3,4]]}}]})";
}

std::string cityJsonText() {
    return R"({"type":"CityJSON","version":"2.0",
"transform":{"scale":[0.001,0.001,0.001],"translate":[400000,5600000,50]},
"metadata":{"referenceSystem":"https://www.opengis.net/def/crs/EPSG/0/25832"},
"CityObjects":{"b":{"type":"Building","attributes":{"a":1,"n":"x"},"children":["p"],"geometry":[
{"type":"Solid","lod":"2","boundaries":[[[[0,3,2,1]],[[4,5,6,7]],[[0,1,5,4]],[[1,2,6,5]],
[[2,3,7,6]],[[3,0,4,7]]]]}]},"p":{"type":"BuildingPart","parents":["b"],"geometry":[
{"type":"MultiSurface","lod":1,"boundaries":[[[0,1,2,3]],[[4,5,6,7]]]}]}},
"vertices":[[0,0,0],[10000,0,0],[10000,10000,0],[0,10000,0],
[0,0,10000],[10000,0,10000],[10000,10000,10000],[0,10000,10000]]})";
}

std::string csvText() {
    return "id;x;y;z;height\nA;382000,5;6354000,25;3,1;5\nB;382010;6354010;;7\n"
           "\"C, 1\";382020;6354020;4;\n";
}

std::string geoJsonText() {
    return R"({"type":"FeatureCollection","name":"houses","crs":{"type":"name","properties":{
"name":"urn:ogc:def:crs:OGC:1.3:CRS84"}},"features":[
{"type":"Feature","id":3,"properties":{"height":5.5,"name":"a"},"geometry":{"type":"Polygon",
"coordinates":[[[7,51],[7.001,51],[7.001,51.001],[7,51.001],[7,51]],
[[7.0002,51.0002],[7.0004,51.0002],[7.0004,51.0004],[7.0002,51.0002]]]}},
{"type":"Feature","properties":{"height":null},"geometry":{"type":"MultiPolygon","coordinates":
[[[[8,51],[8.001,51],[8.001,51.001],[8,51]]]]}},
{"type":"Feature","properties":{},"geometry":{"type":"Point","coordinates":[7.5,51.5,80]}}]})";
}

} // namespace gnomon::test
