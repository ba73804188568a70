#include "streaming/flood/unstructured_time.h"

#include "streaming/flood/lower_case.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>

namespace gnomon {

namespace {

std::optional<double> secondsPerUnit(const std::string& unit) {
    if (unit.starts_with("sec") || unit == "s")
        return 1.0;
    if (unit.starts_with("min"))
        return 60.0;
    if (unit.starts_with("hour") || unit == "h" || unit == "hr" || unit == "hrs")
        return 3600.0;
    if (unit.starts_with("day") || unit == "d")
        return 86400.0;
    if (unit.starts_with("milli") || unit == "ms")
        return 1e-3;
    return std::nullopt;
}

// "+01:00", "+0100", "-3", "Z", "UTC", "" to seconds east.
std::optional<double> zoneSeconds(std::string text) {
    std::erase(text, ' ');
    const std::string zone = lower(text);
    if (zone.empty() || zone == "z" || zone == "utc" || zone == "gmt")
        return 0.0;
    if (zone[0] != '+' && zone[0] != '-')
        return std::nullopt;
    int hours = 0, minutes = 0, used = 0;
    if (std::sscanf(zone.c_str() + 1, "%2d%n", &hours, &used) != 1 || hours < 0)
        return std::nullopt;
    const char* rest = zone.c_str() + 1 + used;
    if (*rest == ':')
        ++rest;
    if (*rest != '\0' && std::sscanf(rest, "%2d", &minutes) != 1)
        return std::nullopt;
    if (hours > 15 || minutes < 0 || minutes > 59)
        return std::nullopt;
    return (zone[0] == '-' ? -1.0 : 1.0) * (3600.0 * hours + 60.0 * minutes);
}

// The moment after "since": parts need not be padded, the clock may be missing.
std::optional<double> reference(const std::string& text) {
    int year = 0, month = 0, day = 0, used = 0;
    if (std::sscanf(text.c_str(), " %4d-%2d-%2d%n", &year, &month, &day, &used) != 3)
        return std::nullopt;
    std::string rest = text.substr(std::size_t(used));
    if (!rest.empty() && (rest[0] == 'T' || rest[0] == 't'))
        rest[0] = ' ';
    int hour = 0, minute = 0;
    double second = 0.0;
    used = 0;
    if (std::sscanf(rest.c_str(), " %2d:%2d%n", &hour, &minute, &used) == 2) {
        rest.erase(0, std::size_t(used));
        used = 0;
        if (std::sscanf(rest.c_str(), ":%9lf%n", &second, &used) == 1)
            rest.erase(0, std::size_t(used));
    }
    const auto zone = zoneSeconds(rest);
    const auto moment = utcSeconds(year, month, day, hour, minute, second);
    if (!zone || !moment)
        return std::nullopt;
    return *moment - *zone;
}

} // namespace

std::optional<double> utcSeconds(int year, int month, int day, int hour, int minute,
                                 double second) {
    // 24:00 ends a day.
    if (hour < 0 || hour > 24 || minute < 0 || minute > 59 || !(second >= 0.0) || second >= 61.0 ||
        year < 0 || year > 9999)
        return std::nullopt;
    std::array<char, 64> text{};
    std::snprintf(text.data(), text.size(), "%04d-%02d-%02dT00:00Z", year, month, day);
    const Result<UtcTime> midnight = parseTime(text.data());
    if (!midnight)
        return std::nullopt;
    return midnight->seconds + 3600.0 * hour + 60.0 * minute + second;
}

StepTimes cfTimes(const std::vector<double>& values, const std::string& unit,
                  const std::string& calendar) {
    StepTimes times;
    const std::string words = lower(unit);
    const std::size_t since = words.find(" since ");
    std::string name = words.substr(0, std::min(since, words.size()));
    name.erase(0, std::min(name.find_first_not_of(' '), name.size()));
    const auto factor = secondsPerUnit(name);
    if (!factor)
        times.note = "its times have the unit '" + unit.substr(0, 60) + "', taken for seconds";
    for (const double value : values)
        times.seconds.push_back(value * factor.value_or(1.0));
    if (since == std::string::npos || !factor)
        return times;

    const std::string days = lower(calendar);
    const bool kept = days.empty() || days == "standard" || days == "gregorian" ||
                      days == "proleptic_gregorian" || days == "julian";
    const auto start = reference(unit.substr(since + 7));
    // A year that nobody models stands for "no date".
    constexpr double kYear1800 = -5364662400.0;
    if (!kept || !start || *start < kYear1800) {
        times.note = "its times count from '" + unit.substr(since + 7, 40) + "'" +
                     (kept ? "" : " in the calendar '" + calendar.substr(0, 40) + "'") +
                     ", which is no date; they are shown from 0 on";
        return times;
    }
    for (double& second : times.seconds)
        second += *start;
    times.absolute = true;
    return times;
}

std::optional<double> hecTime(std::string_view text) {
    static constexpr std::array kMonths = {"jan", "feb", "mar", "apr", "may", "jun",
                                           "jul", "aug", "sep", "oct", "nov", "dec"};
    const std::string line = lower(text.substr(0, 60));
    int day = 0, year = 0, used = 0, hour = 0, minute = 0;
    double second = 0.0;
    std::array<char, 4> month{};
    if (std::sscanf(line.c_str(), " %2d%3[a-z]%4d%n", &day, month.data(), &year, &used) != 3)
        return std::nullopt;
    const auto found = std::find(kMonths.begin(), kMonths.end(), std::string(month.data()));
    if (found == kMonths.end())
        return std::nullopt;
    const char* clock = line.c_str() + used;
    // "12:00:00", "12:00:00:000" or "1200".
    if (std::sscanf(clock, " %2d:%2d:%6lf", &hour, &minute, &second) < 2 &&
        std::sscanf(clock, " %2d%2d", &hour, &minute) != 2)
        return std::nullopt;
    return utcSeconds(year, int(found - kMonths.begin()) + 1, day, hour, minute, second);
}

} // namespace gnomon
