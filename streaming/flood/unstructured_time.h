// The moments of a result's steps, as the formats write them.
#pragma once

#include "geo/result.h"
#include "geo/time.h"

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace gnomon {

struct StepTimes {
    std::vector<double> seconds; // since 1970 UTC, or since the start
    bool absolute = false;
    std::string note; // what was taken for granted; may be empty
};

// "seconds since 2013-01-01 00:00:00 +01:00" and its like (NetCDF's CF conventions), or a unit
// alone. What is no date, and calendars that no clock keeps, leave the steps relative.
StepTimes cfTimes(const std::vector<double>& values, const std::string& unit,
                  const std::string& calendar);

// HEC-RAS: "01Jan1999 12:00:00", "01JAN1999 2400".
std::optional<double> hecTime(std::string_view text);

// Years, months… to seconds since 1970; none when there is no such day.
std::optional<double> utcSeconds(int year, int month, int day, int hour, int minute, double second);

} // namespace gnomon
