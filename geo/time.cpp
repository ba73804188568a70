#include "geo/time.h"

#include <date/date.h>
#include <date/tz.h>

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <exception>

namespace gnomon {
namespace {

using LocalSeconds = date::local_seconds;

bool isDigit(char c) {
    return c >= '0' && c <= '9';
}
bool isBlank(char c) {
    return c == ' ' || c == '\t';
}

// Reads from the front of a text; what did not fit is left where it was.
class Cursor {
  public:
    explicit Cursor(std::string_view text) : rest_(text) {}

    bool take(char c) {
        if (rest_.empty() || rest_.front() != c)
            return false;
        rest_.remove_prefix(1);
        return true;
    }
    bool number(int digits, int& value) {
        if (rest_.size() < static_cast<std::size_t>(digits))
            return false;
        int sum = 0;
        for (const char c : rest_.substr(0, digits)) {
            if (!isDigit(c))
                return false;
            sum = 10 * sum + (c - '0');
        }
        rest_.remove_prefix(digits);
        value = sum;
        return true;
    }
    bool fraction(double& value) {
        double unit = 0.1;
        value = 0.0;
        bool any = false;
        for (; !rest_.empty() && isDigit(rest_.front()); rest_.remove_prefix(1), unit *= 0.1) {
            value += unit * (rest_.front() - '0');
            any = true;
        }
        return any;
    }
    void skipBlanks() {
        while (!rest_.empty() && isBlank(rest_.front()))
            rest_.remove_prefix(1);
    }
    std::string_view rest() const { return rest_; }

  private:
    std::string_view rest_;
};

struct ClockTime {
    LocalSeconds seconds;
    double fraction = 0.0;
};

// What is wrong with the text, or nothing.
using Complaint = std::optional<std::string>;

constexpr const char* kForm =
    "is not of the form 2021-07-14T18:00[:30[.5]][Z|+02:00| Europe/Berlin]";

Complaint readDay(Cursor& cursor, LocalSeconds& midnight) {
    int year = 0, month = 0, day = 0;
    if (!cursor.number(4, year) || !cursor.take('-') || !cursor.number(2, month) ||
        !cursor.take('-') || !cursor.number(2, day))
        return kForm;
    if (month < 1 || month > 12)
        return "has no month " + std::to_string(month);
    const date::year_month_day ymd = date::year(year) / month / day;
    if (!ymd.ok())
        return "has a day " + std::to_string(day) + " that this month lacks";
    midnight = date::local_days(ymd);
    return {};
}

Complaint readClock(Cursor& cursor, ClockTime& time) {
    int hour = 0, minute = 0, second = 0;
    if (!cursor.number(2, hour) || !cursor.take(':') || !cursor.number(2, minute))
        return kForm;
    if (cursor.take(':')) {
        if (!cursor.number(2, second))
            return kForm;
        if ((cursor.take('.') || cursor.take(',')) && !cursor.fraction(time.fraction))
            return kForm;
    }
    if (hour > 23)
        return "has an hour past 23";
    if (minute > 59)
        return "has a minute past 59";
    if (second > 59)
        return "has a second past 59 (leap seconds cannot be written)";
    time.seconds +=
        std::chrono::hours(hour) + std::chrono::minutes(minute) + std::chrono::seconds(second);
    return {};
}

Complaint readOffset(Cursor& cursor, int sign, std::chrono::seconds& offset) {
    int hours = 0, minutes = 0;
    if (!cursor.number(2, hours))
        return kForm;
    const bool colon = cursor.take(':');
    if (!cursor.number(2, minutes) && colon)
        return kForm;
    // No place has ever kept a clock further from Greenwich than 15 h 13 min.
    if (hours > 15 || minutes > 59)
        return "has an offset that no place uses";
    offset = sign * (std::chrono::hours(hours) + std::chrono::minutes(minutes));
    return {};
}

std::string offsetText(std::chrono::seconds offset) {
    std::string text(offset.count() < 0 ? "-" : "+");
    const auto append = [&text](long long n) {
        text += static_cast<char>('0' + n / 10 % 10);
        text += static_cast<char>('0' + n % 10);
    };
    const long long minutes = std::llabs(offset.count()) / 60;
    append(minutes / 60);
    text += ':';
    append(minutes % 60);
    return text;
}

// The compiled zone files end here, and the rule for what follows is not read.
LocalSeconds rulesEnd() {
    return date::local_days(date::year(2038) / 1 / 1);
}

std::string unknownZone(const std::string& zone) {
    return "names a time zone that is not known here: " + zone;
}

Complaint findOffset(const std::string& zone, LocalSeconds local, std::chrono::seconds& offset) {
    try {
        const date::local_info info = date::locate_zone(zone)->get_info(local);
        offset = info.first.offset;
        if (info.result == date::local_info::nonexistent)
            return "does not exist in " + zone + ": the clocks are set forward over it, from " +
                   offsetText(info.first.offset) + " to " + offsetText(info.second.offset);
        if (info.result == date::local_info::ambiguous)
            return "happens twice in " + zone + ", where the clocks are set back: write " +
                   offsetText(info.first.offset) + " or " + offsetText(info.second.offset) +
                   " instead of the zone";
        if (local >= rulesEnd())
            return "is past 2037, to where the rules of " + zone +
                   " are known: write the offset instead of the zone";
        return {};
    } catch (const std::exception&) {
        return unknownZone(zone);
    }
}

Complaint readWhole(Cursor& cursor, ZonedTime& time) {
    ClockTime clock;
    if (Complaint wrong = readDay(cursor, clock.seconds))
        return wrong;
    if (cursor.rest().empty())
        return "has no time of day";
    if (!cursor.take('T') && !cursor.take('t') && !cursor.take(' '))
        return kForm;
    if (Complaint wrong = readClock(cursor, clock))
        return wrong;

    std::chrono::seconds offset{0};
    const bool blank = !cursor.rest().empty() && isBlank(cursor.rest().front());
    cursor.skipBlanks();
    Complaint wrong;
    const bool east = cursor.take('+');
    if (east || cursor.take('-')) {
        wrong = readOffset(cursor, east ? 1 : -1, offset);
        time.zone = offsetText(offset);
    } else if (cursor.rest() == "Z" || cursor.rest() == "z") {
        cursor.take(cursor.rest().front());
    } else if (blank && !cursor.rest().empty()) {
        time.zone = std::string(cursor.rest());
        wrong = findOffset(*time.zone, clock.seconds, offset);
        cursor = Cursor({});
    }
    if (wrong)
        return wrong;
    if (!cursor.rest().empty())
        return "has something after the time: " + std::string(cursor.rest());
    time.utc.seconds =
        static_cast<double>((clock.seconds.time_since_epoch() - offset).count()) + clock.fraction;
    return {};
}

// One printable line of bounded length, whatever came in.
std::string quoted(std::string_view text) {
    constexpr std::size_t kLongest = 160;
    std::string result;
    for (const char c : text.substr(0, kLongest))
        result += c >= ' ' && c <= '~' ? c : '?';
    return text.size() > kLongest ? result + "..." : result;
}

Error complained(std::string_view text, const std::string& wrong) {
    return {"time '" + quoted(text) + "'", quoted(wrong), ErrorKind::Usage};
}

// Years of four digits, as they can be read back.
bool hasDate(UtcTime time) {
    constexpr double kYear0 = -62167219200.0, kYear10000 = 253402300800.0;
    return time.seconds >= kYear0 && time.seconds < kYear10000;
}

struct LocalClock {
    std::chrono::seconds offset{0};
    std::string name;
};

Result<LocalClock> clockOf(date::sys_seconds moment, const std::string& zone) {
    const auto failed = [&](const std::string& why) {
        return complained(formatUtc({static_cast<double>(moment.time_since_epoch().count())}), why);
    };
    Cursor cursor(zone);
    const bool east = cursor.take('+');
    if (east || cursor.take('-')) {
        LocalClock clock;
        if (const Complaint wrong = readOffset(cursor, east ? 1 : -1, clock.offset))
            return failed(*wrong);
        if (!cursor.rest().empty())
            return failed("has something after the offset: " + std::string(cursor.rest()));
        clock.name = offsetText(clock.offset);
        return clock;
    }
    try {
        const date::sys_info info = date::locate_zone(zone)->get_info(moment);
        if (LocalSeconds(moment.time_since_epoch() + info.offset) >= rulesEnd())
            return failed("is past 2037, to where the rules of " + zone + " are known");
        // The time zone database writes an offset where people have no name: "+0545".
        const bool named =
            !info.abbrev.empty() && info.abbrev.front() != '+' && info.abbrev.front() != '-';
        return LocalClock{info.offset, named ? info.abbrev : offsetText(info.offset)};
    } catch (const std::exception&) {
        return failed(unknownZone(zone));
    }
}

} // namespace

Result<UtcTime> parseTime(std::string_view text) {
    const Result<ZonedTime> time = parseZonedTime(text);
    if (!time)
        return time.error();
    return time->utc;
}

Result<ZonedTime> parseZonedTime(std::string_view text) {
    while (!text.empty() && isBlank(text.front()))
        text.remove_prefix(1);
    while (!text.empty() && isBlank(text.back()))
        text.remove_suffix(1);
    Cursor cursor(text);
    ZonedTime time;
    if (const Complaint wrong = readWhole(cursor, time))
        return complained(text, *wrong);
    return time;
}

Result<std::string> formatLocal(UtcTime time, const std::string& zone) {
    if (!hasDate(time))
        return Error{"the time", "has no date of four digits", ErrorKind::Usage};
    // Whole to a millisecond, as formatUtc has it: what was interpolated is off by less.
    const double seconds = std::floor(std::floor(time.seconds * 1000.0 + 0.5) / 1000.0);
    const date::sys_seconds moment{std::chrono::seconds(static_cast<long long>(seconds))};
    const Result<LocalClock> clock = clockOf(moment, zone);
    if (!clock)
        return clock.error();
    const LocalSeconds local{moment.time_since_epoch() + clock->offset};
    const auto day = date::floor<date::days>(local);
    const date::year_month_day ymd(day);
    const date::hh_mm_ss<std::chrono::seconds> hour(local - day);
    char text[64];
    std::snprintf(text, sizeof text, "%04d-%02u-%02u %02d:%02d ", int(ymd.year()),
                  unsigned(ymd.month()), unsigned(ymd.day()), int(hour.hours().count()),
                  int(hour.minutes().count()));
    return text + clock->name;
}

std::string formatUtc(UtcTime time) {
    const double rounded = std::floor(time.seconds * 1000.0 + 0.5);
    if (!hasDate({rounded / 1000.0}))
        return "(no date)";
    const date::sys_time<std::chrono::milliseconds> moment{
        std::chrono::milliseconds(static_cast<long long>(rounded))};
    const auto day = date::floor<date::days>(moment);
    const date::year_month_day ymd(day);
    const date::hh_mm_ss<std::chrono::milliseconds> clock(moment - day);
    char text[64];
    const int length =
        std::snprintf(text, sizeof text, "%04d-%02u-%02uT%02d:%02d:%02d", int(ymd.year()),
                      unsigned(ymd.month()), unsigned(ymd.day()), int(clock.hours().count()),
                      int(clock.minutes().count()), int(clock.seconds().count()));
    if (clock.subseconds().count() != 0)
        std::snprintf(text + length, sizeof text - length, ".%03d",
                      int(clock.subseconds().count()));
    return std::string(text) + "Z";
}

} // namespace gnomon
