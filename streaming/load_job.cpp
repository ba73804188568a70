// What one job does: from the bytes of a tile to a content, a subtree or a tileset.
#include "streaming/check_content.h"
#include "streaming/json_text.h"
#include "streaming/load_queue.h"
#include "streaming/terrain/gzip.h"

#include <exception>
#include <new>

namespace gnomon {
namespace {

// Reads what a file names, and keeps the first passing fault: a decoder may go on without a
// texture, and nobody would know that it could have been had.
struct Beside {
    const std::string& base;
    const ReadPath& read;
    std::optional<Error> passing;

    Result<Bytes> operator()(const std::string& uri) {
        const Result<std::string> path = resolveUri(base, uri);
        if (!path)
            return path.error();
        Result<Bytes> bytes = read(*path);
        if (!bytes && bytes.error().kind == ErrorKind::Transient && !passing)
            passing = bytes.error();
        return bytes;
    }
};

LoadResult contentOf(const Source& source, const LoadJob& job, const Bytes& bytes,
                     const ReadPath& read) {
    Beside beside{job.path, read, {}};
    DecodeOptions options;
    options.ecefFromTile = job.inherited.ecefFromTile;
    options.gltfUpAxis = job.inherited.gltfUpAxis;
    options.meshAxes = job.meshAxes;
    options.readUri = [&](const std::string& uri) { return beside(uri); };
    Result<TileContent> content = decodeContent(bytes, source.describe(job.path), options);
    if (beside.passing)
        return {job.tile, true, *beside.passing};
    if (!content)
        return {job.tile, false, content.error()};
    return {job.tile, false, std::make_shared<const TileContent>(std::move(*content))};
}

LoadResult subtreeOf(const LoadJob& job, const Bytes& bytes, const ReadPath& read) {
    Beside beside{job.path, read, {}};
    Result<Subtree> subtree = parseSubtree(bytes, job.path, job.subdivision, job.subtreeLevels,
                                           [&](const std::string& uri) { return beside(uri); });
    if (beside.passing)
        return {job.tile, true, *beside.passing};
    if (!subtree)
        return {job.tile, false, subtree.error()};
    return {job.tile, false, std::move(*subtree)};
}

LoadResult tilesetOf(const LoadJob& job, const Bytes& bytes) {
    Result<TileTree> tree = TileTree::parseExternal(bytes, job.path, job.inherited);
    if (!tree)
        return {job.tile, false, tree.error()};
    return {job.tile, false, std::make_unique<TileTree>(std::move(*tree))};
}

LoadResult decoded(const Source& source, const LoadJob& job, const Bytes& bytes,
                   const ReadPath& read) {
    if (job.kind == ContentKind::Subtree)
        return subtreeOf(job, bytes, read);
    if (job.kind == ContentKind::Mesh)
        return contentOf(source, job, bytes, read);
    // Whether a tileset or a glTF came is known by what is in it.
    const JsonKind kind = sniffJson(bytes);
    const bool isTileset = kind == JsonKind::Tileset ||
                           (kind != JsonKind::Gltf && job.kind == ContentKind::ExternalTileset);
    return isTileset ? tilesetOf(job, bytes) : contentOf(source, job, bytes, read);
}

LoadResult load(const Source& source, const LoadJob& job, const Result<Bytes>& bytes,
                const ReadPath& read) {
    if (!bytes)
        return {job.tile, true, bytes.error()};
    // decodeContent unpacks a mesh itself, within its budget.
    if (job.kind == ContentKind::Mesh || !isGzip(*bytes))
        return decoded(source, job, *bytes, read);
    const Result<Bytes> plain =
        gunzip(*bytes, std::size_t(mostUnpackedBytes(bytes->size())), job.path);
    if (!plain)
        return {job.tile, false, plain.error()};
    return decoded(source, job, *plain, read);
}

LoadResult make(const ContentMaker& maker, const LoadJob& job) {
    if (job.kind == ContentKind::ExternalTileset) {
        const Result<std::vector<MadeTile>> tiles = maker.below(job.path);
        Result<TileTree> tree = tiles ? TileTree::ofTiles(job.path, *tiles) : tiles.error();
        if (!tree)
            return {job.tile, false, tree.error()};
        return {job.tile, false, std::make_unique<TileTree>(std::move(*tree))};
    }
    DecodeOptions options;
    options.meshAxes = job.meshAxes;
    Result<TileContent> content = maker.make(job.path, options);
    if (!content)
        return {job.tile, false, content.error()};
    if (const auto broken = brokenPromise(*content))
        return {job.tile, false, Error{job.path, *broken}};
    return {job.tile, false, std::make_shared<const TileContent>(std::move(*content))};
}

} // namespace

LoadResult runLoadJob(const Origin& origin, const LoadJob& job, Result<Bytes> bytes,
                      const ReadPath& read) {
    LoadResult result;
    try {
        if (const auto* maker = std::get_if<std::shared_ptr<const ContentMaker>>(&origin))
            result = make(**maker, job);
        else
            result = load(*std::get<std::shared_ptr<const Source>>(origin), job, bytes, read);
    } catch (const std::bad_alloc&) {
        result = {job.tile, false, Error{job.path, "there is not enough memory to read it"}};
    } catch (const std::exception& e) {
        result = {job.tile, false, Error{job.path, e.what()}};
    }
    if (auto* error = std::get_if<Error>(&result.value); error && error->subject == job.path)
        error->subject =
            std::visit([&](const auto& from) { return from->describe(job.path); }, origin);
    return result;
}

LoadResult runLoadJob(const Origin& origin, const LoadJob& job) {
    const auto* source = std::get_if<std::shared_ptr<const Source>>(&origin);
    const auto read = [&](const std::string& path) { return (*source)->read(path); };
    return runLoadJob(origin, job, source ? read(job.path) : Result<Bytes>(Bytes{}), read);
}

} // namespace gnomon
