// Small files that ask for much. Each was built to go past a limit that HOSTILE.md sets.
#include "tests/hostile/families.h"
#include "tests/hostile/family_files.h"
#include "tests/streaming/tile_builder.h"

#include <zlib.h>

#include <array>

namespace gnomon::test {

namespace {

constexpr std::size_t kMegabyte = std::size_t(1) << 20;

// `one` again and again, up to a megabyte less what stands around it.
std::string many(const std::string& one, std::size_t around = 4096) {
    std::string out;
    while (out.size() + one.size() + around < kMegabyte)
        out += one;
    if (!out.empty() && out.back() == ',')
        out.pop_back();
    return out;
}

// zlib's stream of `bytes` zeros and more, up to whole megabytes: one megabyte's code, again and
// again.
std::string deflatedZeros(std::size_t bytes) {
    const std::string zeros(kMegabyte, '\0');
    std::string piece(4096, '\0');
    z_stream stream{};
    deflateInit2(&stream, 9, Z_DEFLATED, -MAX_WBITS, 9, Z_DEFAULT_STRATEGY);
    stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(zeros.data()));
    stream.avail_in = uInt(zeros.size());
    stream.next_out = reinterpret_cast<Bytef*>(piece.data());
    stream.avail_out = uInt(piece.size());
    deflate(&stream, Z_FULL_FLUSH); // ends at a byte and refers to nothing before it
    piece.resize(stream.total_out);
    deflateEnd(&stream);
    std::string out = "\x78\xda";
    const std::size_t pieces = (bytes + kMegabyte - 1) / kMegabyte;
    for (std::size_t i = 0; i < pieces; ++i)
        out += piece;
    out += std::string("\x03\x00", 2);                                 // an empty last block
    putBig(out, std::uint32_t(pieces * kMegabyte % 65521) << 16 | 1u); // Adler-32 of zeros
    return out;
}

// Nothing but zeros.
std::string emptyPng(std::uint32_t width, std::uint32_t height, char depth = 8, char kind = 0,
                     bool interlaced = false, std::size_t ballast = 0) {
    std::string header;
    putBig(header, width);
    putBig(header, height);
    header += {depth, kind, 0, 0, char(interlaced)};
    const std::size_t pixelBytes = std::size_t(depth / 8) * (kind == 6 ? 4 : 1);
    // Interlaced, each of seven passes has rows of its own: one more byte each.
    const std::size_t bytes = (width * pixelBytes + (interlaced ? 2 : 1)) * height;
    return "\x89PNG\r\n\x1a\n" + pngChunk("IHDR", header) +
           (ballast > 0 ? pngChunk("juNk", std::string(ballast, ' ')) : "") +
           pngChunk("IDAT", deflatedZeros(bytes)) + pngChunk("IEND", "");
}

std::string glbWithImages(const std::string& image, int count) {
    GlbBuilder builder;
    builder.triangles(boxCorners(glm::vec3(0.0f), glm::vec3(1.0f)), boxTriangles());
    const int view = builder.view(image.data(), image.size());
    const Json primitive = builder.root["meshes"][0]["primitives"][0];
    builder.root["meshes"][0]["primitives"] = Json::array();
    for (int i = 0; i < count; ++i) { // one picture, told of as many
        builder.root["images"].push_back({{"bufferView", view}});
        builder.root["textures"].push_back({{"source", i}});
        builder.root["materials"].push_back(
            {{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", i}}}}}});
        Json one = primitive;
        one["material"] = i;
        builder.root["meshes"][0]["primitives"].push_back(one);
    }
    return builder.text();
}

void word16(std::string& out, unsigned value) {
    out += {char(value >> 8), char(value)};
}

// A progressive JPEG may have any number of scans, and each goes over the whole picture: here of 50
// million pixels, which a megabyte may just ask for (1 : 200).
std::string manyScansJpeg(std::size_t most, int components) {
    constexpr unsigned kWidth = 8192, kHeight = 6080;
    std::string out = "\xff\xd8\xff\xdb";
    word16(out, 67);
    out += '\0' + std::string(64, '\1'); // quantisation
    out += "\xff\xc2";                   // progressive
    word16(out, unsigned(8 + 3 * components));
    out += 8;
    word16(out, kHeight);
    word16(out, kWidth);
    out += char(components);
    for (int c = 1; c <= components; ++c)
        out += {char(c), 0x11, 0};
    const auto table = [&](char which, char symbol) { // one code, of one bit
        out += "\xff\xc4";
        word16(out, 20);
        out += which;
        out += '\1' + std::string(15, '\0');
        out += symbol;
    };
    table(0x00, 0x00);       // DC: no difference
    table(0x10, char(0xe0)); // AC: a run of 2^14 … 2^15 - 1 empty blocks
    const auto scan = [&](int from, int to, char first, char last) {
        out += "\xff\xda";
        word16(out, unsigned(6 + 2 * (to - from + 1)));
        out += char(to - from + 1);
        for (int c = from; c <= to; ++c)
            out += {char(c), 0x00};
        out += {first, last, 0};
    };
    const unsigned blocks = kWidth / 8 * (kHeight / 8);
    scan(1, components, 0, 0);
    out += std::string(blocks * unsigned(components) / 8, '\0');
    // Each run: a 0 for the code, fourteen 0s for its length 2^14.
    const std::size_t runs = blocks / (1u << 14) + 1;
    const std::string empty((15 * runs + 7) / 8, '\0');
    for (std::size_t i = 1; i < most && out.size() + 10 + empty.size() + 2 < kMegabyte; ++i) {
        scan(1, 1, 1, 63);
        out += empty;
    }
    while (most < kMegabyte && out.size() + 0x10001 < kMegabyte) { // comments, as ballast
        out += "\xff\xfe";
        word16(out, 0xffff);
        out += std::string(0xfffd, ' ');
    }
    return out + "\xff\xd9";
}

// Lossless, of one colour: its codes have one symbol each and its pixels take no bits at all.
std::string emptyWebp(std::uint32_t width, std::uint32_t height, std::size_t ballast) {
    std::string image = "\x2f";
    put(image, (width - 1) | (height - 1) << 14);
    // No transform, cache or further codes; five simple codes (1) of one symbol (0), of one bit
    // (0), which is 0.
    std::uint32_t bits = 0;
    for (int code = 0; code < 5; ++code)
        bits |= 1u << (3 + 4 * code);
    put(image, bits);
    image.resize(16);
    std::string out = "RIFF";
    put(out, std::uint32_t(4 + 8 + image.size() + 8 + ballast));
    out += "WEBPVP8L";
    put(out, std::uint32_t(image.size()));
    out += image + "junk";
    put(out, std::uint32_t(ballast));
    return out + std::string(ballast, ' ');
}

std::string glbOfJson(const std::string& json) {
    return GlbBuilder::glbOf(json, "");
}

void addGltf(std::vector<Bomb>& all) {
    const auto add = [&](const char* name, std::string bytes) {
        all.push_back({name, &familyOf("glb"), std::move(bytes)});
    };
    const auto instanced = [](std::uint64_t count) {
        GlbBuilder builder = richGlb();
        builder.root["accessors"].push_back(
            {{"componentType", 5126}, {"count", count}, {"type", "VEC3"}});
        builder.root["nodes"][1]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]
                    ["TRANSLATION"] = builder.root["accessors"].size() - 1;
        return builder;
    };
    add("50 million instances", instanced(50'000'000).text());
    add("800 thousand instances of a box", instanced(800'000).text());
    GlbBuilder shared = instanced(100'000);
    for (int i = 0; i < 200; ++i) {
        shared.root["nodes"].push_back(shared.root["nodes"][1]);
        shared.root["scenes"][0]["nodes"].push_back(shared.root["nodes"].size() - 1);
    }
    add("200 nodes of 100 thousand instances", shared.text());

    GlbBuilder empty = richGlb();
    empty.root["accessors"].push_back(
        {{"componentType", 5126}, {"count", 4000000000u}, {"type", "VEC3"}});
    Json& primitive = empty.root["meshes"][0]["primitives"][0];
    primitive.erase("indices");
    primitive["attributes"] = {{"POSITION", empty.root["accessors"].size() - 1}};
    add("an accessor of 4 billion zeros", empty.text());

    GlbBuilder again; // one buffer, drawn by thousands of primitives
    std::vector<float> corners;
    for (int i = 0; i < 60'000; ++i)
        corners.push_back(float(i * 7919 % 1009));
    const int positions = again.floats(corners, "VEC3");
    Json all60 = Json::array();
    for (int i = 0; i < 10'000; ++i)
        all60.push_back({{"attributes", {{"POSITION", positions}}}});
    again.root["meshes"].push_back({{"primitives", all60}});
    again.node({{"mesh", 0}});
    add("10 thousand primitives of one buffer", again.text());

    for (const char* key : {"accessors", "bufferViews", "materials", "meshes", "nodes", "samplers",
                            "scenes", "textures", "images", "buffers"})
        add(key, glbOfJson("{\"asset\":{\"version\":\"2.0\"},\"" + std::string(key) + "\":[" +
                           many("{},") + "]}"));
    add("as many empty arrays",
        glbOfJson("{\"asset\":{\"version\":\"2.0\"},\"extras\":[" + many("[],") + "]}"));
    add("nested a million deep", glbOfJson(many("[")));
    add("nested in extras", glbOfJson("{\"asset\":{\"version\":\"2.0\"},\"extras\":" + many("[")));
    add("24 pictures of 16 MB in one", glbWithImages(emptyPng(2048, 2048), 24));
    add("200 pictures of 16 MB in one", glbWithImages(emptyPng(2048, 2048), 200));
}

void addPictures(std::vector<Bomb>& all) {
    all.push_back({"8192 x 8192 zeros", &familyOf("png"), emptyPng(8192, 8192)});
    all.push_back({"8192 x 512 zeros", &familyOf("png"), emptyPng(8192, 512)});
    all.push_back({"50 million pixels of 8 bytes, interlaced", &familyOf("png"),
                   emptyPng(8192, 6080, 16, 6, true, 600'000)});
    all.push_back(
        {"2048 x 2048 zeros, interlaced", &familyOf("png"), emptyPng(2048, 2048, 8, 0, true)});
    all.push_back({"as many scans as fit", &familyOf("jpeg"), manyScansJpeg(kMegabyte, 1)});
    all.push_back({"a hundred scans", &familyOf("jpeg"), manyScansJpeg(100, 1)});
    std::string jpeg = "\xff\xd8\xff\xc0"; // start of frame: 65535 x 65535
    jpeg += std::string("\0\x11\x08\xff\xff\xff\xff\3", 8) + std::string(60, '\1');
    all.push_back({"65535 x 65535", &familyOf("jpeg"), jpeg});
    all.push_back({"50 million pixels in colour", &familyOf("jpeg"), manyScansJpeg(3, 3)});
    all.push_back({"16384 x 16384", &familyOf("webp"), emptyWebp(16384, 16384, 100)});
    all.push_back({"4 million pixels", &familyOf("webp"), emptyWebp(2048, 2048, 100)});
    all.push_back({"50 million pixels", &familyOf("webp"), emptyWebp(8192, 6080, 1'040'000)});
}

void addDraco(std::vector<Bomb>& all) {
    for (const bool edgebreaker : {false, true}) {
        const std::string glb = dracoGlb(edgebreaker);
        const std::size_t start = glb.find("DRACO");
        // Counts begin after the 11 bytes of the header (and edgebreaker's traversal type); the
        // accessors lie along with them.
        for (const bool lyingAccessors : {false, true}) {
            std::string bomb = glb;
            bomb.replace(start + 11 + edgebreaker, 10,
                         std::string("\xff\xff\xff\xff\x0f\xff\xff\xff\xff\x0f", 10));
            Json json = Json::parse(bomb.substr(20, bomb.find("BIN") - 24));
            if (lyingAccessors)
                for (Json& accessor : json["accessors"])
                    accessor["count"] = 4'000'000'000u;
            all.push_back({std::string(edgebreaker ? "edgebreaker" : "sequential") +
                               " of 4 billion faces" + (lyingAccessors ? ", accessors too" : ""),
                           &familyOf("draco"),
                           GlbBuilder::glbOf(json.dump(), bomb.substr(bomb.find("BIN") + 4))});
        }
    }
}

void addTiles(std::vector<Bomb>& all) {
    std::string nested = pntsText();
    while (nested.size() < 200'000) // quadratic for us, too
        nested = cmptOf({nested});
    all.push_back({"nested twelve thousand deep", &familyOf("cmpt"), nested});
    std::string part = "glTF"; // the shortest there is, 20 bytes and its JSON
    const std::string json = R"({"asset":{"version":"2.0"}}  )";
    put(part, 2);
    put(part, std::uint32_t(20 + json.size()));
    put(part, std::uint32_t(json.size()));
    part += "JSON" + json;
    all.push_back({"as many parts", &familyOf("cmpt"),
                   cmptOf(std::vector<std::string>(kMegabyte / part.size() - 1, part))});
    std::string lie = cmptOf({part});
    lie.replace(12, 4, "\xff\xff\xff\xff");
    all.push_back({"more parts than there are", &familyOf("cmpt"), lie});
    const auto counted = [](std::string text, const std::string& from, const std::string& to) {
        return text.replace(text.find(from), from.size(), to); // as long, so that no length lies
    };
    all.push_back({"9 instances where 2 are", &familyOf("i3dm"),
                   counted(i3dmText(), R"("INSTANCES_LENGTH":2)", R"("INSTANCES_LENGTH":9)")});
    all.push_back({"9 points where 4 are", &familyOf("pnts"),
                   counted(pntsText(), R"("POINTS_LENGTH":4)", R"("POINTS_LENGTH":9)")});
    std::vector<float> positions;
    for (int i = 0; i < 80'000; ++i)
        positions.insert(positions.end(), {0.0f, 0.0f, float(i)});
    TileFile instances = i3dmOf(80'000, richGlb().text());
    instances.features.add("POSITION", positions);
    all.push_back({"80 thousand instances of a box", &familyOf("i3dm"), instances.text()});
    all.push_back({"80 thousand points", &familyOf("pnts"), pntsOf(positions).text()});
    TileFile none = i3dmOf(4'000'000'000u, richGlb().text());
    none.features.json["POSITION"] = Json::array();
    all.push_back({"4 billion instances", &familyOf("i3dm"), none.text()});
    all.push_back({"50 MB of blanks before a brace", &familyOf("glb-gzip"),
                   gzippedText(std::string(std::size_t(50) << 20, ' ') + "{}")});
    all.push_back({"200 MB of blanks", &familyOf("glb-gzip"),
                   gzippedText(std::string(std::size_t(200) << 20, ' '))});
    const auto packedTable = [&](const char* name, const std::string& head, const std::string& one,
                                 const std::string& tail) {
        std::string table = head;
        while (table.size() + 100'000 < std::size_t(32) << 20)
            table += one;
        table.pop_back(); // the comma
        all.push_back(
            {name, &familyOf("glb-gzip"),
             gzippedText(b3dmOf(richGlb().text(), R"({"BATCH_LENGTH":1}   )", table + tail))});
    };
    packedTable("16 million values for one row", "{\"a\":[", "0,", "]}");
    packedTable("a reference of 16 million values", "{\"a\":{\"b\":[", "0,", "]}}");
    packedTable("6 million columns", "{", "\"\":0,", "}");
}

// A tile with this batch table, and with a glTF inside that names its rows.
std::string b3dmWith(const std::string& batchTable) {
    return b3dmOf(richGlb().text(), R"({"BATCH_LENGTH":100000} )", batchTable);
}

void addTables(std::vector<Bomb>& all) {
    const auto add = [&](const char* name, const std::string& table) {
        all.push_back({name, &familyOf("b3dm"), b3dmWith(table)});
    };
    add("a column of half a million numbers", "{\"a\":[" + many("1,") + "]}");
    add("as many columns", [] {
        std::string text = "{";
        for (int i = 0; text.size() + 5000 < kMegabyte; ++i)
            text += (i ? ",\"" : "\"") + std::to_string(i) + "\":[]";
        return text + "}";
    }());
    add("one value of a megabyte", "{\"a\":[[" + many("1,") + "],2]}");
    add("a table nested without end", "{\"a\":" + many("["));
    // Each of thirty instances has all of the next thirty for parents: 30^30 ways up.
    constexpr int kWide = 30, kDeep = 30;
    std::string classIds, counts, parents;
    for (int i = 0; i < kWide * kDeep; ++i) {
        const bool last = i >= kWide * (kDeep - 1);
        classIds += i ? ",0" : "0";
        counts += (i ? "," : "") + std::to_string(last ? 0 : kWide);
        for (int k = 0; k < kWide && !last; ++k)
            parents += (parents.empty() ? "" : ",") + std::to_string((i / kWide + 1) * kWide + k);
    }
    const auto hierarchy = [](const std::string& ids, const std::string& parentCounts,
                              const std::string& parentIds, int n) {
        return R"({"extensions":{"3DTILES_batch_table_hierarchy":{"classes":[{"name":"c","length":)" +
               std::to_string(n) + R"(,"instances":{}}],"instancesLength":)" + std::to_string(n) +
               R"(,"classIds":[)" + ids + R"(],"parentCounts":[)" + parentCounts +
               R"(],"parentIds":[)" + parentIds + "]}}}";
    };
    add("parents that multiply", hierarchy(classIds, counts, parents, kWide * kDeep));
    add("parents in a ring", hierarchy("0,0,0", "1,1,1", "1,2,0", 3));

    // Properties of a glTF that ask for more than the file has.
    for (const auto& [name, from, to] :
         {std::tuple("4 billion rows", R"("count":2,"properties")",
                     R"("count":4294967294,"properties")"),
          {"2^63 rows", R"("count":2,"properties")", R"("count":9223372036854775807,"properties")"},
          {"an array of 2^40", R"("array":true)", R"("array":true,"count":1099511627776)"}}) {
        const std::string good = metadataText();
        Json json = Json::parse(good.substr(20, good.find("BIN") - 24));
        std::string text = json.dump();
        const std::size_t at = text.find(from);
        if (at != std::string::npos)
            text.replace(at, std::string(from).size(), to);
        all.push_back({name, &familyOf("metadata"),
                       GlbBuilder::glbOf(text, good.substr(good.find("BIN") + 4))});
    }
}

void addMeshopt(std::vector<Bomb>& all) {
    const std::string good = meshoptText();
    const std::string bin = good.substr(good.find("BIN") + 4);
    const Json json = Json::parse(good.substr(20, good.find("BIN") - 24));
    Json large = json; // 100 GB of zeros' worth of vertices
    Json& view = large["bufferViews"][0];
    view["byteLength"] = 400'000'000ull * 256;
    Json& packed = view["extensions"]["EXT_meshopt_compression"];
    packed["count"] = 400'000'000;
    packed["byteStride"] = 256;
    large["buffers"][1]["byteLength"] = std::uint64_t(1) << 40;
    all.push_back({"400 million elements of 256 bytes", &familyOf("meshopt"),
                   GlbBuilder::glbOf(large.dump(), bin)});
    packed["count"] = 1'000'000;
    view["byteLength"] = 256'000'000;
    all.push_back({"a million elements of 256 bytes", &familyOf("meshopt"),
                   GlbBuilder::glbOf(large.dump(), bin)});
    Json again = json; // the same bytes, told of as thousands of views, all of them used
    for (int i = 0; i < 1500; ++i) {
        again["bufferViews"].push_back(json["bufferViews"][0]);
        Json accessor = json["accessors"][0];
        accessor["bufferView"] = again["bufferViews"].size() - 1;
        again["accessors"].push_back(accessor);
        Json primitive = json["meshes"][0]["primitives"][0];
        primitive["attributes"]["POSITION"] = again["accessors"].size() - 1;
        again["meshes"][0]["primitives"].push_back(primitive);
    }
    all.push_back({"1500 views", &familyOf("meshopt"), GlbBuilder::glbOf(again.dump(), bin)});
}

void addTrees(std::vector<Bomb>& all) {
    const auto add = [&](const char* name, std::string root) {
        all.push_back({name, &familyOf("tileset"),
                       R"({"asset":{"version":"1.1"},"geometricError":1,"root":)" + root + "}"});
    };
    const std::string sphere = R"("boundingVolume":{"sphere":[0,0,0,1]},"geometricError":1)";
    add("as many children as fit", "{" + sphere + R"(,"children":[)" +
                                       many(R"({"boundingVolume":{"sphere":[0,0,0,1]}},)") + "]}");
    add("as many numbers for children", "{" + sphere + R"(,"children":[)" + many("1,") + "]}");
    add("as many contents", "{" + sphere + R"(,"contents":[)" + many(R"({"uri":"a"},)") + "]}");
    add("nested without end", many("{" + sphere + R"(,"children":[)"));
    all.push_back({"brackets", &familyOf("tileset"), many("[")});
    all.push_back({"as many extensions", &familyOf("tileset"),
                   R"({"asset":{"version":"1.1"},"extensionsUsed":[)" + many("\"a\",") +
                       R"(],"geometricError":1,"root":{)" + sphere + "}}"});
    std::string deep = implicitTileset();
    deep.replace(deep.find("\"subtreeLevels\":3"), 17, "\"subtreeLevels\":30");
    all.push_back({"subtrees of 30 levels", &familyOf("tileset"), deep});
    all.push_back({"as many contents a tile", &familyOf("subtree"),
                   R"({"tileAvailability":{"constant":1},"contentAvailability":[)" +
                       many(R"({"constant":1},)") + "]}"});
    all.push_back({"as many bufferViews", &familyOf("subtree"),
                   R"({"tileAvailability":{"bitstream":0},"bufferViews":[)" + many("{},") + "]}"});
}

void addTerrain(std::vector<Bomb>& all) {
    std::string big = quantizedText();
    big.resize(std::size_t(130) << 20);
    for (int i = 0; i < 4; ++i)
        big[88 + std::size_t(i)] = char(20'000'000u >> (8 * i));
    all.push_back({"20 million vertices", &familyOf("quantized-gzip"), gzippedText(big)});
    big.resize(std::size_t(30) << 20);
    for (int i = 0; i < 4; ++i)
        big[88 + std::size_t(i)] = char(4'000'000u >> (8 * i));
    all.push_back({"4 million vertices", &familyOf("quantized-gzip"), gzippedText(big)});
    const std::string head = R"({"format":"quantized-mesh-1.0","tiles":["{z}"],)";
    all.push_back(
        {"as many levels", &familyOf("layer"), head + R"("available":[)" + many("[],") + "]}"});
    all.push_back({"as many templates", &familyOf("layer"),
                   R"({"format":"quantized-mesh-1.0","tiles":[)" + many("\"\",") + "]}"});
    const std::string half(kMegabyte / 2 - 200, 'v');
    all.push_back({"a version put in as often as it fits", &familyOf("layer"),
                   R"({"format":"quantized-mesh-1.0","version":")" + half + R"(","tiles":[")" +
                       many("{version}", kMegabyte / 2) + "\"]}"});
}

void addLocal(std::vector<Bomb>& all) {
    const auto add = [&](const char* family, const char* name, std::string bytes) {
        all.push_back({name, &familyOf(family), std::move(bytes)});
    };
    add("camera-path", "brackets", many("["));
    add("camera-path", "as many keyframes", R"({"keyframes":[)" + many("{},") + "]}");
    add("kml-tour", "as many tags", "<kml>" + many("<a>"));
    add("kml-tour", "an entity of entities", [] {
        std::string text = "<?xml version=\"1.0\"?><!DOCTYPE kml [<!ENTITY a \"aaaaaaaaaa\">";
        for (char c = 'b'; c <= 'z'; ++c) {
            text += std::string("<!ENTITY ") + c + " \"";
            for (int i = 0; i < 10; ++i)
                text += std::string("&") + char(c - 1) + ";";
            text += "\">";
        }
        return text + "]><kml><gx:Tour><gx:Playlist>&z;</gx:Playlist></gx:Tour></kml>";
    }());
    add("scene", "brackets", many("["));
    add("scene", "as many layers", R"({"layers":[)" + many(R"({"model":"a"},)") + "]}");
    add("scene", "as many unknown keys", R"({"layers":[{"model":"a")" + many(R"(,"x":1)") + "}]}");
    add("lamps", "brackets", many("["));
    add("cityjson", "brackets", R"({"type":"CityJSON","CityObjects":)" + many("["));
    add("cityjson", "as many objects",
        R"({"type":"CityJSON","vertices":[],"CityObjects":{"a":{"geometry":[)" + many("{},") +
            "]}}}");
    add("csv", "as many columns", many("x,") + "\n" + "1,2\n");
    add("csv", "as many lines", many("1,2\n"));
    add("csv", "one quoted line", "\"" + many("x,"));
}

} // namespace

const std::vector<Bomb>& bombs() {
    static const std::vector<Bomb> made = [] {
        std::vector<Bomb> all;
        addGltf(all);
        addPictures(all);
        addDraco(all);
        addTiles(all);
        addTables(all);
        addMeshopt(all);
        addTrees(all);
        addTerrain(all);
        addLocal(all);
        return all;
    }();
    return made;
}

} // namespace gnomon::test
