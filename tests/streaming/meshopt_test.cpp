// EXT_meshopt_compression: every mode and filter, and what lies about itself.
#include "glb_builder.h"

#include <gtest/gtest.h>
#include <meshoptimizer.h>

#include <algorithm>
#include <cmath>

namespace gnomon {

using namespace test;

namespace {

std::string text(const std::vector<unsigned char>& bytes) {
    return std::string(bytes.begin(), bytes.end());
}

template <class T>
std::string encodeVertices(const std::vector<T>& values, std::size_t stride) {
    const std::size_t count = values.size() * sizeof(T) / stride;
    std::vector<unsigned char> out(meshopt_encodeVertexBufferBound(count, stride));
    out.resize(meshopt_encodeVertexBuffer(out.data(), out.size(), values.data(), count, stride));
    return text(out);
}

std::string encodeTriangles(const std::vector<unsigned>& indices, std::size_t vertices) {
    std::vector<unsigned char> out(meshopt_encodeIndexBufferBound(indices.size(), vertices));
    out.resize(meshopt_encodeIndexBuffer(out.data(), out.size(), indices.data(), indices.size()));
    return text(out);
}

std::string encodeSequence(const std::vector<unsigned>& indices, std::size_t vertices) {
    std::vector<unsigned char> out(meshopt_encodeIndexSequenceBound(indices.size(), vertices));
    out.resize(meshopt_encodeIndexSequence(out.data(), out.size(), indices.data(), indices.size()));
    return text(out);
}

// A glb whose views are compressed; buffer 1 is the one nobody needs.
class PackedBuilder : public GlbBuilder {
  public:
    std::string extension = "EXT_meshopt_compression";

    int packed(const std::string& data, std::size_t count, std::size_t stride,
               const std::string& mode, const std::string& filter = "") {
        const int index = view(data.data(), data.size());
        Json& entry = root["bufferViews"][std::size_t(index)];
        Json meshopt = {{"buffer", 0},
                        {"byteOffset", entry["byteOffset"]},
                        {"byteLength", data.size()},
                        {"byteStride", stride},
                        {"count", count},
                        {"mode", mode}};
        if (!filter.empty()) {
            meshopt["filter"] = filter;
        }
        entry = {{"buffer", 1}, {"byteLength", count * stride}};
        if (mode == "ATTRIBUTES") {
            entry["byteStride"] = stride;
        }
        entry["extensions"][extension] = std::move(meshopt);
        return index;
    }
    int accessorOf(int view, std::size_t count, int componentType, const std::string& type,
                   bool normalized = false) {
        root["accessors"].push_back({{"bufferView", view},
                                     {"componentType", componentType},
                                     {"count", count},
                                     {"type", type},
                                     {"normalized", normalized}});
        return int(root["accessors"].size()) - 1;
    }
    Json& meshoptOf(int view) {
        return root["bufferViews"][std::size_t(view)]["extensions"][extension];
    }
    std::string packedText() const {
        Json whole = root;
        whole["extensionsRequired"] = {extension};
        whole["buffers"] = Json::array({{{"byteLength", bin.size()}}, {{"byteLength", 100000}}});
        whole["buffers"][1]["extensions"][extension]["fallback"] = true;
        return glbOf(whole.dump(), bin);
    }
};

const std::vector<float> kPositions{0, 0, 0, 4, 0, 0, 0, 5, 0, 0, 0, 6};
const std::vector<unsigned> kFaces{0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3};

struct Tetrahedron : PackedBuilder {
    int positions = 0, faces = 0;

    explicit Tetrahedron(const std::string& name = "EXT_meshopt_compression") {
        extension = name;
        positions = packed(encodeVertices(kPositions, 12), 4, 12, "ATTRIBUTES");
        faces = packed(encodeTriangles(kFaces, 4), 12, 4, "TRIANGLES");
        const int position = accessorOf(positions, 4, 5126, "VEC3");
        node({{"mesh", mesh({{"attributes", {{"POSITION", position}}},
                             {"indices", accessorOf(faces, 12, 5125, "SCALAR")}})}});
    }
    Json& primitive() { return root["meshes"][0]["primitives"][0]; }
};

std::vector<glm::dvec3> cornersOf(const Result<TileContent>& content) {
    std::vector<glm::dvec3> out;
    if (!content) {
        ADD_FAILURE() << content.error().message();
        return out;
    }
    for (const Mesh& mesh : content->meshes) {
        for (const std::uint32_t i : mesh.indices) {
            out.push_back(vertex(mesh, i));
        }
    }
    return out;
}

void expectTetrahedron(const Result<TileContent>& content) {
    const auto corners = cornersOf(content);
    EXPECT_EQ(corners.size(), 12u);
    EXPECT_EQ(content ? content->facts.closedTriangles : 0, 4u);
    for (const glm::dvec3 wanted : {glm::dvec3(0), {4, 0, 0}, {0, 5, 0}, {0, 0, 6}}) {
        EXPECT_EQ(std::count_if(corners.begin(), corners.end(),
                                [&](const auto& c) { return glm::distance(c, wanted) < 1e-6; }),
                  3);
    }
}

std::string reasonOf(const PackedBuilder& builder) {
    const auto content = decode(builder.packedText());
    return content ? std::string("it opened") : content.error().reason;
}

} // namespace

TEST(Meshopt, ReadsAttributesAndTrianglesByEitherName) {
    expectTetrahedron(decode(Tetrahedron().packedText()));
    expectTetrahedron(decode(Tetrahedron("KHR_meshopt_compression").packedText()));
}

TEST(Meshopt, ReadsIndexSequencesOfBothSizes) {
    for (const std::size_t size : {2u, 4u}) {
        Tetrahedron builder;
        const int view = builder.packed(encodeSequence(kFaces, 4), 12, size, "INDICES");
        builder.primitive()["indices"] =
            builder.accessorOf(view, 12, size == 2 ? 5123 : 5125, "SCALAR");
        expectTetrahedron(decode(builder.packedText()));
    }
}

TEST(Meshopt, ReadsTrianglesOf16Bits) {
    Tetrahedron builder;
    const int view = builder.packed(encodeTriangles(kFaces, 4), 12, 2, "TRIANGLES");
    builder.primitive()["indices"] = builder.accessorOf(view, 12, 5123, "SCALAR");
    expectTetrahedron(decode(builder.packedText()));
}

TEST(Meshopt, TheExponentialFilterGivesFloats) {
    Tetrahedron builder;
    std::vector<float> packed(kPositions.size());
    meshopt_encodeFilterExp(packed.data(), 4, 12, 24, kPositions.data());
    const int view = builder.packed(encodeVertices(packed, 12), 4, 12, "ATTRIBUTES", "EXPONENTIAL");
    builder.primitive()["attributes"]["POSITION"] = builder.accessorOf(view, 4, 5126, "VEC3");
    expectTetrahedron(decode(builder.packedText()));
}

TEST(Meshopt, TheOctahedralFilterGivesNormalsOf8And16Bits) {
    const std::vector<float> normals{0.6f,  0,    0.8f, 0, 0, 0,     1,    0,
                                     -0.6f, 0.8f, 0,    0, 0, -0.8f, 0.6f, 0};
    for (const std::size_t stride : {4u, 8u}) {
        Tetrahedron builder;
        std::vector<unsigned char> packed(4 * stride);
        meshopt_encodeFilterOct(packed.data(), 4, stride, stride == 4 ? 8 : 16, normals.data());
        const int view =
            builder.packed(encodeVertices(packed, stride), 4, stride, "ATTRIBUTES", "OCTAHEDRAL");
        builder.primitive()["attributes"]["NORMAL"] =
            builder.accessorOf(view, 4, stride == 4 ? 5120 : 5122, "VEC3", true);
        // One triangle alone, which is open, so that no normal is turned outward.
        builder.primitive()["indices"] = builder.indices({0, 1, 2});
        const auto content = decode(builder.packedText());
        ASSERT_TRUE(content) << content.error().message();
        const Mesh& mesh = content->meshes.at(0);
        for (std::size_t i = 0; i < 3; ++i) {
            const glm::dvec3 at = vertex(mesh, i);
            const std::size_t from = at.x > 1 ? 1 : at.y > 1 ? 2 : 0;
            const glm::dvec3 wanted(normals[4 * from], normals[4 * from + 1],
                                    normals[4 * from + 2]);
            EXPECT_GT(glm::dot(decodeOct(mesh.normals[i]), wanted), stride == 4 ? 0.999 : 0.999999);
        }
    }
}

TEST(Meshopt, TheQuaternionFilterTurnsInstances) {
    Tetrahedron builder;
    const float h = std::sqrt(0.5f);
    const std::vector<float> turns{0, 0, h, h}; // a quarter about z
    std::vector<std::int16_t> packed(4);
    meshopt_encodeFilterQuat(packed.data(), 1, 8, 16, turns.data());
    const int view = builder.packed(encodeVertices(packed, 8), 1, 8, "ATTRIBUTES", "QUATERNION");
    builder.root["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"]["ROTATION"] =
        builder.accessorOf(view, 1, 5122, "VEC4", true);
    const auto corners = cornersOf(decode(builder.packedText()));
    for (const glm::dvec3 wanted : {glm::dvec3(0, 4, 0), {-5, 0, 0}, {0, 0, 6}}) {
        EXPECT_TRUE(std::any_of(corners.begin(), corners.end(),
                                [&](const auto& c) { return glm::distance(c, wanted) < 1e-3; }));
    }
}

TEST(Meshopt, TheFallbackBufferIsNeverFetched) {
    Tetrahedron builder;
    Json whole = builder.root;
    whole["extensionsUsed"] = {builder.extension};
    whole["buffers"] = Json::array({{{"byteLength", builder.bin.size()}, {"uri", "packed.bin"}},
                                    {{"byteLength", 100000}, {"uri", "plain.bin"}}});
    whole["buffers"][1]["extensions"][builder.extension]["fallback"] = true;
    DecodeOptions options = plain();
    std::vector<std::string> asked;
    options.readUri = [&](const std::string& uri) -> Result<Bytes> {
        asked.push_back(uri);
        return bytesOf(builder.bin);
    };
    expectTetrahedron(decode(whole.dump(), options));
    EXPECT_EQ(asked, std::vector<std::string>{"packed.bin"});
}

TEST(Meshopt, CountsAndStridesThatCannotBeAreRefusedFirst) {
    const auto refused = [](const char* key, const Json& value, const char* reason) {
        Tetrahedron builder;
        builder.meshoptOf(builder.positions)[key] = value;
        EXPECT_NE(reasonOf(builder).find(reason), std::string::npos)
            << key << ": " << reasonOf(builder);
    };
    refused("count", 18446744073709551615ull, "would need more memory");
    refused("count", 1000000000, "would need more memory");
    refused("count", -1, "malformed EXT_meshopt_compression");
    refused("count", 1000000, "damaged data of mode ATTRIBUTES");
    refused("byteStride", 0, "elements of 0 bytes");
    refused("byteStride", 6, "elements of 6 bytes");
    refused("byteStride", 260, "elements of 260 bytes");
    refused("byteLength", 100000, "lies outside its buffer");
    refused("byteOffset", 18446744073709551615ull, "lies outside its buffer");
    refused("byteLength", 0, "damaged data");
    refused("buffer", 7, "lies outside its buffer");
    refused("buffer", 1, "lies outside its buffer");
    refused("mode", "SOMEHOW", "mode SOMEHOW does not exist");
    refused("filter", "COLOR", "filter COLOR is not supported");
    refused("filter", "OCTAHEDRAL", "does not go with elements of 12 bytes");
    refused("filter", "QUATERNION", "does not go with elements of 12 bytes");
    Tetrahedron builder;
    builder.meshoptOf(builder.faces)["filter"] = "EXPONENTIAL";
    EXPECT_NE(reasonOf(builder).find("in mode TRIANGLES"), std::string::npos);
    builder = Tetrahedron();
    builder.meshoptOf(builder.faces)["count"] = 11;
    EXPECT_NE(reasonOf(builder).find("no whole triangles"), std::string::npos);
    builder = Tetrahedron();
    builder.meshoptOf(builder.faces)["byteStride"] = 8;
    EXPECT_NE(reasonOf(builder).find("elements of 8 bytes"), std::string::npos);
}

TEST(Meshopt, ANewerCodingIsRefusedByItsVersion) {
    Tetrahedron builder("KHR_meshopt_compression");
    const std::size_t at = builder.meshoptOf(builder.positions)["byteOffset"];
    builder.bin[at] = char(0xa1);
    EXPECT_NE(reasonOf(builder).find("version 1 of mode ATTRIBUTES is not supported"),
              std::string::npos);
}

TEST(Meshopt, IndicesAreCheckedAfterDecompression) {
    Tetrahedron builder;
    std::vector<unsigned> faces = kFaces;
    faces[5] = 4;
    const int view = builder.packed(encodeTriangles(faces, 5), 12, 4, "TRIANGLES");
    builder.primitive()["indices"] = builder.accessorOf(view, 12, 5125, "SCALAR");
    EXPECT_EQ(reasonOf(builder), "index 4 of 4 vertices");
}

TEST(Meshopt, AccessorsAreHeldAgainstWhatCameOut) {
    Tetrahedron builder;
    builder.root["accessors"][0]["count"] = 5;
    EXPECT_NE(reasonOf(builder).find("lies outside its bufferView"), std::string::npos);
}

TEST(Meshopt, DataCutAnywhereOrWithAnyByteChangedNeverCrashes) {
    const Tetrahedron whole;
    for (const int view : {whole.positions, whole.faces}) {
        Tetrahedron builder;
        const std::size_t offset = builder.meshoptOf(view)["byteOffset"];
        const std::size_t length = builder.meshoptOf(view)["byteLength"];
        for (std::size_t n = 0; n < length; ++n) {
            builder.meshoptOf(view)["byteLength"] = n;
            EXPECT_NE(reasonOf(builder).find("damaged data"), std::string::npos) << n;
        }
        builder.meshoptOf(view)["byteLength"] = length;
        for (std::size_t i = 0; i < length; ++i) {
            for (const int bit : {0, 3, 7}) {
                Tetrahedron changed;
                changed.bin[offset + i] = char(changed.bin[offset + i] ^ (1 << bit));
                EXPECT_NE(reasonOf(changed), "");
            }
        }
    }
}

} // namespace gnomon
