// GeoJSON, GeoPackage, Shapefile, FlatGeobuf and file geodatabases, through GDAL. It is told which
// drivers it may try, and what it says is kept from the terminal.
#include "streaming/features/features_read.h"
#include "streaming/terrain/gdal_quiet.h"

#include <cpl_conv.h>
#include <cpl_vsi.h>
#include <ogrsf_frmts.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <filesystem>
#include <limits>
#include <map>

namespace gnomon {

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();
constexpr std::array<const char*, 7> kDrivers = {
    "GeoJSON", "GeoJSONSeq", "GPKG", "ESRI Shapefile", "FlatGeobuf", "OpenFileGDB", nullptr};

using Dataset = GDALDatasetUniquePtr;

Dataset open(const std::string& path) {
    return Dataset(GDALDataset::Open(
        path.c_str(), GDAL_OF_VECTOR | GDAL_OF_READONLY | GDAL_OF_VERBOSE_ERROR, kDrivers.data()));
}

// A Shapefile without its index, opened in memory, where GDAL may write another one: beside the
// file it may not.
class WithoutIndex {
  public:
    explicit WithoutIndex(const std::string& path) {
        static std::atomic<unsigned> next{0};
        folder_ = "/vsimem/gnomon-shapefile-" + std::to_string(next++);
        const std::filesystem::path original(path);
        for (const auto& entry : std::filesystem::directory_iterator(
                 original.has_parent_path() ? original.parent_path() : "."))
            if (entry.path().stem() == original.stem() && entry.is_regular_file())
                copy(entry.path());
    }
    ~WithoutIndex() { VSIRmdirRecursive(folder_.c_str()); }
    WithoutIndex(const WithoutIndex&) = delete;
    WithoutIndex& operator=(const WithoutIndex&) = delete;

    Dataset open() const {
        CPLSetThreadLocalConfigOption("SHAPE_RESTORE_SHX", "YES");
        Dataset data = gnomon::open(folder_ + "/it.shp");
        CPLSetThreadLocalConfigOption("SHAPE_RESTORE_SHX", nullptr);
        return data;
    }

  private:
    void copy(const std::filesystem::path& from) const {
        std::string extension = from.extension().string();
        std::transform(extension.begin(), extension.end(), extension.begin(),
                       [](unsigned char c) { return char(std::tolower(c)); });
        if (extension != ".shp" && extension != ".dbf" && extension != ".prj" &&
            extension != ".cpg")
            return;
        GByte* bytes = nullptr;
        vsi_l_offset size = 0;
        if (VSIIngestFile(nullptr, from.c_str(), &bytes, &size, -1))
            VSIFCloseL(
                VSIFileFromMemBuffer((folder_ + "/it" + extension).c_str(), bytes, size, TRUE));
    }
    std::string folder_;
};

bool lacksIndex(const std::string& path) {
    std::filesystem::path lowerCase(path), upperCase(path);
    std::string extension = lowerCase.extension().string();
    std::transform(extension.begin(), extension.end(), extension.begin(),
                   [](unsigned char c) { return char(std::tolower(c)); });
    if (extension != ".shp")
        return false;
    std::error_code failed;
    return !std::filesystem::exists(lowerCase.replace_extension(".shx"), failed) &&
           !std::filesystem::exists(upperCase.replace_extension(".SHX"), failed);
}

FeatureRing ringOf(const OGRSimpleCurve& line) {
    FeatureRing ring;
    ring.reserve(std::size_t(line.getNumPoints()));
    const bool flat = !line.Is3D();
    for (int i = 0; i < line.getNumPoints(); ++i)
        ring.emplace_back(line.getX(i), line.getY(i), flat ? kNaN : line.getZ(i));
    return ring;
}

// A ring without its repeated first vertex.
FeatureRing openRingOf(const OGRSimpleCurve& line) {
    FeatureRing ring = ringOf(line);
    const auto same = [](const glm::dvec3& a, const glm::dvec3& b) {
        return a.x == b.x && a.y == b.y && (a.z == b.z || (std::isnan(a.z) && std::isnan(b.z)));
    };
    while (ring.size() > 1 && same(ring.front(), ring.back()))
        ring.pop_back();
    return ring;
}

using Shapes = std::map<FeatureShape, std::vector<FeaturePart>>;

void addPolygon(const OGRPolygon& polygon, FeatureShape shape, Shapes& shapes) {
    FeaturePart part;
    for (const OGRLinearRing* ring : polygon) {
        FeatureRing vertices = openRingOf(*ring);
        if (vertices.size() >= 3)
            part.push_back(std::move(vertices));
        else if (part.empty())
            return; // an outer ring without area
    }
    if (!part.empty())
        shapes[shape].push_back(std::move(part));
}

void addGeometry(const OGRGeometry& geometry, Shapes& shapes) {
    switch (wkbFlatten(geometry.getGeometryType())) {
    case wkbPoint:
        if (const OGRPoint* p = geometry.toPoint(); !p->IsEmpty())
            shapes[FeatureShape::Point].push_back(
                {{{p->getX(), p->getY(), p->Is3D() ? p->getZ() : kNaN}}});
        break;
    case wkbLineString:
        if (FeatureRing line = ringOf(*geometry.toLineString()); line.size() >= 2)
            shapes[FeatureShape::Line].push_back({std::move(line)});
        break;
    case wkbPolygon:
        addPolygon(*geometry.toPolygon(), FeatureShape::Polygon, shapes);
        break;
    case wkbTriangle:
        addPolygon(*geometry.toPolygon(), FeatureShape::Surface, shapes);
        break;
    case wkbPolyhedralSurface:
    case wkbTIN:
        for (const OGRPolygon* face : *geometry.toPolyhedralSurface())
            addPolygon(*face, FeatureShape::Surface, shapes);
        break;
    case wkbMultiPoint:
    case wkbMultiLineString:
    case wkbMultiPolygon:
    case wkbGeometryCollection:
        for (const OGRGeometry* part : *geometry.toGeometryCollection())
            addGeometry(*part, shapes);
        break;
    default: // arcs and what is made of them
        if (geometry.hasCurveGeometry())
            if (const std::unique_ptr<OGRGeometry> straight{geometry.getLinearGeometry()};
                straight && !straight->hasCurveGeometry())
                addGeometry(*straight, shapes);
    }
}

AttributeValue valueOf(const OGRFeature& feature, int field, const OGRFieldDefn& definition) {
    switch (definition.GetType()) {
    case OFTInteger:
        if (definition.GetSubType() == OFSTBoolean)
            return feature.GetFieldAsInteger(field) != 0;
        [[fallthrough]];
    case OFTInteger64:
    case OFTReal:
        return feature.GetFieldAsDouble(field);
    case OFTBinary:
        return {};
    default:
        return std::string(feature.GetFieldAsString(field));
    }
}

// Its own where a column says so, else the number it has in the file.
std::string idOf(const OGRFeature& feature, const Feature& read) {
    for (const char* name : {"id", "@id", "gml_id", "osm_id"}) {
        const AttributeValue* value = read.attribute(name);
        const std::string* text = value != nullptr ? std::get_if<std::string>(value) : nullptr;
        if (text != nullptr && !text->empty())
            return *text;
        const double* number = value != nullptr ? std::get_if<double>(value) : nullptr;
        if (number != nullptr && *number == std::floor(*number) && std::abs(*number) < 1e15)
            return std::to_string((long long)(*number));
    }
    return std::to_string((long long)feature.GetFID());
}

class LayerReader {
  public:
    LayerReader(OGRLayer& layer, FeatureFile& file) : layer_(layer), file_(file) {}

    RawFeatures run() {
        findCrs();
        for (const OGRFeatureUniquePtr& feature : layer_)
            add(*feature);
        if (empty_ > 0)
            file_.notes.push_back(std::to_string(empty_) + " of its features have no shape");
        return std::move(raw_);
    }

  private:
    void findCrs() {
        const OGRSpatialReference* reference = layer_.GetSpatialRef();
        if (reference == nullptr || reference->IsEmpty() || reference->IsLocal())
            return;
        char* text = nullptr;
        const std::array<const char*, 2> options = {"FORMAT=WKT2_2019", nullptr};
        if (reference->exportToWkt(&text, options.data()) == OGRERR_NONE && text != nullptr)
            raw_.crs = text;
        CPLFree(text);
        // The number only where it means what the file says.
        const char* authority = reference->GetAuthorityName(nullptr);
        const char* code = reference->GetAuthorityCode(nullptr);
        const char* name = reference->GetName();
        raw_.crsName = name != nullptr ? name : "its own system";
        if (authority != nullptr && code != nullptr) {
            std::string number = std::string(authority) + ":" + code;
            if (number == "EPSG:3785") // withdrawn: the same as
                number = "EPSG:3857";
            OGRSpatialReference known;
            if (known.SetFromUserInput(number.c_str()) == OGRERR_NONE &&
                known.IsSame(reference, kSameBut.data()))
                raw_.crsName = number;
        }
    }

    void add(const OGRFeature& feature) {
        const OGRGeometry* geometry = feature.GetGeometryRef();
        Shapes shapes;
        if (geometry != nullptr)
            addGeometry(*geometry, shapes);
        if (shapes.empty()) {
            ++empty_;
            return;
        }
        Feature read;
        const OGRFeatureDefn& definition = *layer_.GetLayerDefn();
        for (int i = 0; i < definition.GetFieldCount(); ++i)
            if (feature.IsFieldSetAndNotNull(i))
                read.attributes.emplace_back(definition.GetFieldDefn(i)->GetNameRef(),
                                             valueOf(feature, i, *definition.GetFieldDefn(i)));
        read.id = idOf(feature, read);
        for (auto& [shape, parts] : shapes) {
            Feature one = read;
            one.shape = shape;
            one.parts = std::move(parts);
            raw_.features.push_back(std::move(one));
        }
    }

    static constexpr std::array<const char*, 3> kSameBut = {
        "IGNORE_DATA_AXIS_TO_SRS_AXIS_MAPPING=YES",
        "CRITERION=EQUIVALENT_EXCEPT_AXIS_ORDER_GEOGCRS", nullptr};
    OGRLayer& layer_;
    FeatureFile& file_;
    RawFeatures raw_;
    std::size_t empty_ = 0;
};

std::string formatOf(GDALDataset& data) {
    const std::string driver = data.GetDriver()->GetDescription();
    return driver == "GPKG"             ? "GeoPackage"
           : driver == "ESRI Shapefile" ? "Shapefile"
           : driver == "GeoJSONSeq"     ? "GeoJSON lines"
           : driver == "OpenFileGDB"    ? "file geodatabase"
                                        : driver;
}

} // namespace

Failure readWithOgr(const std::string& path, std::vector<RawFeatures>& out, FeatureFile& file) {
    registerGdalDrivers();
    const GdalQuiet quiet;
    // Absolute, so that no name is taken for one of GDAL's own ("GPKG:…", text that is JSON).
    const std::string absolute = std::filesystem::absolute(path).string();
    std::optional<WithoutIndex> inMemory;
    if (lacksIndex(path))
        inMemory.emplace(absolute);
    const Dataset data = inMemory ? inMemory->open() : open(absolute);
    if (!data)
        return Error{path, "is nothing that GDAL reads as GeoJSON, GeoPackage, Shapefile or "
                           "FlatGeobuf: " +
                               quiet.reason()};
    const std::string format = formatOf(*data);
    if (file.format.empty())
        file.format = format;
    if (inMemory)
        file.notes.push_back("its .shx is missing: made anew in memory");
    for (OGRLayer* layer : data->GetLayers()) {
        if (layer->GetGeomType() == wkbNone)
            continue;
        RawFeatures raw = LayerReader(*layer, file).run();
        raw.crsIsFormats = format.starts_with("GeoJSON") &&
                           (raw.crsName == "EPSG:4326" || raw.crsName == "EPSG:4979" ||
                            raw.crsName == "OGC:CRS84");
        if (!raw.features.empty())
            out.push_back(std::move(raw));
    }
    if (!quiet.silent())
        file.leftOut.push_back(
            {path, "is damaged, or only in part what it says: " + quiet.reason()});
    return {};
}

} // namespace gnomon
