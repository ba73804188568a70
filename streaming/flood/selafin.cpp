#include "streaming/flood/selafin.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <limits>

namespace gnomon {

namespace {

constexpr std::size_t kTitleBytes = 80;
constexpr std::size_t kNameBytes = 32; // 16 of the name, 16 of the unit
constexpr std::uint64_t kMarkerBytes = 4;

// Records as Fortran writes them: length, bytes, length again.
class Records {
  public:
    explicit Records(const std::string& path) : path_(path), file_(path, std::ios::binary) {
        std::error_code failed;
        const auto size = std::filesystem::file_size(path, failed);
        size_ = failed ? 0 : size;
    }

    std::uint64_t size() const { return size_; }
    std::uint64_t position() const { return position_; }
    void seek(std::uint64_t position) { position_ = position; }
    void setBigEndian(bool big) { swap_ = big != (std::endian::native == std::endian::big); }

    Error broken(const std::string& why) const { return {path_, why}; }

    // A record of exactly `bytes`.
    Result<std::vector<char>> record(std::uint64_t bytes, const char* what) {
        const std::string name = std::string("its record of ") + what;
        if (bytes > size_ || position_ > size_ - bytes ||
            size_ - bytes - position_ < 2 * kMarkerBytes)
            return broken(name + " is cut off");
        std::vector<char> data(bytes + 2 * kMarkerBytes);
        file_.clear();
        file_.seekg(std::streamoff(position_));
        if (!file_.read(data.data(), std::streamsize(data.size())))
            return broken(name + " cannot be read");
        for (const std::uint64_t at : {std::uint64_t(0), kMarkerBytes + bytes})
            if (std::uint32_t(integer(data.data() + at)) != bytes)
                return broken(name + " has not the length that its counts ask for");
        position_ += data.size();
        data.erase(data.begin(), data.begin() + kMarkerBytes);
        data.resize(bytes);
        return data;
    }
    // The length of the record that comes.
    std::uint64_t nextBytes() {
        std::array<char, kMarkerBytes> marker{};
        file_.clear();
        file_.seekg(std::streamoff(position_));
        return file_.read(marker.data(), marker.size()) ? std::uint32_t(integer(marker.data())) : 0;
    }

    std::int32_t integer(const char* at) const { return bits<std::int32_t, std::uint32_t>(at); }
    double real(const char* at, bool twice) const {
        return twice ? bits<double, std::uint64_t>(at) : bits<float, std::uint32_t>(at);
    }

  private:
    template <class T, class Bits>
    T bits(const char* at) const {
        Bits raw = 0;
        std::memcpy(&raw, at, sizeof raw);
        if (swap_)
            raw = sizeof(Bits) == 8 ? Bits(__builtin_bswap64(raw))
                                    : Bits(__builtin_bswap32(std::uint32_t(raw)));
        return std::bit_cast<T>(raw);
    }

    std::string path_;
    std::ifstream file_;
    std::uint64_t size_ = 0, position_ = 0;
    bool swap_ = std::endian::native == std::endian::little;
};

// Big-endian as TELEMAC writes it everywhere; little-endian as some compilers do.
std::optional<bool> bigEndian(const std::string& path) {
    std::error_code failed;
    if (!std::filesystem::is_regular_file(path, failed))
        return std::nullopt;
    constexpr std::size_t kStart = kTitleBytes + 16;
    std::array<unsigned char, kStart> start{};
    std::ifstream file(path, std::ios::binary);
    if (!file.read(reinterpret_cast<char*>(start.data()), start.size()))
        return std::nullopt;
    // The title's 80 bytes between markers, then the record of two counts, eight bytes.
    const auto is = [&](std::size_t at, unsigned char value, bool big) {
        const std::array<unsigned char, 4> want =
            big ? std::array<unsigned char, 4>{0, 0, 0, value}
                : std::array<unsigned char, 4>{value, 0, 0, 0};
        return std::equal(want.begin(), want.end(), start.begin() + std::ptrdiff_t(at));
    };
    for (const bool big : {true, false})
        if (is(0, kTitleBytes, big) && is(kTitleBytes + 4, kTitleBytes, big) &&
            is(kTitleBytes + 8, 8, big))
            return big;
    return std::nullopt;
}

std::string trimmed(const char* text, std::size_t length) {
    std::string out(text, length);
    while (!out.empty() && (out.back() == ' ' || out.back() == '\0'))
        out.pop_back();
    for (char& c : out)
        if (static_cast<unsigned char>(c) < ' ')
            c = ' ';
    return out;
}

constexpr std::array kStageNames = {"SURFACE LIBRE", "FREE SURFACE", "WATER SURFACE",
                                    "WATER LEVEL"};
constexpr std::array kDepthNames = {"HAUTEUR D'EAU", "HAUTEUR D EAU", "WATER DEPTH", "DEPTH"};
constexpr std::array kBedNames = {"FOND", "BOTTOM", "BED ELEVATION", "BOTTOM ELEVATION"};
constexpr std::array kUNames = {"VITESSE U", "VELOCITY U"};
constexpr std::array kVNames = {"VITESSE V", "VELOCITY V"};

class SelafinFile final : public MeshFile {
  public:
    explicit SelafinFile(const std::string& path) : path_(path), records_(path) {}

    Failure open(const FloodOptions& options, bool big);
    Result<std::vector<float>> water(std::size_t step) const override;
    bool hasVelocity() const override { return u_ && v_; }
    Result<std::vector<glm::vec2>> velocity(std::size_t step) const override;

  private:
    Failure readNames();
    Failure readDate();
    Failure readMesh();
    Failure readSteps();
    Failure chooseVariables(const FloodOptions& options);
    Failure readBed();
    Result<std::vector<float>> values(std::size_t step, std::size_t variable) const;
    std::uint64_t stepBytes() const;

    template <std::size_t N>
    std::optional<std::size_t> named(const std::array<const char*, N>& candidates) const {
        for (const char* candidate : candidates)
            for (std::size_t i = 0; i < names_.size(); ++i)
                if (names_[i] == candidate)
                    return i;
        return std::nullopt;
    }

    std::string path_;
    mutable Records records_;
    std::vector<std::string> names_;
    bool twice_ = false; // reals of eight bytes
    std::uint64_t points_ = 0, firstStep_ = 0;
    glm::dvec2 origin_{0.0};
    std::optional<double> startSeconds_;
    std::optional<std::size_t> water_, depth_, u_, v_;
};

Failure SelafinFile::readNames() {
    Result<std::vector<char>> counts = records_.record(8, "counts");
    if (!counts)
        return counts.error();
    const std::int64_t linear = records_.integer(counts->data()),
                       quadratic = records_.integer(counts->data() + 4);
    // Each has a record of its own.
    if (linear < 0 || quadratic < 0 ||
        std::uint64_t(linear + quadratic) > records_.size() / (kNameBytes + 2 * kMarkerBytes))
        return records_.broken("claims " + std::to_string(linear + quadratic) + " variables");
    for (std::int64_t i = 0; i < linear + quadratic; ++i) {
        const auto name = records_.record(kNameBytes, "a variable's name");
        if (!name)
            return name.error();
        if (i < linear)
            names_.push_back(trimmed(name->data(), kNameBytes / 2));
    }
    return {};
}

Failure SelafinFile::readDate() {
    const auto parameters = records_.record(40, "ten parameters");
    if (!parameters)
        return parameters.error();
    const auto parameter = [&](int i) {
        return records_.integer(parameters->data() + 4 * (i - 1));
    };
    origin_ = {double(parameter(3)), double(parameter(4))};
    if (parameter(7) > 1)
        return records_.broken("is a TELEMAC-3D result of " + std::to_string(parameter(7)) +
                               " planes: give the 2D result");
    if (parameter(10) != 1)
        return {};
    const auto date = records_.record(24, "the date");
    if (!date)
        return date.error();
    std::array<int, 6> part{};
    for (int i = 0; i < 6; ++i)
        part[std::size_t(i)] = records_.integer(date->data() + 4 * i);
    const auto moment = utcSeconds(part[0], part[1], part[2], part[3], part[4], double(part[5]));
    // 1 January 1900 is what TELEMAC writes for a run without a date.
    if (!moment)
        times.note = "its date is none; the steps are shown from 0 on";
    else if (part[0] > 1900 || part[1] > 1 || part[2] > 1)
        startSeconds_ = *moment;
    return {};
}

Failure SelafinFile::readMesh() {
    const auto counts = records_.record(16, "the mesh's counts");
    if (!counts)
        return counts.error();
    const std::int64_t elements = records_.integer(counts->data()),
                       points = records_.integer(counts->data() + 4),
                       corners = records_.integer(counts->data() + 8);
    if (elements < 1 || points < 3 || (corners != 3 && corners != 4))
        return records_.broken("has no mesh of triangles: " + std::to_string(elements) +
                               " elements of " + std::to_string(corners) + " corners, " +
                               std::to_string(points) + " points");
    points_ = std::uint64_t(points);
    const auto table = records_.record(std::uint64_t(elements) * std::uint64_t(corners) * 4,
                                       "the elements' corners");
    if (!table)
        return table.error();
    if (const auto rim = records_.record(points_ * 4, "the points on the rim"); !rim)
        return rim.error();
    twice_ = records_.nextBytes() == points_ * 8;
    const std::uint64_t bytes = twice_ ? 8 : 4;
    const auto x = records_.record(points_ * bytes, "the points' x");
    if (!x)
        return x.error();
    const auto y = records_.record(points_ * bytes, "the points' y");
    if (!y)
        return y.error();
    firstStep_ = records_.position();

    mesh.points.reserve(points_);
    for (std::uint64_t i = 0; i < points_; ++i)
        mesh.points.push_back(origin_ + glm::dvec2(records_.real(x->data() + i * bytes, twice_),
                                                   records_.real(y->data() + i * bytes, twice_)));
    std::array<std::uint32_t, 4> face{};
    for (std::int64_t e = 0; e < elements; ++e) {
        for (std::int64_t c = 0; c < corners; ++c) // from 1; what is none becomes a huge index
            face[std::size_t(c)] =
                std::uint32_t(records_.integer(table->data() + 4 * (e * corners + c))) - 1u;
        mesh.addFace(face.data(), std::size_t(corners));
    }
    return {};
}

std::uint64_t SelafinFile::stepBytes() const {
    const std::uint64_t bytes = twice_ ? 8 : 4;
    return bytes + 2 * kMarkerBytes + names_.size() * (points_ * bytes + 2 * kMarkerBytes);
}

Failure SelafinFile::readSteps() {
    const std::uint64_t rest = records_.size() - firstStep_;
    const std::uint64_t whole = rest / stepBytes();
    if (whole == 0)
        return records_.broken("has no whole step of time");
    if (rest % stepBytes() != 0)
        leftOut.push_back({path_, "step " + std::to_string(whole + 1) + " is cut off; left out"});
    for (std::uint64_t step = 0; step < whole; ++step) {
        records_.seek(firstStep_ + step * stepBytes());
        const auto time = records_.record(twice_ ? 8 : 4, "a step's time");
        if (!time)
            return time.error();
        times.seconds.push_back(records_.real(time->data(), twice_) + startSeconds_.value_or(0.0));
    }
    times.absolute = startSeconds_.has_value();
    return {};
}

Failure SelafinFile::chooseVariables(const FloodOptions& options) {
    const auto stage = named(kStageNames);
    depth_ = named(kDepthNames);
    u_ = named(kUNames);
    v_ = named(kVNames);
    std::string list;
    for (const std::string& name : names_)
        list += (list.empty() ? "" : ", ") + name;
    if (options.variable) {
        const auto found = std::find(names_.begin(), names_.end(), *options.variable);
        if (found == names_.end())
            return records_.broken("has no variable '" + *options.variable + "'; it has " + list);
        water_ = std::size_t(found - names_.begin());
        if (!options.kind && water_ != stage && water_ != depth_)
            return records_.broken("'" + *options.variable +
                                   "' may be a depth or a level: say which (depth= or stage=)");
        kind = options.kind.value_or(water_ == depth_ ? WaterKind::Depth : WaterKind::Stage);
        return {};
    }
    const bool depths = options.kind ? *options.kind == WaterKind::Depth : !stage;
    water_ = depths ? depth_ : stage;
    kind = depths ? WaterKind::Depth : WaterKind::Stage;
    if (!water_)
        return records_.broken(std::string("has no ") +
                               (depths ? "depth (WATER DEPTH, HAUTEUR D'EAU)"
                                       : "water level (FREE SURFACE, SURFACE LIBRE)") +
                               "; it has " + list);
    return {};
}

Failure SelafinFile::readBed() {
    const auto stage = named(kStageNames);
    const auto own = named(kBedNames);
    if (!own && (!stage || !depth_))
        return {};
    // TELEMAC's free surface is the bed plus the depth everywhere, dry or not.
    Result<std::vector<float>> values0 = values(0, own ? *own : *stage);
    if (!values0)
        return values0.error();
    bed = std::move(*values0);
    if (!own) {
        const auto depth = values(0, *depth_);
        if (!depth)
            return depth.error();
        for (std::size_t i = 0; i < bed.size(); ++i)
            bed[i] -= (*depth)[i];
    }
    return {};
}

Failure SelafinFile::open(const FloodOptions& options, bool big) {
    records_.setBigEndian(big);
    if (const auto title = records_.record(kTitleBytes, "the title"); !title)
        return title.error();
    if (Failure failure = readNames())
        return failure;
    if (Failure failure = readDate())
        return failure;
    if (Failure failure = readMesh())
        return failure;
    if (Failure failure = readSteps())
        return failure;
    if (Failure failure = chooseVariables(options))
        return failure;
    return readBed();
}

Result<std::vector<float>> SelafinFile::values(std::size_t step, std::size_t variable) const {
    const std::uint64_t bytes = twice_ ? 8 : 4;
    records_.seek(firstStep_ + step * stepBytes() + bytes + 2 * kMarkerBytes +
                  variable * (points_ * bytes + 2 * kMarkerBytes));
    const auto data = records_.record(points_ * bytes, "a step's values");
    if (!data)
        return data.error();
    std::vector<float> out(points_);
    for (std::uint64_t i = 0; i < points_; ++i)
        out[i] = float(records_.real(data->data() + i * bytes, twice_));
    return out;
}

Result<std::vector<float>> SelafinFile::water(std::size_t step) const {
    return values(step, *water_);
}

Result<std::vector<glm::vec2>> SelafinFile::velocity(std::size_t step) const {
    const auto u = values(step, *u_);
    if (!u)
        return u.error();
    const auto v = values(step, *v_);
    if (!v)
        return v.error();
    std::vector<glm::vec2> out(u->size());
    for (std::size_t i = 0; i < out.size(); ++i)
        out[i] = {(*u)[i], (*v)[i]};
    return out;
}

} // namespace

bool isSelafin(const std::string& path) {
    return bigEndian(path).has_value();
}

Result<std::unique_ptr<MeshFile>> readSelafin(const std::string& path,
                                              const FloodOptions& options) {
    const auto big = bigEndian(path);
    if (!big)
        return Error{path, "does not begin as a TELEMAC Selafin file"};
    auto file = std::make_unique<SelafinFile>(path);
    if (Failure failure = file->open(options, *big))
        return *failure;
    return std::unique_ptr<MeshFile>(std::move(file));
}

} // namespace gnomon
