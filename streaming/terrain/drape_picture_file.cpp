#include "streaming/terrain/drape_picture_file.h"

#include "streaming/terrain/gdal_quiet.h"

#include <cpl_conv.h>

#include <algorithm>
#include <cmath>

namespace gnomon {

namespace {

// What holds a picture in one file, and what holds heights, so that these can be refused by name.
// Left out are formats that lead on to other files or to a network (VRT, WMS and the like).
constexpr std::array kDrivers = {"GTiff", "PNG",     "JPEG",    "JP2OpenJPEG",
                                 "WEBP",  "BMP",     "GIF",     "HFA",
                                 "GPKG",  "MBTiles", "AAIGrid", "SRTMHGT",
                                 "EHdr",  "USGSDEM", "DTED",    static_cast<const char*>(nullptr)};

bool isFinite(std::span<const double> values) {
    return std::all_of(values.begin(), values.end(), [](double v) { return std::isfinite(v); });
}

struct Describer {
    GDALDataset& data;
    PictureFile& file;
    const DrapeOptions& options;
    std::vector<std::string>& notes;

    Error refused(const std::string& why) const { return Error{file.path, why}; }
    GDALRasterBand& band(int number) const { return *data.GetRasterBand(number); }

    Failure findPlace();
    Failure findCrs();
    bool readCrsBeside();
    Failure findBands();
    Failure pickColors(int count);
    Failure checkTypes();
    void findPalette();
    void findRange();
};

Failure Describer::findPlace() {
    if (data.GetGeoTransform(file.place.data()) != CE_None) {
        if (data.GetGCPCount() > 0)
            return refused("is placed by control points, not by a corner and the size of its "
                           "pixels; warp it first (gdalwarp does)");
        return refused("does not say where it lies: it has no place of its own and no world file "
                       "stands beside it");
    }
    if (!isFinite(file.place) ||
        !GDALInvGeoTransform(file.place.data(), file.pixelFromPlace.data()) ||
        !isFinite(file.pixelFromPlace))
        return refused("its pixels have no width, or its corner lies nowhere");
    return {};
}

// A .prj file, as stands beside many a picture with a world file.
bool Describer::readCrsBeside() {
    const std::string beside = CPLResetExtension(file.path.c_str(), "prj");
    char** lines = CSLLoad2(beside.c_str(), 1000, 10000, nullptr);
    const bool read = lines != nullptr && file.crs.importFromESRI(lines) == OGRERR_NONE;
    CSLDestroy(lines);
    if (!read)
        file.crs.Clear();
    return read;
}

Failure Describer::findCrs() {
    const OGRSpatialReference* own = data.GetSpatialRef();
    if (own != nullptr && !own->IsEmpty() && !own->IsLocal()) {
        file.crs = *own;
    } else if (!readCrsBeside()) {
        if (!options.crs)
            return refused("names no coordinate reference system; give it one (--crs EPSG:n)");
        if (file.crs.SetFromUserInput(options.crs->c_str(),
                                      OGRSpatialReference::SET_FROM_USER_INPUT_LIMITATIONS_get()) !=
            OGRERR_NONE)
            return refused("'" + options.crs->substr(0, 60) +
                           "' is not a coordinate reference system that PROJ knows");
    }
    file.crs.StripVertical(); // a picture has no heights
    file.crs.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    if (!file.crs.IsGeographic() && !file.crs.IsProjected())
        return refused("its coordinate reference system does not say where on the Earth it is");
    if (file.crs.IsGeographic())
        file.turn = 2.0 * 3.14159265358979323846 / file.crs.GetAngularUnits(nullptr);
    return {};
}

Failure Describer::pickColors(int count) {
    int red = 0, green = 0, blue = 0;
    for (int b = 1; b <= count; ++b) {
        switch (band(b).GetColorInterpretation()) {
        case GCI_RedBand:
            red = red ? red : b;
            break;
        case GCI_GreenBand:
            green = green ? green : b;
            break;
        case GCI_BlueBand:
            blue = blue ? blue : b;
            break;
        case GCI_AlphaBand:
            file.alphaBand = file.alphaBand ? file.alphaBand : b;
            break;
        case GCI_CyanBand:
        case GCI_HueBand:
            return refused("its colours are neither red, green and blue nor grey");
        default:
            break;
        }
    }
    const int colors = count - (file.alphaBand != 0);
    if (red && green && blue)
        file.colorBands = {red, green, blue};
    else if (colors < 3)
        file.colorBands = {file.alphaBand == 1 ? 2 : 1};
    else
        for (int b = 1; file.colorBands.size() < 3; ++b)
            if (b != file.alphaBand)
                file.colorBands.push_back(b);
    if (colors > int(file.colorBands.size())) {
        std::string used;
        for (const int b : file.colorBands)
            used += (used.empty() ? "" : ", ") + std::to_string(b);
        notes.push_back("has " + std::to_string(count) + " bands; shown: " + used);
    }
    return {};
}

Failure Describer::checkTypes() {
    std::vector<int> used = file.colorBands;
    if (file.alphaBand)
        used.push_back(file.alphaBand);
    for (const int b : used) {
        const GDALDataType type = band(b).GetRasterDataType();
        file.sixteenBits = file.sixteenBits || type == GDT_UInt16;
        if (type == GDT_Byte || type == GDT_UInt16)
            continue;
        const std::string name = GDALGetDataTypeName(type);
        if (file.colorBands.size() == 1)
            return refused("looks like heights, not a picture: one band of " + name +
                           " (as terrain: write terrain=" + file.path + ")");
        return refused("its bands are of " + name +
                       "; a picture's are of 8 or 16 bits without a sign");
    }
    return {};
}

void Describer::findPalette() {
    const GDALColorTable* table = band(file.colorBands[0]).GetColorTable();
    if (table == nullptr || file.colorBands.size() != 1)
        return;
    file.palette.assign(file.sixteenBits ? 65536 : 256, glm::vec4(0.0f));
    const int count = std::min(table->GetColorEntryCount(), int(file.palette.size()));
    for (int i = 0; i < count; ++i) {
        GDALColorEntry c{};
        table->GetColorEntryAsRGB(i, &c);
        file.palette[std::size_t(i)] = glm::vec4(c.c1, c.c2, c.c3, c.c4);
    }
}

// What is shown as black and as white: all there is of 8 bits; of 16 what the file says it uses,
// else what all but a hundredth of its pixels at either end use.
void Describer::findRange() {
    double low = 0.0, high = 255.0;
    if (file.sixteenBits) {
        high = 65535.0;
        const char* bits = band(file.colorBands[0]).GetMetadataItem("NBITS", "IMAGE_STRUCTURE");
        const int used = bits != nullptr ? std::atoi(bits) : 0;
        if (used >= 1 && used < 16) {
            high = double((1 << used) - 1);
        } else if (file.palette.empty()) {
            constexpr int kBuckets = 4096;
            std::vector<GUIntBig> sum(kBuckets), counts(kBuckets);
            for (const int b : file.colorBands)
                if (band(b).GetHistogram(-0.5, 65535.5, kBuckets, counts.data(), FALSE, TRUE,
                                         nullptr, nullptr) == CE_None)
                    for (int i = 0; i < kBuckets; ++i)
                        sum[std::size_t(i)] += counts[std::size_t(i)];
            GUIntBig all = 0, seen = 0;
            for (const GUIntBig n : sum)
                all += n;
            int first = -1, last = kBuckets - 1;
            for (int i = 0; i < kBuckets && all > 0; ++i) {
                seen += sum[std::size_t(i)];
                first = first < 0 && seen * 100 > all ? i : first;
                if (seen * 100 >= all * 99) {
                    last = i;
                    break;
                }
            }
            low = 16.0 * std::max(first, 0);
            high = 16.0 * last + 15.0;
            notes.push_back("its 16-bit values from " + std::to_string(int(low)) + " to " +
                            std::to_string(int(high)) + " are shown as black to white");
        }
    }
    file.shown.resize(file.sixteenBits ? 65536 : 256);
    for (std::size_t i = 0; i < file.shown.size(); ++i)
        file.shown[i] = float(255.0 * std::clamp((double(i) - low) / (high - low), 0.0, 1.0));
}

Failure Describer::findBands() {
    const int count = data.GetRasterCount();
    if (count == 0)
        return refused("holds no picture, or several of which one must be picked");
    if (Failure wrong = pickColors(count))
        return wrong;
    if (Failure wrong = checkTypes())
        return wrong;
    for (const int b : file.colorBands) {
        int given = 0;
        const double none = band(b).GetNoDataValue(&given);
        file.noData.push_back(given ? std::optional(none) : std::nullopt);
    }
    const int mask = band(file.colorBands[0]).GetMaskFlags();
    file.hasMask = (mask & GMF_PER_DATASET) != 0 && (mask & (GMF_ALPHA | GMF_ALL_VALID)) == 0;
    findPalette();
    findRange();
    GDALRasterBand& first = band(file.colorBands[0]);
    for (int i = 0; i < first.GetOverviewCount(); ++i) {
        GDALRasterBand* smaller = first.GetOverview(i);
        file.overviewWidths.push_back(smaller != nullptr ? smaller->GetXSize() : 0);
        file.overviewHeights.push_back(smaller != nullptr ? smaller->GetYSize() : 0);
    }
    return {};
}

using Raw = std::vector<std::uint16_t>;

// The pixels of some rows, band by band.
class Rows {
  public:
    Rows(const PictureFile& file, GDALDataset& data, int overview) : file_(file) {
        for (const int b : file.colorBands)
            bands_.push_back(at(data.GetRasterBand(b), overview));
        if (file.alphaBand)
            alpha_ = at(data.GetRasterBand(file.alphaBand), overview);
        else if (file.hasMask && bands_[0] != nullptr)
            alpha_ = bands_[0]->GetMaskBand();
        full_ = file.alphaBand && file.sixteenBits ? 65535.0f : 255.0f;
        raw_.resize(bands_.size());
    }

    bool read(int column, int row, int columns, int rows) {
        const auto one = [&](GDALRasterBand* band, Raw& into) {
            into.resize(std::size_t(columns) * std::size_t(rows));
            return band != nullptr &&
                   band->RasterIO(GF_Read, column, row, columns, rows, into.data(), columns, rows,
                                  GDT_UInt16, 0, 0, nullptr) == CE_None;
        };
        for (std::size_t b = 0; b < bands_.size(); ++b)
            if (!one(bands_[b], raw_[b]))
                return false;
        return alpha_ == nullptr || one(alpha_, rawAlpha_);
    }

    // Colour times alpha, and alpha.
    glm::vec4 pixel(std::size_t i) const {
        bool missing = true;
        for (std::size_t b = 0; b < raw_.size(); ++b)
            missing = missing && file_.noData[b] && double(raw_[b][i]) == *file_.noData[b];
        float alpha = missing ? 0.0f : alpha_ != nullptr ? float(rawAlpha_[i]) / full_ : 1.0f;
        glm::vec4 c;
        if (!file_.palette.empty()) {
            c = file_.palette[std::min<std::size_t>(raw_[0][i], file_.palette.size() - 1)];
            alpha *= c.a / 255.0f;
        } else {
            const auto shown = [&](std::size_t b) {
                return file_.shown[std::min<std::size_t>(raw_[b][i], file_.shown.size() - 1)];
            };
            c.r = shown(0);
            c.g = raw_.size() == 3 ? shown(1) : c.r;
            c.b = raw_.size() == 3 ? shown(2) : c.r;
        }
        return glm::vec4(c.r * alpha, c.g * alpha, c.b * alpha, alpha);
    }

  private:
    static GDALRasterBand* at(GDALRasterBand* band, int overview) {
        return overview < 0 ? band : band->GetOverview(overview);
    }
    const PictureFile& file_;
    std::vector<GDALRasterBand*> bands_;
    GDALRasterBand* alpha_ = nullptr;
    float full_ = 255.0f;
    std::vector<Raw> raw_;
    Raw rawAlpha_;
};

} // namespace

std::unique_ptr<GDALDataset> openPictureData(const std::string& path) {
    registerGdalDrivers();
    return std::unique_ptr<GDALDataset>(
        GDALDataset::Open(path.c_str(), GDAL_OF_RASTER | GDAL_OF_READONLY, kDrivers.data()));
}

Result<PictureFile> PictureFile::describe(GDALDataset& data, const std::string& path,
                                          const DrapeOptions& options,
                                          std::vector<std::string>& notes) {
    PictureFile file;
    file.path = path;
    file.width = data.GetRasterXSize();
    file.height = data.GetRasterYSize();
    Describer describer{data, file, options, notes};
    // First what it is: a height model without a place is refused as a height model.
    for (const auto step : {&Describer::findBands, &Describer::findPlace, &Describer::findCrs})
        if (Failure wrong = (describer.*step)())
            return *wrong;
    return file;
}

PictureLevel PictureFile::level(double acrossPixels, double downPixels) const {
    PictureLevel out;
    double coarser = 1.0; // of the copy taken
    int w = width, h = height;
    for (std::size_t i = 0; i < overviewWidths.size(); ++i) {
        if (overviewWidths[i] <= 0 || overviewHeights[i] <= 0)
            continue;
        const double factor = double(width) / overviewWidths[i];
        // A copy half a hundredth too coarse is meant for this size.
        if (factor > coarser && factor <= 1.005 * std::min(acrossPixels, downPixels)) {
            coarser = factor;
            out.overview = int(i);
            w = overviewWidths[i];
            h = overviewHeights[i];
        }
    }
    const auto blocks = [](double pixels, int size) {
        return int(std::clamp(std::round(pixels), 1.0, double(size)));
    };
    out.across = blocks(acrossPixels * w / width, w);
    out.down = blocks(downPixels * h / height, h);
    out.columns = (w - 1) / out.across + 1;
    out.rows = (h - 1) / out.down + 1;
    out.columnPixels = double(out.across) * width / w;
    out.rowPixels = double(out.down) * height / h;
    return out;
}

Result<std::vector<glm::vec4>> PictureFile::read(GDALDataset& data, const PictureLevel& level,
                                                 const BlockWindow& window) const {
    const GdalQuiet quiet;
    const int w = level.overview < 0 ? width : overviewWidths[std::size_t(level.overview)];
    const int h = level.overview < 0 ? height : overviewHeights[std::size_t(level.overview)];
    const int left = window.column * level.across;
    const int columns = std::min((window.column + window.columns) * level.across, w) - left;
    // Rows of blocks a time, so that no more than some 4 million pixels are held.
    constexpr std::int64_t kPixels = std::int64_t(1) << 22;
    const std::int64_t pixelsARow = std::int64_t(columns) * level.down;
    const int step = int(std::clamp<std::int64_t>(kPixels / pixelsARow, 1, window.rows));
    std::vector<glm::vec4> out(std::size_t(window.columns) * std::size_t(window.rows),
                               glm::vec4(0.0f));
    Rows rows(*this, data, level.overview);
    for (int first = 0; first < window.rows; first += step) {
        const int top = (window.row + first) * level.down;
        const int bottom =
            std::min((window.row + std::min(first + step, window.rows)) * level.down, h);
        if (!rows.read(left, top, columns, bottom - top))
            return Error{path, "cannot be read: " + quiet.reason()};
        for (int y = top; y < bottom; ++y) {
            glm::vec4* blocks =
                &out[std::size_t(y / level.down - window.row) * std::size_t(window.columns)];
            const std::size_t line = std::size_t(y - top) * std::size_t(columns);
            for (int x = 0, block = 0, inBlock = 0; x < columns; ++x) {
                blocks[block] += rows.pixel(line + std::size_t(x));
                if (++inBlock == level.across) {
                    inBlock = 0;
                    ++block;
                }
            }
        }
    }
    for (int j = 0; j < window.rows; ++j)
        for (int i = 0; i < window.columns; ++i) {
            const int across = std::min(level.across, w - (window.column + i) * level.across);
            const int down = std::min(level.down, h - (window.row + j) * level.down);
            out[std::size_t(j) * std::size_t(window.columns) + std::size_t(i)] /=
                float(across) * float(down);
        }
    return out;
}

} // namespace gnomon
