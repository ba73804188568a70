// Between the readers of single formats and readFeatures: features as their file has them, in the
// units and axes of its own coordinate reference system.
#pragma once

#include "streaming/features/features.h"

namespace gnomon {

struct RawFeatures {
    std::vector<Feature> features; // east, north in the CRS's units; z NaN where there is none
    std::string crs;               // for PROJ: a WKT or "EPSG:n"; empty when the file names none
    std::string crsName;           // for people
    // Degrees were assumed because the format says so, not because the file does.
    bool crsIsFormats = false;
};

// Each appends what it found, a layer of a file at a time; notes and what is left out go into
// `file`.
Failure readWithOgr(const std::string& path, std::vector<RawFeatures>& out, FeatureFile& file);
Failure readCityJson(const std::string& path, const std::string& text,
                     std::vector<RawFeatures>& out, FeatureFile& file);
Failure readCsv(const std::string& path, const std::string& text, std::vector<RawFeatures>& out,
                FeatureFile& file);

// Brings a layer to longitude, latitude, ellipsoidal height and appends it to `file`. `path` is for
// messages. Features that have no place are left out; fails when none has one.
Failure placeFeatures(RawFeatures raw, const std::string& path, const FeatureOptions& options,
                      FeatureFile& file);

// Lines of one kind ("id: its outline crosses itself"): as many as somebody may read, the others as
// a number.
inline constexpr std::size_t kMostLines = 20;
class ManyLines {
  public:
    explicit ManyLines(std::string others) : others_(std::move(others)) {}
    // False: there are enough already.
    bool add() { return ++count_ <= kMostLines; }
    std::size_t count() const { return count_; }
    // "and 12 more …", or nothing.
    std::optional<std::string> rest() const;

  private:
    std::string others_;
    std::size_t count_ = 0;
};

} // namespace gnomon
