#include "streaming/flood/unstructured_netcdf_header.h"

#include <algorithm>
#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <optional>
#include <set>
#include <vector>

namespace gnomon {

namespace {

// As libnetcdf itself limits names; more lists than this no result has.
constexpr std::uint64_t kLongestName = 256, kMostEntries = 100'000, kMostDimensions = 1024;

enum class Tag : std::uint32_t { Absent = 0, Dimension = 10, Variable = 11, Attribute = 12 };

// Bytes of each type, byte to double; from 7 on only in the 64-bit data format.
constexpr std::array<std::uint64_t, 12> kTypeBytes = {0, 1, 1, 2, 4, 4, 8, 1, 2, 4, 8, 8};

struct Variable {
    std::uint64_t begin = 0, bytes = 0; // of a record, when it has records
    bool hasRecords = false;
};

class Header {
  public:
    explicit Header(const std::string& path) : file_(path, std::ios::binary) {
        std::error_code failed;
        const auto size = std::filesystem::file_size(path, failed);
        size_ = failed ? 0 : size;
    }

    // What is wrong, or nothing.
    std::optional<std::string> check() {
        char magic[4] = {};
        if (!take(magic, 4))
            return kCutOff;
        version_ = magic[3];
        const std::uint64_t records = count();
        if (!good_)
            return kCutOff;
        // What is still being written: libnetcdf counts by the file's size.
        const std::uint64_t streaming = version_ == 5 ? ~std::uint64_t(0) : 0xffffffffu;
        records_ = records == streaming ? 0 : records;
        if (!dimensions() || !attributes() || !variables())
            return complaint_.empty() ? kCutOff : complaint_;
        return arraysFit();
    }

  private:
    static constexpr const char* kCutOff = "is cut off in its header";

    bool take(char* to, std::uint64_t bytes) {
        good_ = good_ && bytes <= size_ - at_ && file_.read(to, std::streamsize(bytes));
        at_ += good_ ? bytes : 0;
        return good_;
    }
    bool skip(std::uint64_t bytes) {
        good_ = good_ && bytes <= size_ - at_ && file_.seekg(std::streamoff(bytes), std::ios::cur);
        at_ += good_ ? bytes : 0;
        return good_;
    }
    std::uint64_t bigEndian(int bytes) {
        std::array<char, 8> raw{};
        if (!take(raw.data(), std::uint64_t(bytes)))
            return 0;
        std::uint64_t value = 0;
        for (int i = 0; i < bytes; ++i)
            value = value << 8 | static_cast<unsigned char>(raw[std::size_t(i)]);
        return value;
    }
    std::uint64_t count() { return bigEndian(version_ == 5 ? 8 : 4); }
    bool complain(const char* text) {
        complaint_ = text;
        return false;
    }

    std::optional<std::uint64_t> listOf(Tag wanted, std::uint64_t most) {
        const auto tag = Tag(std::uint32_t(bigEndian(4)));
        const std::uint64_t n = count();
        if (!good_)
            return std::nullopt;
        const bool sound = tag == wanted || (tag == Tag::Absent && n == 0);
        if (!sound || n > most) {
            complain("has a damaged header: a list of it is none");
            return std::nullopt;
        }
        return n;
    }
    std::optional<std::string> name() {
        const std::uint64_t length = count();
        if (good_ && (length == 0 || length > kLongestName)) {
            complain("has a damaged header: a name of no or endless length");
            return std::nullopt;
        }
        std::string text(length, '\0');
        if (!take(text.data(), length) || !skip((4 - length % 4) % 4))
            return std::nullopt;
        if (text.find('\0') != std::string::npos) {
            complain("has a damaged header: a name that is no text");
            return std::nullopt;
        }
        return text;
    }
    // Puts a name among those that are there; one of them again is complained of.
    bool newName(std::set<std::string>& names, const char* twice) {
        const auto its = name();
        return its && (names.insert(*its).second || complain(twice));
    }
    // 0 when it is none.
    std::uint64_t typeBytes() {
        const std::uint64_t type = bigEndian(4);
        if (good_ && (type < 1 || type > (version_ == 5 ? 11 : 6)))
            complain("has a damaged header: a type that is none");
        return good_ && complaint_.empty() ? kTypeBytes[type] : 0;
    }

    bool dimensions() {
        const auto n = listOf(Tag::Dimension, kMostDimensions);
        std::set<std::string> names;
        for (std::uint64_t i = 0; n && i < *n; ++i) {
            if (!newName(names, "has a damaged header: two dimensions of one name"))
                return false;
            lengths_.push_back(count());
        }
        if (std::count(lengths_.begin(), lengths_.end(), 0u) > 1)
            return complain("has a damaged header: two dimensions without an end");
        return n && good_;
    }
    bool attributes() {
        const auto n = listOf(Tag::Attribute, kMostEntries);
        for (std::uint64_t i = 0; n && i < *n; ++i) {
            const auto its = name();
            const std::uint64_t bytes = its ? typeBytes() : 0;
            const std::uint64_t values = count();
            if (bytes == 0 || !good_ || values > (size_ - at_) / bytes ||
                !skip((values * bytes + 3) / 4 * 4))
                return false;
        }
        return n && good_;
    }
    bool variables() {
        const auto n = listOf(Tag::Variable, kMostEntries);
        std::set<std::string> names;
        for (std::uint64_t i = 0; n && i < *n; ++i) {
            if (!newName(names, "has a damaged header: two variables of one name") || !variable())
                return false;
        }
        return n && good_;
    }
    bool variable() {
        Variable made;
        const std::uint64_t over = count();
        if (!good_ || over > kMostDimensions)
            return complain("has a damaged header: a variable of endless dimensions");
        std::uint64_t elements = 1;
        for (std::uint64_t i = 0; i < over; ++i) {
            const std::uint64_t id = count();
            if (!good_)
                return false;
            if (id >= lengths_.size() || (lengths_[id] == 0 && i != 0))
                return complain("has a damaged header: a variable over dimensions it has not");
            made.hasRecords = made.hasRecords || lengths_[id] == 0;
            const std::uint64_t length = std::max<std::uint64_t>(lengths_[id], 1);
            if (elements > size_ / length) // one element is a byte at least
                return complain("claims more values than it has bytes");
            elements *= length;
        }
        if (!attributes())
            return false;
        const std::uint64_t bytes = typeBytes();
        bigEndian(version_ == 5 ? 8 : 4); // its size, which the dimensions tell better
        made.begin = bigEndian(version_ == 1 ? 4 : 8);
        if (bytes == 0 || !good_)
            return false;
        made.bytes = elements * bytes;
        variables_.push_back(made);
        return true;
    }

    std::optional<std::string> arraysFit() const {
        const auto padded = [](std::uint64_t bytes) { return (bytes + 3) / 4 * 4; };
        std::uint64_t record = 0;
        int withRecords = 0;
        for (const Variable& variable : variables_)
            if (variable.hasRecords) {
                record += padded(variable.bytes);
                ++withRecords;
            }
        for (const Variable& variable : variables_) {
            const std::uint64_t stride = withRecords == 1 ? variable.bytes : record;
            std::uint64_t end = variable.bytes;
            if (variable.hasRecords && records_ == 0)
                continue;
            if (variable.hasRecords) {
                if (stride != 0 && records_ - 1 > size_ / stride)
                    return "claims more records than it has bytes";
                end += (records_ - 1) * stride;
            }
            if (variable.begin < at_ || variable.begin > size_ || end > size_ - variable.begin)
                return "is cut off: its arrays end " + std::to_string(variable.begin) + " + " +
                       std::to_string(end) + " bytes in, it has " + std::to_string(size_);
        }
        return std::nullopt;
    }

    std::ifstream file_;
    std::uint64_t size_ = 0, at_ = 0, records_ = 0;
    int version_ = 1;
    bool good_ = true;
    std::string complaint_;
    std::vector<std::uint64_t> lengths_; // 0: of the records
    std::vector<Variable> variables_;
};

} // namespace

Failure checkClassicNetCdf(const std::string& path) {
    if (const auto wrong = Header(path).check())
        return Error{path, *wrong};
    return {};
}

} // namespace gnomon
