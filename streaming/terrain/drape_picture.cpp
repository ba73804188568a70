#include "streaming/terrain/drape_picture.h"

#include "geo/ellipsoid.h"
#include "streaming/terrain/drape_grid.h"
#include "streaming/terrain/drape_picture_file.h"
#include "streaming/terrain/gdal_quiet.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <mutex>

namespace gnomon {

namespace {

using Transformation = std::unique_ptr<OGRCoordinateTransformation>;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// Degrees of longitude and latitude to the system or back. A datum without relation to WGS 84 is
// taken for it only where PROJ knows no better way.
Transformation connect(const OGRSpatialReference& crs, bool toLonLat) {
    OGRSpatialReference lonLat;
    lonLat.importFromEPSG(4326);
    lonLat.SetAxisMappingStrategy(OAMS_TRADITIONAL_GIS_ORDER);
    for (const bool ballpark : {false, true}) {
        OGRCoordinateTransformationOptions options;
        options.SetBallparkAllowed(ballpark);
        Transformation found(toLonLat ? OGRCreateCoordinateTransformation(&crs, &lonLat, options)
                                      : OGRCreateCoordinateTransformation(&lonLat, &crs, options));
        if (found)
            return found;
    }
    return nullptr;
}

void transform(OGRCoordinateTransformation& by, std::vector<glm::dvec2>& places) {
    std::vector<double> x, y;
    std::vector<int> fine(places.size());
    for (const glm::dvec2& p : places) {
        x.push_back(p.x);
        y.push_back(p.y);
    }
    by.Transform(int(places.size()), x.data(), y.data(), nullptr, fine.data());
    for (std::size_t i = 0; i < places.size(); ++i) {
        const bool placed = fine[i] && std::isfinite(x[i]) && std::isfinite(y[i]);
        places[i] = placed ? glm::dvec2(x[i], y[i]) : glm::dvec2(kNaN);
    }
}

glm::dvec2 affine(const std::array<double, 6>& t, glm::dvec2 p) {
    return {t[0] + p.x * t[1] + p.y * t[2], t[3] + p.x * t[4] + p.y * t[5]};
}

// What one thread works with.
struct Opened {
    std::unique_ptr<GDALDataset> data;
    Transformation fromLonLat;
    ~Opened() {
        const GdalQuiet quiet; // closing may complain
        data.reset();
    }
};

class Picture : public Drape {
  public:
    explicit Picture(PictureFile file) : file_(std::move(file)) {}
    Failure locate();

    std::array<double, 4> extent() const override { return extent_; }
    double texelMetres() const override { return texelMetres_; }
    Failure paint(std::span<const glm::dvec2> lonLat, int width,
                  std::span<std::uint8_t> rgba) const override;
    void keep(std::unique_ptr<Opened> opened) const {
        const std::lock_guard lock(mutex_);
        pool_.push_back(std::move(opened));
    }
    Result<std::unique_ptr<Opened>> open() const;

  private:
    void pixelsOf(OGRCoordinateTransformation& fromLonLat, std::vector<glm::dvec2>& places) const;
    bool holds(glm::dvec2 pixel) const {
        return pixel.x >= 0.0 && pixel.y >= 0.0 && pixel.x <= file_.width &&
               pixel.y <= file_.height;
    }
    PictureLevel levelFor(std::span<const glm::dvec2> pixels, int width) const;
    Failure paintPixels(GDALDataset& data, std::span<const glm::dvec2> pixels, int width,
                        std::span<std::uint8_t> rgba) const;

    PictureFile file_;
    std::array<double, 4> extent_{};
    double texelMetres_ = 0.0;
    mutable std::mutex mutex_;
    mutable std::vector<std::unique_ptr<Opened>> pool_; // at rest
};

Result<std::unique_ptr<Opened>> Picture::open() const {
    {
        const std::lock_guard lock(mutex_);
        if (!pool_.empty()) {
            std::unique_ptr<Opened> opened = std::move(pool_.back());
            pool_.pop_back();
            return opened;
        }
    }
    const GdalQuiet quiet;
    auto opened = std::make_unique<Opened>();
    opened->data = openPictureData(file_.path);
    if (!opened->data || opened->data->GetRasterXSize() != file_.width ||
        opened->data->GetRasterYSize() != file_.height)
        return Error{file_.path, "cannot be read again: " + quiet.reason()};
    opened->fromLonLat = connect(file_.crs, false);
    if (!opened->fromLonLat)
        return Error{file_.path, "PROJ knows no way from WGS 84 to its system: " + quiet.reason()};
    return opened;
}

// Columns and rows from the upper left corner.
void Picture::pixelsOf(OGRCoordinateTransformation& fromLonLat,
                       std::vector<glm::dvec2>& places) const {
    transform(fromLonLat, places);
    const double middle = affine(file_.place, 0.5 * glm::dvec2(file_.width, file_.height)).x;
    for (glm::dvec2& p : places) {
        if (file_.turn > 0.0)
            p.x = middle + std::remainder(p.x - middle, file_.turn);
        p = affine(file_.pixelFromPlace, p);
    }
}

// Its extent and the size of its pixels, from a grid of places over all of it.
Failure Picture::locate() {
    const GdalQuiet quiet;
    const Transformation toLonLat = connect(file_.crs, true);
    Result<std::unique_ptr<Opened>> opened = open();
    if (!opened)
        return opened.error();
    if (!toLonLat)
        return Error{file_.path, "its system cannot be brought to WGS 84: " + quiet.reason()};
    constexpr int kSteps = 64;
    const glm::dvec2 size(file_.width, file_.height);
    std::vector<glm::dvec2> places;
    for (int j = 0; j <= kSteps; ++j)
        for (int i = 0; i <= kSteps; ++i)
            places.push_back(affine(file_.place, size * glm::dvec2(i, j) / double(kSteps)));
    const glm::dvec2 middle = 0.5 * size;
    for (const glm::dvec2 side : {glm::dvec2(0, 0), glm::dvec2(1, 0), glm::dvec2(0, 1)})
        places.push_back(affine(file_.place, middle + side));
    transform(*toLonLat, places);
    const auto metres = [](glm::dvec2 a, glm::dvec2 b) {
        return length(ecefOf({b.x, b.y, 0.0}) - ecefOf({a.x, a.y, 0.0}));
    };
    const glm::dvec2* m = &places[places.size() - 3];
    for (int i = 0; i < 3; ++i)
        if (!std::isfinite(m[i].x) || std::abs(m[i].y) > 90.0)
            return Error{file_.path, "its middle lies nowhere on the Earth: is its coordinate "
                                     "reference system right?"};
    texelMetres_ = std::min(metres(m[0], m[1]), metres(m[0], m[2]));

    double west = m->x, east = m->x, south = m->y, north = m->y;
    for (const glm::dvec2& p : places) {
        if (!std::isfinite(p.x))
            continue;
        const double x = m->x + std::remainder(p.x - m->x, 360.0);
        west = std::min(west, x);
        east = std::max(east, x);
        south = std::min(south, p.y);
        north = std::max(north, p.y);
    }
    for (const double pole : {-90.0, 90.0}) {
        std::vector<glm::dvec2> at{{0.0, pole}};
        pixelsOf(*(*opened)->fromLonLat, at);
        if (!file_.crs.IsGeographic() && holds(at[0])) {
            (pole < 0 ? south : north) = pole;
            west = -180.0;
            east = 180.0;
        }
    }
    // Between the grid's places an edge may bulge.
    const double slackX = (east - west) / kSteps / 8.0, slackY = (north - south) / kSteps / 8.0;
    const auto wrapped = [](double x) { return std::remainder(x, 360.0); };
    const bool all = east - west + 2 * slackX >= 360.0;
    extent_ = {all ? -180.0 : wrapped(west - slackX), std::max(-90.0, south - slackY),
               all ? 180.0 : wrapped(east + slackX), std::min(90.0, north + slackY)};
    keep(std::move(*opened));
    return {};
}

// By how far the texels lie apart in pixels: the middle one of many, since some may be torn.
PictureLevel Picture::levelFor(std::span<const glm::dvec2> pixels, int width) const {
    std::vector<double> across, down;
    const int height = int(pixels.size() / std::size_t(width));
    constexpr int kLooks = 16; // a side
    const int stepX = std::max(1, width / kLooks), stepY = std::max(1, height / kLooks);
    for (int row = 0; row + 1 < height; row += stepY)
        for (int column = 0; column + 1 < width; column += stepX) {
            const std::size_t k = std::size_t(row) * std::size_t(width) + std::size_t(column);
            const glm::dvec2 u = pixels[k + 1] - pixels[k];
            const glm::dvec2 v = pixels[k + std::size_t(width)] - pixels[k];
            const double x = std::hypot(u.x, v.x), y = std::hypot(u.y, v.y);
            if (std::isfinite(x) && std::isfinite(y)) {
                across.push_back(x);
                down.push_back(y);
            }
        }
    const auto median = [](std::vector<double>& of) {
        if (of.empty())
            return 1.0;
        const auto at = of.begin() + std::ptrdiff_t(of.size() / 2);
        std::nth_element(of.begin(), at, of.end());
        return *at;
    };
    return file_.level(median(across), median(down));
}

Failure Picture::paintPixels(GDALDataset& data, std::span<const glm::dvec2> pixels, int width,
                             std::span<std::uint8_t> rgba) const {
    glm::dvec2 low(file_.width, file_.height), high(0.0);
    bool any = false;
    for (const glm::dvec2& p : pixels)
        if (holds(p)) {
            low = glm::min(low, p);
            high = glm::max(high, p);
            any = true;
        }
    if (!any)
        return {};
    PictureLevel level = levelFor(pixels, width);
    BlockWindow window;
    // Blocks are larger than the distance of texels asks for only where the tile is torn.
    const std::int64_t most = std::int64_t(16) * std::int64_t(pixels.size()) + 65536;
    for (double coarser = 1.0;; coarser *= 2.0) {
        level =
            coarser == 1.0 ? level : file_.level(2.0 * level.columnPixels, 2.0 * level.rowPixels);
        const auto block = [](double pixel, double size, int count) {
            return int(std::clamp(std::floor(pixel / size - 0.5), 0.0, double(count - 1)));
        };
        window.column = block(low.x, level.columnPixels, level.columns);
        window.row = block(low.y, level.rowPixels, level.rows);
        window.columns =
            std::min(block(high.x, level.columnPixels, level.columns) + 2, level.columns) -
            window.column;
        window.rows =
            std::min(block(high.y, level.rowPixels, level.rows) + 2, level.rows) - window.row;
        if (std::int64_t(window.columns) * window.rows <= most)
            break;
    }
    const Result<std::vector<glm::vec4>> read = file_.read(data, level, window);
    if (!read)
        return read.error();
    const auto at = [&](int column, int row) {
        column = std::clamp(column, 0, window.columns - 1);
        row = std::clamp(row, 0, window.rows - 1);
        return (*read)[std::size_t(row) * std::size_t(window.columns) + std::size_t(column)];
    };
    for (std::size_t k = 0; k < pixels.size(); ++k) {
        if (!holds(pixels[k]))
            continue;
        const double x = pixels[k].x / level.columnPixels - 0.5 - window.column;
        const double y = pixels[k].y / level.rowPixels - 0.5 - window.row;
        const int i = int(std::floor(x)), j = int(std::floor(y));
        const float s = float(x - i), t = float(y - j);
        const glm::vec4 c = (1 - t) * ((1 - s) * at(i, j) + s * at(i + 1, j)) +
                            t * ((1 - s) * at(i, j + 1) + s * at(i + 1, j + 1));
        if (!(c.a > 0.0f))
            continue;
        const double color[3] = {c.r / c.a, c.g / c.a, c.b / c.a};
        paintOver(&rgba[4 * k], color, c.a);
    }
    return {};
}

Failure Picture::paint(std::span<const glm::dvec2> lonLat, int width,
                       std::span<std::uint8_t> rgba) const {
    assert(width > 0 && rgba.size() == 4 * lonLat.size());
    Result<std::unique_ptr<Opened>> opened = open();
    if (!opened)
        return opened.error();
    Failure wrong;
    {
        const GdalQuiet quiet;
        const ExactPlaces exact = [&](std::vector<glm::dvec2>& places) {
            pixelsOf(*(*opened)->fromLonLat, places);
        };
        constexpr double kFineEnough = 1.0 / 8.0; // of a pixel; an eighth of it may be off
        const std::vector<glm::dvec2> pixels = mappedTexels(lonLat, width, exact, kFineEnough);
        wrong = paintPixels(*(*opened)->data, pixels, width, rgba);
    }
    keep(std::move(*opened));
    return wrong;
}

} // namespace

Result<std::shared_ptr<const Drape>> openDrapePicture(const std::string& path,
                                                      const DrapeOptions& options,
                                                      std::vector<std::string>& notes) {
    const GdalQuiet quiet;
    auto first = std::make_unique<Opened>();
    first->data = openPictureData(path);
    if (!first->data)
        return Error{path, "cannot be read as a picture: " + quiet.reason()};
    std::vector<std::string> said;
    Result<PictureFile> file = PictureFile::describe(*first->data, path, options, said);
    if (!file)
        return file.error();
    auto picture = std::make_shared<Picture>(std::move(*file));
    if (Failure wrong = picture->locate())
        return *wrong;
    notes.insert(notes.end(), said.begin(), said.end());
    return std::shared_ptr<const Drape>(std::move(picture));
}

bool looksLikeRaster(const std::string& path) {
    const GdalQuiet quiet;
    return openPictureData(path) != nullptr;
}

} // namespace gnomon
