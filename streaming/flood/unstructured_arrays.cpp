#include "streaming/flood/unstructured_arrays.h"

#include "streaming/terrain/gdal_quiet.h"

#include <gdal_priv.h>
#include <hdf5.h>
#include <ogr_spatialref.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <mutex>

namespace gnomon {

namespace {

// Both formats end in the one libhdf5: one at a time, and nothing on the terminal.
class Library {
  public:
    Library() : lock_(mutex()) {
        H5Eget_auto2(H5E_DEFAULT, &print_, &printTo_);
        H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    }
    ~Library() { H5Eset_auto2(H5E_DEFAULT, print_, printTo_); }
    Library(const Library&) = delete;
    Library& operator=(const Library&) = delete;

    std::string reason() const { return quiet_.reason(); }

  private:
    static std::mutex& mutex() {
        static std::mutex mutex;
        return mutex;
    }

    std::scoped_lock<std::mutex> lock_;
    GdalQuiet quiet_;
    H5E_auto2_t print_ = nullptr;
    void* printTo_ = nullptr;
};

// No variable of a sound file has more elements than this: a file that claims more than some four
// a byte is no flood result but means to fill the memory.
std::uint64_t elementLimit(std::uint64_t fileBytes) {
    constexpr std::uint64_t kAlways = 1'000'000, kPerByte = 4;
    return kAlways + kPerByte * fileBytes;
}

// HDF5 takes a whole chunk into memory, however little of it is wanted.
constexpr std::uint64_t kMaxChunkBytes = 256u << 20;

std::optional<std::string> textOf(const GDALIHasAttribute& owner, const std::string& name) {
    const auto attribute = owner.GetAttribute(name);
    const char* text = attribute ? attribute->ReadAsString() : nullptr;
    if (text == nullptr)
        return std::nullopt;
    std::string value(text);
    while (!value.empty() && (value.back() == ' ' || value.back() == '\0'))
        value.pop_back();
    return value;
}

std::optional<double> numberOf(const GDALIHasAttribute& owner, const std::string& name) {
    const auto attribute = owner.GetAttribute(name);
    if (!attribute || attribute->GetDataType().GetClass() != GEDTC_NUMERIC ||
        attribute->GetTotalElementsCount() < 1)
        return std::nullopt;
    return attribute->ReadAsDouble();
}

} // namespace

std::optional<std::string> ArrayVariable::text(const std::string& attribute) const {
    const Library library;
    return textOf(*array_, attribute);
}

std::optional<double> ArrayVariable::number(const std::string& attribute) const {
    const Library library;
    return numberOf(*array_, attribute);
}

std::string ArrayVariable::wellKnownText() const {
    const Library library;
    const auto crs = array_->GetSpatialRef();
    char* text = nullptr;
    std::string result;
    constexpr const char* kOptions[] = {"FORMAT=WKT2_2019", nullptr};
    if (crs && !crs->IsLocal() && crs->exportToWkt(&text, kOptions) == OGRERR_NONE &&
        text != nullptr)
        result = text;
    CPLFree(text);
    return result;
}

Failure ArrayVariable::fits(std::span<const std::size_t> count, std::size_t bytesEach) const {
    std::uint64_t elements = 1;
    for (const std::size_t n : count) {
        if (n != 0 && elements > limit_ / n)
            return Error{path_, "'" + name_ + "' claims more values than the file can hold"};
        elements *= n;
    }
    std::uint64_t chunk = bytesEach;
    for (const GUInt64 n : array_->GetBlockSize()) {
        if (n != 0 && chunk > kMaxChunkBytes / n)
            return Error{path_, "'" + name_ + "' is stored in chunks of over 256 MiB"};
        chunk *= std::max<std::uint64_t>(n, 1);
    }
    return {};
}

template <class T>
Result<std::vector<T>> ArrayVariable::read(std::span<const std::uint64_t> start,
                                           std::span<const std::size_t> count) const {
    const Library library;
    const auto& type = array_->GetDataType();
    if (type.GetClass() != GEDTC_NUMERIC || GDALDataTypeIsComplex(type.GetNumericDataType()))
        return Error{path_, "'" + name_ + "' does not hold numbers"};
    if (Failure failure = fits(count, type.GetSize()))
        return *failure;
    std::size_t elements = 1;
    for (const std::size_t n : count)
        elements *= n;
    std::vector<T> values(elements);
    if (elements == 0)
        return values;
    const auto wanted = GDALExtendedDataType::Create(sizeof(T) == 4 ? GDT_Float32 : GDT_Float64);
    std::vector<GUInt64> from(start.begin(), start.end());
    if (!array_->Read(from.data(), count.data(), nullptr, nullptr, wanted, values.data(),
                      values.data(), values.size() * sizeof(T)))
        return Error{path_, "'" + name_ + "' cannot be read: " + library.reason()};

    // What NetCDF leaves where nothing was written; no level or place is as large.
    constexpr double kUnwritten = 9.9e36;
    const T fill = T(fill_.value_or(std::nan(""))), missing = T(missing_.value_or(std::nan("")));
    for (T& value : values) {
        if (value == fill || value == missing || !(std::abs(double(value)) < kUnwritten))
            value = std::numeric_limits<T>::quiet_NaN();
        else if (scale_ != 1.0 || offset_ != 0.0)
            value = T(double(value) * scale_ + offset_);
    }
    return values;
}

Result<std::vector<double>> ArrayVariable::readAll() const {
    std::vector<std::uint64_t> start(dimensions_.size(), 0);
    std::vector<std::size_t> count;
    for (const ArrayDimension& dimension : dimensions_)
        count.push_back(std::size_t(dimension.size));
    return read<double>(start, count);
}

Result<std::vector<float>> ArrayVariable::readRow(std::uint64_t index) const {
    if (dimensions_.empty() || dimensions_.size() > 2)
        return Error{path_, "'" + name_ + "' has " + std::to_string(dimensions_.size()) +
                                " dimensions where one or two were expected"};
    if (dimensions_.size() == 1) {
        const std::uint64_t start = 0;
        const std::size_t count = std::size_t(dimensions_[0].size);
        return read<float>({&start, 1}, {&count, 1});
    }
    if (index >= dimensions_[0].size)
        return Error{path_, "'" + name_ + "' has no step " + std::to_string(index)};
    const std::array start{index, std::uint64_t(0)};
    const std::array count{std::size_t(1), std::size_t(dimensions_[1].size)};
    return read<float>(start, count);
}

Result<std::vector<float>> ArrayVariable::readBlock(std::span<const std::uint64_t> start,
                                                    std::span<const std::size_t> count) const {
    return read<float>(start, count);
}

Result<std::vector<std::string>> ArrayVariable::readTexts() const {
    const Library library;
    if (array_->GetDataType().GetClass() != GEDTC_STRING || dimensions_.size() != 1)
        return Error{path_, "'" + name_ + "' is no list of texts"};
    const std::size_t count = std::size_t(dimensions_[0].size);
    // Each text has bytes of its own in the file.
    if (Failure failure = fits({&count, 1}, sizeof(char*)))
        return *failure;
    std::vector<char*> texts(count, nullptr);
    const GUInt64 start = 0;
    if (count == 0 ||
        !array_->Read(&start, &count, nullptr, nullptr, GDALExtendedDataType::CreateString(),
                      texts.data(), texts.data(), texts.size() * sizeof(char*)))
        return Error{path_, "'" + name_ + "' cannot be read: " + library.reason()};
    std::vector<std::string> result;
    for (char* text : texts) {
        result.emplace_back(text != nullptr ? text : "");
        CPLFree(text);
    }
    return result;
}

std::optional<ArrayFile::Format> ArrayFile::formatOf(const std::string& path) {
    std::error_code failed;
    if (!std::filesystem::is_regular_file(path, failed))
        return std::nullopt;
    std::array<char, 8> magic{};
    std::ifstream(path, std::ios::binary).read(magic.data(), magic.size());
    if (std::memcmp(magic.data(), "\x89HDF\r\n\x1a\n", 8) == 0)
        return Format::Hdf5;
    if (std::memcmp(magic.data(), "CDF", 3) == 0 &&
        (magic[3] == 1 || magic[3] == 2 || magic[3] == 5))
        return Format::NetCdf;
    return std::nullopt;
}

Result<ArrayFile> ArrayFile::open(const std::string& path, Format format) {
    std::error_code failed;
    const auto bytes = std::filesystem::file_size(path, failed);
    if (failed)
        return Error{path, "cannot be read: " + failed.message()};
    registerGdalDrivers();
    const Library library;
    const char* const drivers[] = {format == Format::NetCdf ? "netCDF" : "HDF5", nullptr};
    // Without the prefix the driver takes only some endings, and no 64-bit data format.
    const bool prefixed = format == Format::NetCdf && path.find('"') == std::string::npos;
    const std::string name = prefixed ? "NETCDF:\"" + path + "\"" : path;
    const std::unique_ptr<GDALDataset> data(
        GDALDataset::Open(name.c_str(), GDAL_OF_MULTIDIM_RASTER | GDAL_OF_READONLY, drivers));
    ArrayFile file;
    file.root_ = data ? data->GetRootGroup() : nullptr;
    if (!file.root_)
        return Error{path, "cannot be read: " + library.reason()};
    file.path_ = path;
    file.fileBytes_ = bytes;
    return file;
}

std::shared_ptr<GDALGroup> ArrayFile::group(const std::string& path) const {
    auto at = root_;
    for (std::size_t from = 0; at && from < path.size();) {
        const std::size_t slash = std::min(path.find('/', from), path.size());
        at = at->OpenGroup(path.substr(from, slash - from));
        from = slash + 1;
    }
    return at;
}

std::vector<std::string> ArrayFile::groups(const std::string& path) const {
    const Library library;
    const auto at = group(path);
    return at ? at->GetGroupNames() : std::vector<std::string>();
}

std::vector<std::string> ArrayFile::arrays(const std::string& path) const {
    const Library library;
    const auto at = group(path);
    constexpr const char* kAlsoScalars[] = {"SHOW_ALL=YES", nullptr};
    return at ? at->GetMDArrayNames(kAlsoScalars) : std::vector<std::string>();
}

std::optional<ArrayVariable> ArrayFile::find(const std::string& path,
                                             const std::string& name) const {
    const Library library;
    const auto at = group(path);
    const auto array = at ? at->OpenMDArray(name) : nullptr;
    if (!array)
        return std::nullopt;
    ArrayVariable variable;
    variable.array_ = array;
    variable.path_ = path_;
    variable.name_ = name;
    variable.unit_ = array->GetUnit();
    variable.limit_ = elementLimit(fileBytes_);
    for (const auto& dimension : array->GetDimensions())
        variable.dimensions_.push_back({dimension->GetName(), dimension->GetSize()});
    if (array->GetDataType().GetClass() == GEDTC_NUMERIC) {
        bool has = false;
        const double fill = array->GetNoDataValueAsDouble(&has);
        if (has)
            variable.fill_ = fill;
        variable.missing_ = numberOf(*array, "missing_value");
        const double scale = array->GetScale(&has);
        variable.scale_ = has ? scale : 1.0;
        const double offset = array->GetOffset(&has);
        variable.offset_ = has ? offset : 0.0;
    }
    return variable;
}

std::optional<std::string> ArrayFile::text(const std::string& path,
                                           const std::string& attribute) const {
    const Library library;
    const auto at = group(path);
    return at ? textOf(*at, attribute) : std::nullopt;
}

std::optional<double> ArrayFile::number(const std::string& path,
                                        const std::string& attribute) const {
    const Library library;
    const auto at = group(path);
    return at ? numberOf(*at, attribute) : std::nullopt;
}

} // namespace gnomon
