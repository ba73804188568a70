// Text files of coordinates: the vertices of one polygon, a line each, or, where a header names
// more than coordinates, a point each.
#include "streaming/features/features_read.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <filesystem>
#include <limits>
#include <span>

namespace gnomon {

namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// A field's quotes go with its blanks; a line's must not: its first field may be a quoted one.
constexpr std::string_view kBlank = " \t\r", kBlankOrQuote = " \t\r\"";

std::string_view trimmed(std::string_view text, std::string_view of = kBlankOrQuote) {
    const std::size_t first = text.find_first_not_of(of);
    return first == text.npos ? std::string_view{}
                              : text.substr(first, text.find_last_not_of(of) - first + 1);
}

struct Format {
    char separator = ',';
    bool decimalComma = false;
};

Format formatOf(std::string_view line) {
    for (const char separator : {';', '\t', ','})
        if (line.find(separator) != line.npos)
            return {separator, separator != ','};
    return {' ', false};
}

std::vector<std::string_view> fieldsOf(std::string_view line, const Format& format) {
    std::vector<std::string_view> fields;
    if (format.separator == ' ') { // runs of blanks are one
        for (std::size_t at = line.find_first_not_of(" \r"); at != line.npos;) {
            const std::size_t end = std::min(line.find_first_of(" \r", at), line.size());
            fields.push_back(line.substr(at, end - at));
            at = line.find_first_not_of(" \r", end);
        }
        return fields;
    }
    bool quoted = false;
    std::size_t start = 0;
    for (std::size_t i = 0; i <= line.size(); ++i) {
        if (i < line.size() && line[i] == '"')
            quoted = !quoted;
        if (i == line.size() || (line[i] == format.separator && !quoted)) {
            fields.push_back(trimmed(line.substr(start, i - start)));
            start = i + 1;
        }
    }
    return fields;
}

std::optional<double> numberOf(std::string_view field, const Format& format) {
    std::string text(trimmed(field));
    if (format.decimalComma)
        std::replace(text.begin(), text.end(), ',', '.');
    const char* begin = text.data() + (text.starts_with('+') ? 1 : 0);
    double value = 0.0;
    const auto [end, error] = std::from_chars(begin, text.data() + text.size(), value);
    const bool whole = error == std::errc() && end == text.data() + text.size();
    return whole && std::isfinite(value) ? std::optional(value) : std::nullopt;
}

struct Columns {
    std::size_t x = 0, y = 1;
    std::optional<std::size_t> z;
    bool degrees = false; // by their names
    std::vector<std::string> names;
};

std::optional<std::size_t> find(const std::vector<std::string>& names,
                                std::span<const std::string_view> known) {
    for (const std::string_view name : known)
        for (std::size_t i = 0; i < names.size(); ++i) {
            std::string plain = names[i];
            std::transform(plain.begin(), plain.end(), plain.begin(),
                           [](unsigned char c) { return char(std::tolower(c)); });
            if (plain == name)
                return i;
        }
    return {};
}

Columns columnsOf(const std::vector<std::string_view>& header) {
    constexpr std::array<std::string_view, 8> kX = {"x",         "lon",  "lng",     "long",
                                                    "longitude", "east", "easting", "rechtswert"};
    constexpr std::array<std::string_view, 6> kY = {"y",     "lat",      "latitude",
                                                    "north", "northing", "hochwert"};
    constexpr std::array<std::string_view, 4> kZ = {"z", "elevation", "altitude", "level"};
    Columns columns;
    for (const std::string_view name : header)
        columns.names.emplace_back(name);
    const auto x = find(columns.names, kX), y = find(columns.names, kY);
    if (x && y) {
        columns.x = *x;
        columns.y = *y;
        const std::string_view first = header[*x];
        columns.degrees = first.size() >= 3 && std::tolower(first[0]) == 'l';
        columns.z = find(columns.names, kZ);
    } else if (header.size() == 3) {
        columns.z = 2;
    }
    return columns;
}

class CsvReader {
  public:
    CsvReader(const std::string& path, FeatureFile& file) : path_(path), file_(file) {
        id_ = std::filesystem::path(path).stem().string();
    }

    Failure run(std::string_view text, std::vector<RawFeatures>& out) {
        if (text.starts_with("\xef\xbb\xbf"))
            text.remove_prefix(3);
        std::size_t number = 0;
        for (std::size_t at = 0; at < text.size();) {
            const std::size_t end = std::min(text.find('\n', at), text.size());
            const std::string_view line = trimmed(text.substr(at, end - at), kBlank);
            at = end + 1;
            ++number;
            if (line.empty() || line.front() == '#')
                continue;
            if (Failure failure = take(line, number))
                return failure;
        }
        return finish(out);
    }

  private:
    Failure take(std::string_view line, std::size_t number) {
        if (!started_) {
            started_ = true;
            format_ = formatOf(line);
            const auto fields = fieldsOf(line, format_);
            const bool numbers =
                fields.size() >= 2 && numberOf(fields[0], format_) && numberOf(fields[1], format_);
            if (!numbers) {
                columns_ = columnsOf(fields);
                points_ = columns_.names.size() > (columns_.z ? 3u : 2u);
                return {};
            }
            if (fields.size() == 3)
                columns_.z = 2;
        }
        const auto fields = fieldsOf(line, format_);
        const std::size_t last = std::max({columns_.x, columns_.y, columns_.z.value_or(0)});
        const auto value = [&](std::size_t i) {
            return i < fields.size() ? numberOf(fields[i], format_) : std::nullopt;
        };
        const auto x = value(columns_.x), y = value(columns_.y);
        if (!x || !y || (fields.size() <= last && !points_)) {
            constexpr std::size_t kShown = 40;
            std::string shown(line.substr(0, kShown));
            for (char& c : shown)
                c = static_cast<unsigned char>(c) < ' ' || c == 0x7f ? '?' : c;
            return Error{path_, "line " + std::to_string(number) + " ('" + shown +
                                    "') is no x and y of a vertex"};
        }
        const glm::dvec3 vertex(*x, *y, columns_.z ? value(*columns_.z).value_or(kNaN) : kNaN);
        if (points_)
            addPoint(vertex, fields);
        else
            ring_.push_back(vertex);
        return {};
    }

    void addPoint(const glm::dvec3& vertex, const std::vector<std::string_view>& fields) {
        Feature point;
        point.shape = FeatureShape::Point;
        point.id = std::to_string(raw_.features.size());
        point.parts = {{{vertex}}};
        for (std::size_t i = 0; i < std::min(fields.size(), columns_.names.size()); ++i) {
            if (i == columns_.x || i == columns_.y || i == columns_.z || fields[i].empty())
                continue;
            const auto number = numberOf(fields[i], format_);
            if (columns_.names[i] == "id" || columns_.names[i] == "ID")
                point.id = std::string(fields[i]);
            point.attributes.emplace_back(columns_.names[i],
                                          number ? AttributeValue(*number)
                                                 : AttributeValue(std::string(fields[i])));
        }
        raw_.features.push_back(std::move(point));
    }

    Failure finish(std::vector<RawFeatures>& out) {
        if (!points_) {
            const auto same = [](const glm::dvec3& a, const glm::dvec3& b) {
                return a.x == b.x && a.y == b.y;
            };
            ring_.erase(std::unique(ring_.begin(), ring_.end(), same), ring_.end());
            while (ring_.size() > 1 && same(ring_.front(), ring_.back()))
                ring_.pop_back();
            if (ring_.size() < 3)
                return Error{path_, "is no polygon: it has " + std::to_string(ring_.size()) +
                                        (ring_.size() == 1 ? " vertex" : " vertices")};
            Feature polygon;
            polygon.id = id_;
            polygon.parts = {{std::move(ring_)}};
            raw_.features.push_back(std::move(polygon));
        }
        if (columns_.degrees)
            raw_.crs = raw_.crsName = "EPSG:4326";
        if (file_.format.empty())
            file_.format = "CSV";
        out.push_back(std::move(raw_));
        return {};
    }

    const std::string& path_;
    FeatureFile& file_;
    std::string id_;
    RawFeatures raw_;
    FeatureRing ring_;
    Format format_;
    Columns columns_;
    bool started_ = false, points_ = false;
};

} // namespace

Failure readCsv(const std::string& path, const std::string& text, std::vector<RawFeatures>& out,
                FeatureFile& file) {
    return CsvReader(path, file).run(text, out);
}

} // namespace gnomon
