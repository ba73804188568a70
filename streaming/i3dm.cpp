#include "streaming/i3dm.h"

#include "geo/ellipsoid.h"
#include "streaming/batch_table.h"
#include "streaming/normal_axes.h"

#include <algorithm>
#include <cmath>

namespace gnomon {

namespace {

struct Instance {
    glm::dmat4 tileFromModel{1.0};
    std::uint32_t feature = 0;
};

// East, north and up at a place, as columns in the tile's frame.
class Compass {
  public:
    explicit Compass(const Transform<Ecef, Tile>& ecefFromTile) : transform_(ecefFromTile) {
        const glm::dmat3 axes = ecefFromTile.axes();
        const glm::dvec3 x = glm::normalize(axes[0]);
        const glm::dvec3 z = glm::normalize(glm::cross(x, axes[1]));
        // Turns only: what the tile's transform stretches, it stretches of its instances too.
        tileFromEcef_ = glm::transpose(glm::dmat3(x, glm::cross(z, x), z));
    }

    glm::dmat3 at(const glm::dvec3& place) const {
        const Result<Geodetic> geodetic = geodeticFromEcef(transform_(Point<Tile>{place}));
        return geodetic ? tileFromEcef_ * ecefFromEnu(*geodetic).axes() : glm::dmat3(1.0);
    }

  private:
    const Transform<Ecef, Tile>& transform_;
    glm::dmat3 tileFromEcef_;
};

std::vector<glm::dvec3> readPositions(const TileSemantics& table, std::uint32_t count) {
    std::vector<glm::dvec3> out;
    out.reserve(count);
    const glm::dvec3 centre = table.vec3("RTC_CENTER").value_or(glm::dvec3(0.0));
    if (const auto plain = table.values("POSITION", count, 3, ComponentType::Float)) {
        for (std::uint32_t i = 0; i < count; ++i) {
            out.push_back(plain->vec3(i) + centre);
        }
        return out;
    }
    const auto packed = table.values("POSITION_QUANTIZED", count, 3, ComponentType::UnsignedShort);
    if (!packed) {
        throw BadContent{"i3dm without POSITION or POSITION_QUANTIZED"};
    }
    const auto offset = table.vec3("QUANTIZED_VOLUME_OFFSET");
    const auto scale = table.vec3("QUANTIZED_VOLUME_SCALE");
    if (!offset || !scale) {
        throw BadContent{"i3dm with POSITION_QUANTIZED, but without its volume"};
    }
    for (std::uint32_t i = 0; i < count; ++i) {
        out.push_back(packed->vec3(i) / 65535.0 * *scale + *offset + centre);
    }
    return out;
}

// Directions of one of an instance's axes, plain or packed; none when the table has neither.
std::vector<glm::dvec3> readDirections(const TileSemantics& table, const std::string& name,
                                       std::uint32_t count) {
    std::vector<glm::dvec3> out;
    if (const auto plain = table.values(name.c_str(), count, 3, ComponentType::Float)) {
        for (std::uint32_t i = 0; i < count; ++i) {
            out.push_back(plain->vec3(i));
        }
        return out;
    }
    const std::string octName = name + "_OCT32P";
    if (const auto packed = table.values(octName.c_str(), count, 2, ComponentType::UnsignedShort)) {
        for (std::uint32_t i = 0; i < count; ++i) {
            out.push_back(octNormal(packed->at(i, 0) / 65535.0, packed->at(i, 1) / 65535.0));
        }
    }
    return out;
}

// The axes of each instance: right, up and forward are its x, y and z.
std::vector<glm::dmat3> readOrientations(const TileSemantics& table,
                                         const std::vector<glm::dvec3>& positions,
                                         const Transform<Ecef, Tile>& ecefFromTile) {
    const auto count = std::uint32_t(positions.size());
    const std::vector<glm::dvec3> up = readDirections(table, "NORMAL_UP", count);
    const std::vector<glm::dvec3> right = readDirections(table, "NORMAL_RIGHT", count);
    if (up.empty() != right.empty()) {
        throw BadContent{"i3dm with only one of NORMAL_UP and NORMAL_RIGHT"};
    }
    std::vector<glm::dmat3> out(count, glm::dmat3(1.0));
    for (std::uint32_t i = 0; i < up.size(); ++i) {
        // The plain ones are unit and square by promise only, the packed ones nearly.
        const glm::dvec3 x = glm::normalize(right[i]);
        const glm::dvec3 z = glm::normalize(glm::cross(x, up[i]));
        const glm::dmat3 axes(x, glm::cross(z, x), z);
        out[i] = std::isfinite(glm::determinant(axes)) ? axes : glm::dmat3(1.0);
    }
    if (up.empty() && table.flag("EAST_NORTH_UP")) {
        const Compass compass(ecefFromTile);
        for (std::uint32_t i = 0; i < count; ++i) {
            out[i] = compass.at(positions[i]);
        }
    }
    return out;
}

std::vector<Instance> readInstances(const TileSemantics& table, std::uint32_t count,
                                    const std::optional<SemanticValues>& ids,
                                    const Transform<Ecef, Tile>& ecefFromTile) {
    const std::vector<glm::dvec3> positions = readPositions(table, count);
    const std::vector<glm::dmat3> axes = readOrientations(table, positions, ecefFromTile);
    const auto scale = table.values("SCALE", count, 1, ComponentType::Float);
    const auto scales = table.values("SCALE_NON_UNIFORM", count, 3, ComponentType::Float);
    std::vector<Instance> out(count);
    for (std::uint32_t i = 0; i < count; ++i) {
        const glm::dvec3 by =
            (scale ? scale->at(i, 0) : 1.0) * (scales ? scales->vec3(i) : glm::dvec3(1.0));
        for (int c = 0; c < 3; ++c) {
            out[i].tileFromModel[c] = glm::dvec4(axes[i][c] * by[c], 0.0);
        }
        out[i].tileFromModel[3] = glm::dvec4(positions[i], 1.0);
        const double id = ids ? ids->at(i, 0) : double(i);
        out[i].feature = id >= 0.0 && id < double(kNoFeature) ? std::uint32_t(id) : kNoFeature;
    }
    return out;
}

// The folder of a uri with the slash behind it, without query and fragment.
std::string folderOf(std::string uri) {
    uri.resize(std::min(uri.find_first_of("?#"), uri.size()));
    const std::size_t slash = uri.rfind('/');
    return slash == std::string::npos ? std::string() : uri.substr(0, slash + 1);
}

bool isAbsolute(const std::string& uri) {
    const std::size_t colon = uri.find_first_of(":/?#");
    return uri.starts_with('/') || (colon != std::string::npos && uri[colon] == ':');
}

GltfContent readModel(const TileParts& parts, const DecodeOptions& options, ByteBudget& budget) {
    if (!parts.bodyIsUri) {
        return readGltf(parts.body, options, {}, budget);
    }
    std::string uri(reinterpret_cast<const char*>(parts.body.data()), parts.body.size());
    uri.erase(
        std::find_if(uri.rbegin(), uri.rend(), [](char c) { return c != ' ' && c != '\0'; }).base(),
        uri.end());
    if (uri.empty()) {
        throw BadContent{"i3dm without the uri of its model"};
    }
    if (!options.readUri) {
        throw BadContent{"i3dm whose model is a file of its own, which cannot be read from here"};
    }
    const Result<Bytes> bytes = options.readUri(uri);
    if (!bytes) {
        throw BadContent{"the i3dm's model: " + bytes.error().message()};
    }
    budget.take(bytes->size(), 1, "model");
    // What the model names is named relative to it.
    DecodeOptions own = options;
    own.readUri = [&options, folder = folderOf(uri)](const std::string& inner) {
        return options.readUri(isAbsolute(inner) ? inner : folder + inner);
    };
    return readGltf(*bytes, own, {}, budget);
}

void append(const Soup& model, const Instance& instance, Soup& out) {
    const glm::dmat3 axes(instance.tileFromModel), normalAxes = normalAxesOf(axes);
    const bool mirrored = glm::determinant(axes) < 0.0;
    const auto first = std::uint32_t(out.positions.size());
    for (const glm::dvec3& p : model.positions) {
        out.positions.push_back(glm::dvec3(instance.tileFromModel * glm::dvec4(p, 1.0)));
    }
    for (const glm::vec3& normal : model.normals) {
        out.normals.push_back(turnedNormal(normalAxes, normal));
    }
    out.uvs.insert(out.uvs.end(), model.uvs.begin(), model.uvs.end());
    out.colors.insert(out.colors.end(), model.colors.begin(), model.colors.end());
    out.features.resize(out.positions.size(), instance.feature);
    for (Soup::Triangle t : model.triangles) {
        for (std::uint32_t& v : t.vertex) {
            v += first;
        }
        if (mirrored) {
            std::swap(t.vertex[1], t.vertex[2]);
        }
        t.attributes |= Soup::Features;
        out.triangles.push_back(t);
    }
}

void append(const PointCloud& model, const Instance& instance, PointCloud& out) {
    const glm::dmat3 normalAxes = normalAxesOf(glm::dmat3(instance.tileFromModel));
    for (const glm::dvec3& p : model.positions) {
        out.positions.push_back(glm::dvec3(instance.tileFromModel * glm::dvec4(p, 1.0)));
    }
    for (const glm::vec3& normal : model.normals) {
        out.normals.push_back(turnedNormal(normalAxes, normal));
    }
    out.colors.insert(out.colors.end(), model.colors.begin(), model.colors.end());
    out.features.resize(out.positions.size(), instance.feature);
    out.material = model.material;
}

// The model at each instance, in place of the model.
void multiply(const std::vector<Instance>& instances, GltfContent& content, ByteBudget& budget) {
    const std::size_t count = instances.size();
    const Soup model = std::exchange(content.soup, Soup{});
    budget.take(count,
                std::max<std::uint64_t>(model.positions.size() * kBytesPerSoupVertex +
                                            model.triangles.size() * kBytesPerSoupTriangle,
                                        1),
                "instances");
    content.soup.positions.reserve(model.positions.size() * count);
    content.soup.triangles.reserve(model.triangles.size() * count);
    for (const Instance& instance : instances) {
        append(model, instance, content.soup);
    }
    for (PointCloud& cloud : content.points) {
        const PointCloud one = std::exchange(cloud, PointCloud{});
        budget.take(count, std::max<std::uint64_t>(one.size() * sizeof(glm::dvec3) * 2, 1),
                    "instances");
        for (const Instance& instance : instances) {
            append(one, instance, cloud);
        }
    }
}

} // namespace

GltfContent readI3dm(const TileParts& parts, const DecodeOptions& options, ByteBudget& budget) {
    const TileSemantics table(parts, budget);
    const std::optional<std::uint32_t> count = table.count("INSTANCES_LENGTH");
    if (!count) {
        throw BadContent{"i3dm without INSTANCES_LENGTH"};
    }
    constexpr std::size_t kEach =
        sizeof(Instance) + sizeof(glm::dmat3) + 3 * sizeof(glm::dvec3); // while they are read
    budget.take(*count, kEach, "instances");
    const std::optional<SemanticValues> ids = table.batchIds(*count);
    const std::vector<Instance> instances = readInstances(table, *count, ids, options.ecefFromTile);
    GltfContent out = readModel(parts, options, budget);
    multiply(instances, out, budget);

    std::uint32_t rows = 0;
    for (const Instance& instance : instances) {
        rows = instance.feature == kNoFeature ? rows : std::max(rows, instance.feature + 1);
    }
    // Nothing tells how long a table is whose rows instances name: they need not name the last.
    const BatchRows rowsAre = ids ? BatchRows::UsedAtLeast : BatchRows::Told;
    out.features =
        readBatchTable(parts.batchJson, parts.batchBinary, rows, out.warnings, budget, rowsAre);
    return out;
}

} // namespace gnomon
