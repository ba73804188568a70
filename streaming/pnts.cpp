#include "streaming/pnts.h"

#include "streaming/batch_table.h"
#include "streaming/draco.h"
#include "streaming/features/vertex_color.h"
#include "streaming/pnts_batch.h"

#include <algorithm>
#include <cmath>

namespace gnomon {

namespace {

// The Draco buffer, where there is one, and what is beside it.
class PointReader {
  public:
    // `columns` of the batch table are in the same buffer.
    PointReader(const TileSemantics& table, std::uint32_t count,
                const std::map<std::string, std::uint32_t>& columns, ByteBudget& budget)
        : table_(table), count_(count) {
        const std::optional<DracoSemantics> draco = table.draco();
        if (!draco) {
            return;
        }
        std::vector<std::uint32_t> ids;
        for (const char* name : {"POSITION", "RGBA", "RGB", "NORMAL", "BATCH_ID"}) {
            if (const auto it = draco->uniqueIds.find(name); it != draco->uniqueIds.end()) {
                names_.push_back(name);
                ids.push_back(it->second);
            }
        }
        for (const auto& [name, id] : columns) {
            columns_.emplace(name, ids.size());
            ids.push_back(id);
        }
        draco_ = decodeDracoPoints(draco->bytes, ids, count, budget);
    }

    const DracoAttribute* compressed(const std::string& name, int components) const {
        const auto it = std::find(names_.begin(), names_.end(), name);
        if (it == names_.end()) {
            return nullptr;
        }
        const DracoAttribute& attribute = draco_.attributes[std::size_t(it - names_.begin())];
        if (attribute.components != components) {
            throw BadContent{"pnts: " + name + " has " + std::to_string(attribute.components) +
                             " components in its Draco data"};
        }
        return &attribute;
    }

    std::map<std::string, const DracoAttribute*> columns() const {
        std::map<std::string, const DracoAttribute*> out;
        for (const auto& [name, index] : columns_) {
            out.emplace(name, &draco_.attributes[index]);
        }
        return out;
    }

    // Gives `take` the values of each point, as a function of the component; false when there is
    // no such semantic.
    template <class Take>
    bool each(const char* name, int components, ComponentType type, const Take& take) const {
        if (const DracoAttribute* attribute = compressed(name, components)) {
            for (std::size_t i = 0; i < count_; ++i) {
                take([&](int c) {
                    return attribute->values[i * std::size_t(components) + std::size_t(c)];
                });
            }
            return true;
        }
        const auto values = table_.values(name, count_, components, type);
        for (std::size_t i = 0; values && i < count_; ++i) {
            take([&](int c) { return values->at(i, c); });
        }
        return values.has_value();
    }

    const TileSemantics& table() const { return table_; }

  private:
    const TileSemantics& table_;
    std::size_t count_;
    std::vector<std::string> names_; // of the first attributes of the buffer
    std::map<std::string, std::size_t> columns_;
    DracoMesh draco_;
};

std::vector<glm::dvec3> readPositions(const PointReader& points) {
    std::vector<glm::dvec3> out;
    const auto push = [&](const auto& at) { out.emplace_back(at(0), at(1), at(2)); };
    if (points.each("POSITION", 3, ComponentType::Float, push)) {
        return out;
    }
    if (!points.each("POSITION_QUANTIZED", 3, ComponentType::UnsignedShort, push)) {
        throw BadContent{"pnts without POSITION or POSITION_QUANTIZED"};
    }
    const auto offset = points.table().vec3("QUANTIZED_VOLUME_OFFSET");
    const auto scale = points.table().vec3("QUANTIZED_VOLUME_SCALE");
    if (!offset || !scale) {
        throw BadContent{"pnts with POSITION_QUANTIZED, but without its volume"};
    }
    for (glm::dvec3& p : out) {
        p = p / 65535.0 * *scale + *offset;
    }
    return out;
}

std::vector<glm::vec3> readNormals(const PointReader& points) {
    std::vector<glm::vec3> out;
    const auto push = [&](const glm::dvec3& n) {
        const double length = glm::length(n);
        out.push_back(length > 0.0 && std::isfinite(length) ? glm::vec3(n / length)
                                                            : glm::vec3(0.0f));
    };
    const bool plain = points.each("NORMAL", 3, ComponentType::Float, [&](const auto& at) {
        push({at(0), at(1), at(2)});
    });
    if (!plain) {
        points.each("NORMAL_OCT16P", 2, ComponentType::UnsignedByte,
                    [&](const auto& at) { push(octNormal(at(0) / 255.0, at(1) / 255.0)); });
    }
    return out;
}

std::uint32_t pack(double r, double g, double b, double a) {
    const auto part = [](double v) { return v > 0.0 ? std::min(v / 255.0, 1.0) : 0.0; }; // NaN: 0
    const std::uint32_t opaque = linearRgba({part(r), part(g), part(b)});
    return (opaque & 0xffffffu) | std::uint32_t(std::lround(255.0 * part(a))) << 24;
}

// Colours are for the screen, as those of pictures: sRGB.
std::vector<std::uint32_t> readColors(const PointReader& points) {
    std::vector<std::uint32_t> out;
    const bool rgba = points.each("RGBA", 4, ComponentType::UnsignedByte, [&](const auto& at) {
        out.push_back(pack(at(0), at(1), at(2), at(3)));
    });
    const bool rgb =
        rgba || points.each("RGB", 3, ComponentType::UnsignedByte, [&](const auto& at) {
            out.push_back(pack(at(0), at(1), at(2), 255.0));
        });
    if (!rgb) {
        points.each("RGB565", 1, ComponentType::UnsignedShort, [&](const auto& at) {
            const unsigned v = unsigned(at(0));
            out.push_back(pack((v >> 11) * 255.0 / 31.0, (v >> 5 & 63u) * 255.0 / 63.0,
                               (v & 31u) * 255.0 / 31.0, 255.0));
        });
    }
    return out;
}

// The colour of all points where they have none of their own.
glm::vec4 constantColor(const TileSemantics& table) {
    // A light grey of 169, as CSS calls dark grey and other viewers draw such clouds.
    std::vector<double> rgba = table.numbers("CONSTANT_RGBA", 4, ComponentType::UnsignedByte);
    if (rgba.empty()) {
        rgba = {169.0, 169.0, 169.0, 255.0};
    }
    const std::uint32_t packed = pack(rgba[0], rgba[1], rgba[2], 255.0);
    glm::vec4 out(1.0f);
    for (int i = 0; i < 3; ++i) {
        out[i] = float(packed >> (8 * i) & 0xffu) / 255.0f;
    }
    return out;
}

// Points are seen or not: shadows know nothing of the alpha of vertices.
void settleAlpha(PointCloud& cloud, std::vector<std::string>& warnings) {
    std::vector<std::uint32_t> kept;
    bool some = false;
    for (std::uint32_t i = 0; i < cloud.colors.size(); ++i) {
        const std::uint32_t alpha = cloud.colors[i] >> 24;
        some = some || (alpha > 0 && alpha < 255);
        if (alpha > 0) {
            kept.push_back(i);
        }
        cloud.colors[i] |= 0xff000000u;
    }
    if (some) {
        warnings.push_back("points half seen through are drawn opaque");
    }
    if (kept.size() < cloud.colors.size()) {
        cloud.keep(kept);
    }
}

std::uint32_t featureOf(double id) {
    return id >= 0.0 && id < double(kNoFeature) ? std::uint32_t(id) : kNoFeature;
}

// Ids of groups of points where the file has them, else, for a batch table, of each point. How many
// rows the table has.
std::uint32_t readFeatures(const TileParts& parts, const PointReader& points, std::uint32_t count,
                           std::vector<std::uint32_t>& features) {
    const std::uint32_t groups = points.table().count("BATCH_LENGTH").value_or(0);
    if (const DracoAttribute* ids = points.compressed("BATCH_ID", 1)) {
        for (const double id : ids->values) {
            features.push_back(featureOf(id));
        }
        return groups;
    }
    if (const auto ids = points.table().batchIds(count)) {
        for (std::size_t i = 0; i < count; ++i) {
            features.push_back(featureOf(ids->at(i, 0)));
        }
        return groups;
    }
    for (std::uint32_t i = 0; i < count && !parts.batchJson.empty(); ++i) {
        features.push_back(i);
    }
    return std::uint32_t(features.size());
}

std::shared_ptr<const FeatureTable> readTable(const TileParts& parts, const PointReader& points,
                                              std::uint32_t rows, ByteBudget& budget,
                                              std::vector<std::string>& warnings) {
    const auto columns = points.columns();
    if (columns.empty()) {
        return readBatchTable(parts.batchJson, parts.batchBinary, rows, warnings, budget);
    }
    const PlainBatchTable plain = plainBatchTable(parts, columns, budget);
    return readBatchTable(plain.json, plain.binary, rows, warnings, budget);
}

} // namespace

GltfContent readPnts(const TileParts& parts, ByteBudget& budget) {
    const TileSemantics table(parts, budget);
    const std::optional<std::uint32_t> count = table.count("POINTS_LENGTH");
    if (!count) {
        throw BadContent{"pnts without POINTS_LENGTH"};
    }
    budget.take(*count, sizeof(glm::dvec3) + sizeof(glm::vec3) + 8, "points");
    const auto columns =
        table.draco() ? dracoColumns(parts, budget) : std::map<std::string, std::uint32_t>{};
    const PointReader points(table, *count, columns, budget);

    GltfContent out;
    out.points.emplace_back();
    PointCloud& cloud = out.points.front();
    cloud.positions = readPositions(points);
    const glm::dvec3 centre = table.vec3("RTC_CENTER").value_or(glm::dvec3(0.0));
    for (glm::dvec3& p : cloud.positions) {
        p += centre;
    }
    cloud.normals = readNormals(points);
    cloud.colors = readColors(points);
    const std::uint32_t rows = readFeatures(parts, points, *count, cloud.features);
    out.features = readTable(parts, points, rows, budget, out.warnings);
    settleAlpha(cloud, out.warnings);
    Material material;
    if (cloud.colors.empty()) {
        material.baseColor = constantColor(table);
    }
    out.materials.push_back(material);
    if (table.draco()) {
        out.extensions.push_back("3DTILES_draco_point_compression");
    }
    return out;
}

} // namespace gnomon
