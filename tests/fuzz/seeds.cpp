// Writes the seeds of every fuzz target, corpus/<target>/seed-*: small files made by code, the good
// files of the hostile tests and pieces of the built-in place. Run again when a format is added:
//
//   build/release/tests/fuzz_seeds tests/fuzz/corpus
#include "tests/hostile/families.h"
#include "tests/streaming/draco_builder.h"
#include "tests/streaming/mesh_flood_support.h"
#include "viewer/place/place.h"

#include <cstdio>
#include <fstream>
#include <iterator>

namespace {

using namespace gnomon;
using namespace gnomon::test;
namespace fs = std::filesystem;

// The same bytes are mutated faster in a small file.
constexpr std::size_t kMostBytes = 28 << 10;

fs::path corpus;

void write(const std::string& target, const std::string& name, const std::string& text) {
    if (text.size() > kMostBytes) {
        std::fprintf(stderr, "%s/%s is left out: %zu bytes\n", target.c_str(), name.c_str(),
                     text.size());
        return;
    }
    fs::create_directories(corpus / target);
    std::ofstream(corpus / target / ("seed-" + name), std::ios::binary) << text;
}

std::string contentsOf(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

const std::string kZero(1, '\0');

// Targets by the families of the hostile tests; a subtree's first byte chooses what it is read as.
void writeFamilies() {
    const std::map<std::string, std::string> targets = {
        {"glb", "glb"},           {"gltf", "glb"},
        {"draco", "glb"},         {"b3dm", "content"},
        {"i3dm", "content"},      {"cmpt", "content"},
        {"pnts", "content"},      {"png", "image"},
        {"jpeg", "image"},        {"webp", "image"},
        {"tileset", "tileset"},   {"subtree", "subtree"},
        {"layer", "layer_json"},  {"quantized", "quantized_mesh"},
        {"scene", "scene_file"},  {"quantized-gzip", "quantized_mesh"},
        {"lamps", "lamps"},       {"camera-path", "camera_path"},
        {"cityjson", "cityjson"}, {"csv", "csv"},
        {"kml-tour", "kml"},      {"meshopt", "glb"},
    };
    for (const Family& family : families()) {
        const auto target = targets.find(family.name);
        if (target == targets.end()) {
            std::fprintf(stderr, "family %s has no target\n", family.name.c_str());
            continue;
        }
        const char* prefix = target->second == "subtree" ? "\4" : ""; // a quadtree of 3 levels
        for (std::size_t i = 0; i < family.good.size(); ++i)
            write(target->second, family.name + "-" + std::to_string(i), prefix + family.good[i]);
    }
}

void writeUris() {
    const std::vector<std::pair<std::string, std::string>> pairs = {
        {"a/b/tileset.json", "../c/d.glb?v=1#x"},
        {"tileset.json", "%2e%2e/x"},
        {"tileset.json", "a%20b/c.b3dm"},
        {"tileset.json", "file:///etc/passwd"},
        {"https://example.com/a/b/t.json?key=1", "../c.glb?x=2#y"},
        {"https://example.com/a/t.json", "//other.org/d.glb"},
        {"http://[::1]:8080/a/t.json", "/root.glb"},
        {"https://user@example.com/t.json", "https://example.com:443/%7Ea/./b/../c.json"}};
    int number = 0;
    for (const auto& [base, uri] : pairs)
        write("uri", std::to_string(number++), base + kZero + uri);
}

void writeUrls() {
    const std::vector<std::pair<std::string, std::string>> pairs = {
        {"https://example.com/a/b/t.json?key=1", "../c.glb?x=2#y"},
        {"http://user:word@[::1]:8080/a/t.json", "//Other.ORG:443/d.glb"},
        {"https://example.com", "?token=abc&v=1"},
        {"http://127.0.0.1/", "HTTPS://xn--e1aybc.example./%7Ea/./b/../c d"}};
    int number = 0;
    for (const auto& [base, reference] : pairs)
        write("url", std::to_string(number++), base + kZero + reference);
}

void writeHeads() {
    write("http_head", "fresh",
          "HTTP/1.1 200 OK\r\nETag: \"abc\"\r\nCache-Control: public, max-age=3600\r\nAge: 10\r\n"
          "Date: Fri, 15 Jan 2027 08:00:00 GMT\r\nVary: Accept, X-Key\r\n"
          "HTTP/1.1 304 Not Modified\r\nCache-Control: max-age=60\r\n");
    write("http_head", "dated",
          "HTTP/2 200\r\nLast-Modified: Tue, 12 Jan 2027 00:00:00 GMT\r\n"
          "Expires: Sat, 16 Jan 2027 00:00:00 GMT\r\nDate: Fri, 15 Jan 2027 08:00:00 GMT\r\n"
          "Content-Type: application/json\r\nVary: *\r\n");
    write("http_head", "busy",
          "HTTP/1.1 503 Service Unavailable\r\nRetry-After: Fri, 15 Jan 2027 08:01:00 GMT\r\n"
          "Retry-After: 120\r\nCache-Control: no-store\r\nPragma: no-cache\r\n");
}

void writeTables() {
    std::string binary;
    for (std::uint32_t i = 0; i < 12; ++i)
        put(binary, std::bit_cast<std::uint32_t>(float(i) * 0.1f));
    write("batch_table", "columns",
          std::string("\3\0", 2) +
              R"({"id":["a","b","c"],"n":[1,-2,3.5],"x":[{"k":[1]},null,true],)"
              R"("f":{"byteOffset":0,"componentType":"FLOAT","type":"SCALAR"},)"
              R"("v":{"byteOffset":12,"componentType":"FLOAT","type":"VEC3"},)"
              R"("HIERARCHY":{"classes":[],"instancesLength":0}})" +
              kZero + binary);
    std::string views(7 * 32, '\0'); // one each 32 bytes
    for (std::size_t i = 0; i < views.size(); ++i)
        views[i] = char(i % 5 == 0 ? i / 8 : 0);
    write(
        "property_table", "columns",
        R"({"schema":{"id":"s","classes":{"thing":{"properties":{)"
        R"("height":{"type":"SCALAR","componentType":"FLOAT32","noData":0,"default":1},)"
        R"("name":{"type":"STRING"},"flag":{"type":"BOOLEAN"},)"
        R"("kind":{"type":"ENUM","enumType":"kinds"},)"
        R"("colour":{"type":"VEC3","componentType":"UINT8","normalized":true,"scale":[2,2,2]},)"
        R"("list":{"type":"SCALAR","componentType":"UINT16","array":true}}}},)"
        R"("enums":{"kinds":{"valueType":"UINT8","values":[{"name":"a","value":0},)"
        R"({"name":"b","value":1}]}}},"propertyTables":[{"class":"thing","count":3,"properties":{)"
        R"("height":{"values":0},"name":{"values":1,"stringOffsets":2},"flag":{"values":3},)"
        R"("kind":{"values":4},"colour":{"values":5},"list":{"values":1,"arrayOffsets":6}}}]})" +
            kZero + views);
}

void writeMeshopt() {
    // Four elements of 12 bytes, as the encoder would write them where all are alike; indices of
    // two triangles.
    write("meshopt", "attributes", std::string("\0\x0c\4\0\xa0", 5) + std::string(64, '\0'));
    write("meshopt", "triangles", std::string("\1\4\6\0\xe1\xf0\x10", 7) + std::string(24, '\0'));
    write("meshopt", "indices", std::string("\2\4\3\0\xd1", 5) + std::string("\0\2\2\0\0\0\0", 7));
}

void writeDraco() {
    for (const int method : {draco::MESH_SEQUENTIAL_ENCODING, draco::MESH_EDGEBREAKER_ENCODING})
        for (const int bits : {0, 11}) {
            const DracoEncoded mesh = dracoEncode(3, method, bits);
            const std::string name = std::to_string(method) + "-" + std::to_string(bits);
            write("draco", name, std::string{char(mesh.points), char(mesh.faces)} + mesh.bytes);
        }
}

std::string fortran(const std::string& record) {
    std::string length;
    putBig(length, std::uint32_t(record.size()));
    return length + record + length;
}

std::string bigInts(const std::vector<std::uint32_t>& values) {
    std::string out;
    for (const std::uint32_t value : values)
        putBig(out, value);
    return out;
}

std::string bigFloats(const std::vector<float>& values) {
    std::string out;
    for (const float value : values)
        putBig(out, std::bit_cast<std::uint32_t>(value));
    return out;
}

// Two triangles, two steps, level, bottom and velocity, single precision.
void writeSelafin() {
    const auto padded = [](std::string text, std::size_t size) {
        text.resize(size, ' ');
        return text;
    };
    std::string out = fortran(padded("TITLE", 72) + "SERAFIN ") + fortran(bigInts({4, 0}));
    for (const char* name : {"FREE SURFACE", "BOTTOM", "VELOCITY U", "VELOCITY V"})
        out += fortran(padded(name, 16) + padded("M", 16));
    out += fortran(bigInts({1, 0, 0, 0, 0, 0, 0, 0, 0, 1}));
    out += fortran(bigInts({2021, 7, 14, 12, 0, 0}));
    out += fortran(bigInts({2, 4, 3, 1})) + fortran(bigInts({1, 2, 3, 1, 3, 4}));
    out += fortran(bigInts({1, 2, 3, 4}));
    out += fortran(bigFloats({500000, 500010, 500010, 500000}));
    out += fortran(bigFloats({5600000, 5600000, 5600010, 5600010}));
    for (const float second : {0.0f, 60.0f}) {
        out += fortran(bigFloats({second}));
        for (const float value : {2.0f + second / 60.0f, 1.0f, 0.5f, -0.5f})
            out += fortran(bigFloats({value, value, value, value}));
    }
    write("selafin", "two-triangles", out);
}

void writeNetCdf() {
    const TemporaryFolder folder;
    for (const int format : {NC_64BIT_OFFSET, NC_64BIT_DATA, 0}) {
        UgridSpec spec = gridSpec(2, 2, 10.0, true);
        spec.format = format;
        writeUgrid(folder / "mesh.nc", spec);
        write("netcdf_header", std::to_string(format), contentsOf(folder / "mesh.nc"));
    }
}

// Pieces of the built-in place: the smallest tiles, and every file that is text.
void writePlacePieces() {
    const TemporaryFolder folder;
    PlaceOptions options;
    options.folder = folder / "place";
    options.buildings = 8;
    if (const auto facts = writePlace(options); !facts) {
        std::fprintf(stderr, "error: seeds: %s\n", facts.error().message().c_str());
        std::exit(1);
    }
    const fs::path place = options.folder;
    const std::string subtree = contentsOf(place / "subtrees" / "0.0.0.subtree");
    write("tileset", "place", contentsOf(place / "tileset.json") + kZero + subtree);
    write("subtree", "place", "\2" + subtree);
    write("scene_file", "place", contentsOf(place / "place.scene.json"));
    write("camera_path", "place", contentsOf(place / "flight.json").substr(0, kMostBytes));
    write("lamps", "place", contentsOf(place / "lamps.geojson"));
    std::vector<fs::path> tiles;
    for (const auto& entry : fs::directory_iterator(place / "content"))
        tiles.push_back(entry.path());
    std::sort(tiles.begin(), tiles.end(), [](const fs::path& a, const fs::path& b) {
        return std::pair(fs::file_size(a), a) < std::pair(fs::file_size(b), b);
    });
    for (std::size_t i = 0; i < std::min<std::size_t>(tiles.size(), 1); ++i)
        write("glb", "place-" + std::to_string(i), contentsOf(tiles[i]));
}

} // namespace

int main(int argc, char** argv) {
    if (argc != 2) {
        std::fprintf(stderr, "usage: fuzz_seeds FOLDER\n");
        return 2;
    }
    corpus = argv[1];
    writeFamilies();
    writeUris();
    writeUrls();
    writeHeads();
    writeTables();
    writeMeshopt();
    writeDraco();
    writeSelafin();
    writeNetCdf();
    writePlacePieces();
    return 0;
}
