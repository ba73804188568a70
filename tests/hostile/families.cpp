#include "tests/hostile/families.h"

#include "streaming/features/features_read.h"
#include "streaming/image.h"
#include "streaming/subtree.h"
#include "streaming/terrain/layer_json.h"
#include "streaming/terrain/quantized_mesh_tile.h"
#include "tests/fuzz/content_promises.h"
#include "tests/fuzz/path_promises.h"
#include "tests/fuzz/tree_promises.h"
#include "tests/hostile/family_files.h"
#include "viewer/lamps_file.h"
#include "viewer/scene_file.h"

#include <cmath>

namespace gnomon::test {

namespace {

Read refused(const std::string& reason) {
    Read read;
    read.refusal = reason;
    if (reason.empty())
        read.broken = "refused without a word";
    else if (reason.find('\n') != std::string::npos)
        read.broken = "refused in more than one line";
    else if (reason.size() > 600)
        read.broken = "refused in " + std::to_string(reason.size()) + " characters";
    return read;
}
Read refused(const Error& error) {
    return refused(error.reason.empty() ? error.reason : error.message());
}
Read accepted(std::string broken = {}) {
    return {true, {}, std::move(broken)};
}

Read readContent(const std::string& text) {
    DecodeOptions options = plain();
    std::string opened;
    options.readUri = [&](const std::string& uri) -> Result<Bytes> {
        opened = uri;
        return Error{uri, "no such file"};
    };
    const Bytes exact = bytesOf(text); // of just that size, so that a sanitizer sees what is beyond
    const Result<TileContent> content = decodeContent(exact, "tile", options);
    if (!content)
        return refused(content.error());
    fuzz::checkContent(*content);
    return accepted();
}

Read readImage(const std::string& text) {
    const Bytes exact = bytesOf(text);
    ByteBudget budget(std::uint64_t(320) << 20);
    try {
        const Image image = decodeImage(exact, budget);
        const std::size_t pixels = std::size_t(image.width) * std::size_t(image.height);
        const bool whole = image.width > 0 && image.height > 0 && image.rgba.size() == 4 * pixels;
        return accepted(whole ? "" : "its pixels are not all there");
    } catch (const BadContent& bad) {
        return refused(bad.reason);
    }
}

Read treeRead(const TileTree& tree) {
    fuzz::checkTree(tree);
    fuzz::checkSelection(tree);
    return accepted();
}

Read readTileset(const std::string& text) {
    const Bytes exact = bytesOf(text);
    const Result<TileTree> tree = TileTree::parse(exact, "tileset.json", {});
    return tree ? treeRead(*tree) : refused(tree.error());
}

Read readSubtree(const std::string& text) {
    const Bytes exact = bytesOf(text);
    const auto subtree = parseSubtree(exact, "s.subtree", Subdivision::Quadtree, 3, {});
    if (!subtree)
        return refused(subtree.error());
    Result<TileTree> tree = TileTree::parse(bytesOf(implicitTileset()), "tileset.json", {});
    if (!tree)
        return accepted("the tileset it is read for is wrong");
    if (const Failure failure = tree->attachSubtree(0, *subtree))
        return refused(*failure);
    return treeRead(*tree);
}

Read readQuantized(const std::string& text) {
    const Bytes exact = bytesOf(text);
    (void)readQuantizedSummary(exact, "t");
    const Result<QuantizedTile> tile = decodeQuantizedTile(exact, "t");
    if (!tile)
        return refused(tile.error());
    const std::size_t n = tile->u.size();
    if (tile->v.size() != n || tile->height.size() != n ||
        (!tile->normals.empty() && tile->normals.size() != n) || tile->indices.size() % 3 != 0)
        return accepted("its counts do not agree");
    for (const std::uint32_t i : tile->indices)
        if (i >= n)
            return accepted("index " + std::to_string(i) + " of " + std::to_string(n));
    if (!std::isfinite(tile->heightMetres(0)) || !std::isfinite(tile->heightMetres(kQuantizedMost)))
        return accepted("its heights are not finite");
    return accepted();
}

Read readLayer(const std::string& text) {
    const Bytes exact = bytesOf(text);
    const Result<LayerJson> layer = parseLayerJson(exact, "layer.json");
    if (!layer)
        return refused(layer.error());
    if (layer->templates.empty())
        return accepted("no template");
    return accepted(layer->uriOf(3, 7, 5).size() < 100'000 ? "" : "a uri as long as it likes");
}

Read readPath(const std::string& text) {
    const Result<CameraPath> path = CameraPath::parse(text, "path.json", 45.0);
    if (!path)
        return refused(path.error());
    fuzz::checkPath(*path);
    return accepted();
}

Read readScene(const std::string& text) {
    const Result<SceneFile> scene = parseSceneFile(text, "/nowhere", "a.scene.json");
    return scene ? accepted() : refused(scene.error());
}

Read readLamps(const std::string& text) {
    const Result<LampsFile> lamps = parseLampsFile(text, "lamps.geojson");
    if (!lamps)
        return refused(lamps.error());
    for (const LampsFile::Entry& entry : lamps->entries)
        if (!std::isfinite(entry.heightMetres) ||
            !std::isfinite(length(ecefOf(entry.foot) - Point<Ecef>{})))
            return accepted("a lamp stands nowhere");
    return accepted();
}

Read featuresRead(const Failure& failure, const std::vector<RawFeatures>& layers) {
    if (failure)
        return refused(*failure);
    for (const RawFeatures& layer : layers)
        for (const Feature& feature : layer.features)
            for (const FeaturePart& part : feature.parts)
                for (const FeatureRing& ring : part)
                    for (const glm::dvec3& p : ring)
                        if (!std::isfinite(p.x) || !std::isfinite(p.y))
                            return accepted("a vertex is nowhere");
    return accepted();
}

Read readCity(const std::string& text) {
    std::vector<RawFeatures> layers;
    FeatureFile file;
    const Failure failure = readCityJson("a.city.json", text, layers, file);
    return featuresRead(failure, layers);
}

Read readTable(const std::string& text) {
    std::vector<RawFeatures> layers;
    FeatureFile file;
    const Failure failure = readCsv("a.csv", text, layers, file);
    return featuresRead(failure, layers);
}

// By way of a file, since GDAL reads files.
Read readGeoJson(const std::string& text) {
    static const OneFile file("a.geojson");
    file.write(text);
    const Result<FeatureFile> features = readFeatures(file.path(), {});
    return features ? accepted() : refused(features.error());
}

std::vector<Family> makeFamilies() {
    std::vector<Family> all;
    // A bin chunk may lack its padding, and a file the bytes that only pad it.
    all.push_back({"glb", {richGlb().text()}, readContent, true, 3000});
    all.push_back({"gltf", {gltfText()}, readContent, true, 2000});
    all.push_back({"b3dm", {b3dmText()}, readContent, true, 3000});
    all.push_back({"draco", {dracoGlb(true), dracoGlb(false)}, readContent, true, 3000});
    all.push_back({"glb-gzip", {gzippedText(richGlb().text())}, readContent, true, 2000, 8});
    all.push_back({"i3dm", {i3dmText()}, readContent, true, 3000});
    all.push_back({"pnts", {pntsText(), pntsDracoText()}, readContent, true, 3000});
    all.push_back({"cmpt", {cmptText()}, readContent, true, 3000});
    all.push_back({"meshopt", {meshoptText()}, readContent, true, 3000});
    all.push_back({"metadata", {metadataText()}, readContent, true, 3000});
    all.push_back({"png", {pngOf(16, 16, 3, std::string(768, 'k'))}, readImage, true, 2000});
    all.push_back({"jpeg", {encodedPicture("jpeg")}, readImage, true, 2000, {}});
    all.push_back({"webp", {encodedPicture("webp")}, readImage, true, 2000, {}});
    all.push_back({"tileset", {tilesetText(), implicitTileset()}, readTileset, true, 3000});
    all.push_back({"subtree", {binarySubtreeText(), jsonSubtreeText()}, readSubtree, true, 3000});
    all.push_back({"quantized", {quantizedText()}, readQuantized, true, 3000, {}});
    all.push_back({"quantized-gzip", {gzippedText(quantizedText())}, readQuantized, true, 3000, 8});
    all.push_back({"layer", {layerText()}, readLayer, true, 3000});
    all.push_back({"camera-path", {cameraPathText()}, readPath, false, 2000});
    all.push_back({"kml-tour", {kmlTourText()}, readPath, false, 2000, {}});
    all.push_back({"scene", {sceneText()}, readScene, false, 2000});
    all.push_back({"lamps", {lampsText()}, readLamps, false, 2000});
    all.push_back({"cityjson", {cityJsonText()}, readCity, false, 2000});
    all.push_back({"csv", {csvText()}, readTable, false, 2000, {}});
    all.push_back({"geojson", {geoJsonText()}, readGeoJson, false, 300});
    return all;
}

} // namespace

const std::vector<Family>& families() {
    static const std::vector<Family> all = makeFamilies();
    return all;
}

void readOneOfEach() {
    for (const Family& family : families())
        if (family.fromStrangers)
            for (const std::string& good : family.good)
                (void)family.read(good);
}

const Family& familyOf(const std::string& name) {
    for (const Family& family : families())
        if (family.name == name)
            return family;
    std::abort();
}

} // namespace gnomon::test
