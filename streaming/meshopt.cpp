#include "streaming/meshopt.h"

#include <meshoptimizer.h>

namespace gnomon {

namespace {

[[noreturn]] void bad(const std::string& reason) {
    throw BadContent{"meshopt compression: " + reason};
}

enum class Mode { Attributes, Triangles, Indices };
enum class Filter { None, Octahedral, Quaternion, Exponential };

Mode modeOf(const std::string& name) {
    if (name == "ATTRIBUTES") {
        return Mode::Attributes;
    }
    if (name == "TRIANGLES") {
        return Mode::Triangles;
    }
    if (name == "INDICES") {
        return Mode::Indices;
    }
    bad("mode " + name.substr(0, 40) + " does not exist");
}

Filter filterOf(const std::string& name) {
    if (name.empty() || name == "NONE") {
        return Filter::None;
    }
    if (name == "OCTAHEDRAL") {
        return Filter::Octahedral;
    }
    if (name == "QUATERNION") {
        return Filter::Quaternion;
    }
    if (name == "EXPONENTIAL") {
        return Filter::Exponential;
    }
    bad("filter " + name.substr(0, 40) + " is not supported");
}

// What the extension allows; the library only asserts it.
void checkLayout(const MeshoptView& view, Mode mode, Filter filter) {
    const std::uint64_t stride = view.strideBytes;
    const bool fits = mode == Mode::Attributes ? stride >= 4 && stride <= 256 && stride % 4 == 0
                                               : stride == 2 || stride == 4;
    if (!fits) {
        bad("elements of " + std::to_string(stride) + " bytes do not exist in mode " + view.mode);
    }
    if (mode == Mode::Triangles && view.count % 3 != 0) {
        bad("indices that make no whole triangles");
    }
    const bool filterFits =
        filter == Filter::None ||
        (mode == Mode::Attributes && (filter == Filter::Exponential || stride == 8 ||
                                      (filter == Filter::Octahedral && stride == 4)));
    if (!filterFits) {
        bad("filter " + view.filter + " does not go with elements of " + std::to_string(stride) +
            " bytes in mode " + view.mode);
    }
    // The first byte: a nibble for the mode, one for the version of its coding.
    constexpr unsigned kCodes[] = {0xa0, 0xe0, 0xd0}, kNewest[] = {0, 1, 1};
    const unsigned first = view.bytes.empty() ? 0 : std::to_integer<unsigned>(view.bytes[0]);
    const auto i = std::size_t(mode);
    if ((first & 0xf0u) == kCodes[i] && (first & 0x0fu) > kNewest[i]) {
        bad("version " + std::to_string(first & 0x0fu) + " of mode " + view.mode +
            " is not supported");
    }
}

} // namespace

Bytes decodeMeshopt(const MeshoptView& view, ByteBudget& budget) {
    const Mode mode = modeOf(view.mode);
    const Filter filter = filterOf(view.filter);
    checkLayout(view, mode, filter);
    budget.take(view.count, view.strideBytes, "meshopt data");
    const std::size_t count = std::size_t(view.count), stride = std::size_t(view.strideBytes);
    Bytes out(count * stride);
    const auto* from = reinterpret_cast<const unsigned char*>(view.bytes.data());
    const std::size_t size = view.bytes.size();
    int failed = 0;
    switch (mode) {
    case Mode::Attributes:
        failed = meshopt_decodeVertexBuffer(out.data(), count, stride, from, size);
        break;
    case Mode::Triangles:
        failed = meshopt_decodeIndexBuffer(out.data(), count, stride, from, size);
        break;
    case Mode::Indices:
        failed = meshopt_decodeIndexSequence(out.data(), count, stride, from, size);
        break;
    }
    if (failed) {
        bad("damaged data of mode " + view.mode);
    }
    if (filter == Filter::Octahedral) {
        meshopt_decodeFilterOct(out.data(), count, stride);
    } else if (filter == Filter::Quaternion) {
        meshopt_decodeFilterQuat(out.data(), count, stride);
    } else if (filter == Filter::Exponential) {
        meshopt_decodeFilterExp(out.data(), count, stride);
    }
    return out;
}

} // namespace gnomon
