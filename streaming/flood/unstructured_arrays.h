// NetCDF and HDF5 files as groups, arrays and attributes, read through GDAL's multidimensional
// side. GDAL and not libnetcdf or libhdf5 themselves: neither is safe for threads as Debian builds
// them, and GDAL's own lock then also holds against rasters in NetCDF that are read meanwhile. The
// one gap: HEC-RAS (HDF5) read while another thread reads a NetCDF-4 raster, which GDAL guards by
// another lock; so flood results are read by the thread that asks, and one file at a time.
#pragma once

#include "geo/result.h"

#include <cstdint>
#include <limits>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

class GDALGroup;
class GDALMDArray;

namespace gnomon {

struct ArrayDimension {
    std::string name;
    std::uint64_t size = 0;
};

class ArrayVariable {
  public:
    const std::string& name() const { return name_; }
    const std::vector<ArrayDimension>& dimensions() const { return dimensions_; }
    std::optional<std::string> text(const std::string& attribute) const;
    std::optional<double> number(const std::string& attribute) const;
    const std::string& unit() const { return unit_; }
    std::string wellKnownText() const; // of the coordinate reference system; "" for none

    // Row by row, scaled as the file says; NaN for its fill values.
    Result<std::vector<double>> readAll() const;
    // One row: the first dimension at `index` (when there are two), the last whole.
    Result<std::vector<float>> readRow(std::uint64_t index) const;
    // As many along each dimension from there on; they must lie in the array.
    Result<std::vector<float>> readBlock(std::span<const std::uint64_t> start,
                                         std::span<const std::size_t> count) const;
    Result<std::vector<std::string>> readTexts() const;

  private:
    friend class ArrayFile;
    template <class T>
    Result<std::vector<T>> read(std::span<const std::uint64_t> start,
                                std::span<const std::size_t> count) const;
    Failure fits(std::span<const std::size_t> count, std::size_t bytesEach) const;

    std::shared_ptr<GDALMDArray> array_;
    std::string path_, name_, unit_;
    std::vector<ArrayDimension> dimensions_;
    std::uint64_t limit_ = 0; // elements
    std::optional<double> fill_, missing_;
    double scale_ = 1.0, offset_ = 0.0;
};

class ArrayFile {
  public:
    enum class Format { NetCdf, Hdf5 };
    // What the first bytes say: one of the two, or neither.
    static std::optional<Format> formatOf(const std::string& path);
    static Result<ArrayFile> open(const std::string& path, Format format);

    const std::string& path() const { return path_; }
    // Groups are written "Geometry/2D Flow Areas"; "" is the root.
    std::vector<std::string> groups(const std::string& group) const;
    std::vector<std::string> arrays(const std::string& group) const;
    std::optional<ArrayVariable> find(const std::string& group, const std::string& name) const;
    std::optional<std::string> text(const std::string& group, const std::string& attribute) const;
    std::optional<double> number(const std::string& group, const std::string& attribute) const;

  private:
    std::shared_ptr<GDALGroup> group(const std::string& path) const;

    std::string path_;
    std::shared_ptr<GDALGroup> root_;
    std::uint64_t fileBytes_ = 0;
};

} // namespace gnomon
