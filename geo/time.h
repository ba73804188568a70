// Moments in UTC, and how people write them: ISO 8601 with an offset, `Z`, or a zone by name.
#pragma once

#include "geo/result.h"

#include <optional>
#include <string>
#include <string_view>

namespace gnomon {

// Seconds since 1970-01-01T00:00:00Z without leap seconds (POSIX).
struct UtcTime {
    double seconds = 0.0;
};

// "2021-07-14T18:00", "2021-07-14T18:00:30.5+02:00", "2021-07-14 18:00 Europe/Berlin". Without
// offset or zone it is UTC. A local time a clock change skips or has twice is an error that says
// so; so is a zone by name after 2037, where its rules are not known.
Result<UtcTime> parseTime(std::string_view text);

// A moment, and by which clock it was told: a zone's name, or an offset written "+02:00". None for
// a time without either, and for `Z`.
struct ZonedTime {
    UtcTime utc;
    std::optional<std::string> zone;
};
Result<ZonedTime> parseZonedTime(std::string_view text);

// What the clocks of `zone` (as in ZonedTime) show, down to the minute that has begun: "2021-07-14
// 18:00 CEST"; with the offset where the zone's time has no abbreviation. Fails for a zone that is
// not known, and where its rules are not.
Result<std::string> formatLocal(UtcTime time, const std::string& zone);
// "2021-07-14T16:00:00Z"; with milliseconds when there are any.
std::string formatUtc(UtcTime time);

} // namespace gnomon
