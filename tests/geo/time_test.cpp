#include "geo/time.h"

#include <gtest/gtest.h>

#include <limits>

using namespace gnomon;

namespace {

double seconds(const char* text) {
    const Result<UtcTime> t = parseTime(text);
    EXPECT_TRUE(t) << (t ? "" : t.error().message());
    return t ? t->seconds : std::numeric_limits<double>::quiet_NaN();
}

std::string complaint(const char* text) {
    const Result<UtcTime> t = parseTime(text);
    EXPECT_FALSE(t) << text;
    if (!t) {
        EXPECT_EQ(t.error().kind, ErrorKind::Usage);
        EXPECT_EQ(t.error().message().find('\n'), std::string::npos);
    }
    return t ? "" : t.error().message();
}

void expectComplaint(const char* text, const char* part) {
    EXPECT_NE(complaint(text).find(part), std::string::npos) << complaint(text);
}

} // namespace

TEST(Time, CountsSecondsSince1970) {
    EXPECT_EQ(seconds("1970-01-01T00:00:00Z"), 0.0);
    EXPECT_EQ(seconds("2001-09-09T01:46:40Z"), 1e9);
    EXPECT_EQ(seconds("1969-12-31T23:59:59Z"), -1.0);
    EXPECT_EQ(seconds("2000-02-29T12:00Z"), 951825600.0);
}

TEST(Time, TakesABareTimeForUtc) {
    EXPECT_EQ(seconds("2021-07-14T18:00"), seconds("2021-07-14T18:00:00Z"));
    EXPECT_EQ(seconds("2021-07-14 18:00"), seconds("2021-07-14T18:00:00Z"));
}

TEST(Time, ReadsFractionsAndOffsets) {
    EXPECT_DOUBLE_EQ(seconds("1970-01-01T00:00:30.5Z"), 30.5);
    EXPECT_DOUBLE_EQ(seconds("1970-01-01T00:00:30,25"), 30.25);
    EXPECT_EQ(seconds("2021-07-14T18:00:00+02:00"), seconds("2021-07-14T16:00:00Z"));
    EXPECT_EQ(seconds("2021-07-14T18:00+0530"), seconds("2021-07-14T12:30:00Z"));
    EXPECT_EQ(seconds("2021-07-14T18:00-03"), seconds("2021-07-14T21:00:00Z"));
    EXPECT_EQ(seconds("2021-07-14T01:00 +02:00"), seconds("2021-07-13T23:00:00Z"));
}

TEST(Time, KnowsZonesByName) {
    EXPECT_EQ(seconds("2021-07-14T18:00 Europe/Berlin"), seconds("2021-07-14T16:00:00Z"));
    EXPECT_EQ(seconds("2021-01-14T18:00 Europe/Berlin"), seconds("2021-01-14T17:00:00Z"));
    EXPECT_EQ(seconds("2005-08-29T06:10 America/Chicago"), seconds("2005-08-29T11:10:00Z"));
    EXPECT_EQ(seconds("2020-01-01T00:00 Asia/Kathmandu"), seconds("2019-12-31T18:15:00Z"));
    EXPECT_EQ(seconds("2021-07-14T18:00   UTC"), seconds("2021-07-14T18:00:00Z"));
    EXPECT_EQ(seconds("2037-07-14T18:00 Europe/Berlin"), seconds("2037-07-14T16:00:00Z"));
}

TEST(Time, SaysSoWhenAClockChangeSkipsATime) {
    expectComplaint("2021-03-28T02:30 Europe/Berlin", "does not exist in Europe/Berlin");
    EXPECT_EQ(seconds("2021-03-28T03:00 Europe/Berlin"), seconds("2021-03-28T01:00:00Z"));
    EXPECT_EQ(seconds("2021-03-28T01:59 Europe/Berlin"), seconds("2021-03-28T00:59:00Z"));
}

TEST(Time, SaysSoWhenAClockChangeHasATimeTwiceAndHowToWriteIt) {
    expectComplaint("2021-10-31T02:30 Europe/Berlin", "happens twice in Europe/Berlin");
    expectComplaint("2021-10-31T02:30 Europe/Berlin", "+02:00 or +01:00");
    EXPECT_EQ(seconds("2021-10-31T02:30+01:00") - seconds("2021-10-31T02:30+02:00"), 3600.0);
}

TEST(Time, RefusesZonesWhoseRulesItDoesNotKnow) {
    expectComplaint("2021-07-14T18:00 Europe/Kolonia", "Europe/Kolonia");
    expectComplaint("2021-07-14T18:00 ../../etc/passwd", "zone");
    expectComplaint("2045-07-14T18:00 Europe/Berlin", "2037");
    EXPECT_EQ(seconds("2045-07-14T18:00+02:00"), seconds("2045-07-14T16:00Z"));
}

TEST(Time, RefusesNonsenseAndSaysWhy) {
    expectComplaint("2021-13-01T00:00", "month 13");
    expectComplaint("2021-00-01T00:00", "month 0");
    expectComplaint("2021-02-29T00:00", "day 29");
    expectComplaint("2021-04-31T00:00", "day 31");
    expectComplaint("2021-04-00T00:00", "day 0");
    expectComplaint("2021-07-14T25:00", "hour");
    expectComplaint("2021-07-14T24:00", "hour");
    expectComplaint("2021-07-14T18:60", "minute");
    expectComplaint("2016-12-31T23:59:60Z", "leap seconds");
    expectComplaint("2021-07-14T18:00+25:00", "offset");
    expectComplaint("2021-07-14T18:00+01:75", "offset");
    expectComplaint("2021-07-14", "no time of day");
    for (const char* text : {"", " ", "yesterday", "14.07.2021 18:00", "2021-7-14T18:00",
                             "21-07-14T18:00", "2021-07-14T", "2021-07-14T18", "2021-07-14T18:0",
                             "2021-07-14T18:00:", "2021-07-14T18:00:00.", "2021-07-14T18:00+1",
                             "2021-07-14T18:00+01:", "-2021-07-14T18:00", "2021-07-14x18:00"})
        expectComplaint(text, "time '");
}

TEST(Time, RefusesTrailingText) {
    expectComplaint("2021-07-14T18:00Zulu", "Zulu");
    expectComplaint("2021-07-14T18:00+02:00 Europe/Berlin", "after the time");
    expectComplaint("2021-07-14T18:00Europe/Berlin", "after the time");
    expectComplaint("2021-07-14T18:00 Europe/Berlin summer", "zone");
}

TEST(Time, KeepsItsComplaintsToOnePrintableLine) {
    const std::string hostile = "2021-07-14T18:00 \x1b[31m\n" + std::string(5000, 'x');
    const std::string text = complaint(hostile.c_str());
    EXPECT_LT(text.size(), 500u);
    for (const char c : text)
        EXPECT_TRUE(c >= ' ' && c <= '~');
}

TEST(Time, WritesWhatItReads) {
    for (const char* text : {"2021-07-14T16:00:00Z", "1969-12-31T23:59:59Z", "2000-02-29T00:00:00Z",
                             "1600-01-01T12:34:56.789Z", "9999-12-31T23:59:59Z"})
        EXPECT_EQ(formatUtc({seconds(text)}), text);
    EXPECT_EQ(formatUtc({0.9996}), "1970-01-01T00:00:01Z");
    EXPECT_EQ(formatUtc({0.25}), "1970-01-01T00:00:00.250Z");
    EXPECT_EQ(formatUtc({std::numeric_limits<double>::quiet_NaN()}), "(no date)");
    EXPECT_EQ(formatUtc({1e300}), "(no date)");
}

namespace {

std::optional<std::string> zoneOf(const char* text) {
    const Result<ZonedTime> time = parseZonedTime(text);
    EXPECT_TRUE(time) << text;
    return time ? time->zone : std::nullopt;
}

std::string local(const char* utc, const char* zone) {
    const Result<std::string> text = formatLocal({seconds(utc)}, zone);
    EXPECT_TRUE(text) << (text ? "" : text.error().message());
    return text ? *text : "";
}

} // namespace

TEST(ZonedTime, KeepsTheZoneOrTheOffsetThatWasWritten) {
    EXPECT_EQ(zoneOf("2021-07-14T18:00 Europe/Berlin"), "Europe/Berlin");
    EXPECT_EQ(zoneOf("2021-07-14T18:00+02:00"), "+02:00");
    EXPECT_EQ(zoneOf("2021-07-14T18:00-0330"), "-03:30");
    EXPECT_EQ(zoneOf("2021-07-14T18:00+02"), "+02:00");
    EXPECT_EQ(zoneOf("2021-07-14T18:00Z"), std::nullopt);
    EXPECT_EQ(zoneOf("2021-07-14T18:00"), std::nullopt);
    EXPECT_EQ(parseZonedTime("2021-07-14T18:00 Europe/Berlin")->utc.seconds,
              seconds("2021-07-14T16:00Z"));
}

TEST(ZonedTime, IsShownAsTheClocksThereShowIt) {
    EXPECT_EQ(local("2021-07-14T16:00Z", "Europe/Berlin"), "2021-07-14 18:00 CEST");
    EXPECT_EQ(local("2021-01-14T16:00Z", "Europe/Berlin"), "2021-01-14 17:00 CET");
    EXPECT_EQ(local("2005-08-29T11:10Z", "America/Chicago"), "2005-08-29 06:10 CDT");
    EXPECT_EQ(local("2021-12-31T23:30Z", "Asia/Kathmandu"), "2022-01-01 05:15 +05:45");
    EXPECT_EQ(local("2021-07-14T16:00Z", "+02:00"), "2021-07-14 18:00 +02:00");
    EXPECT_EQ(local("2021-03-01T00:10Z", "-03:30"), "2021-02-28 20:40 -03:30");
    EXPECT_EQ(local("2021-07-14T16:00Z", "UTC"), "2021-07-14 16:00 UTC");
    EXPECT_EQ(local("1969-12-31T23:59:59Z", "+00:00"), "1969-12-31 23:59 +00:00");
}

TEST(ZonedTime, FollowsTheClockChangesToTheSecond) {
    EXPECT_EQ(local("2021-03-28T00:59:59Z", "Europe/Berlin"), "2021-03-28 01:59 CET");
    EXPECT_EQ(local("2021-03-28T01:00:00Z", "Europe/Berlin"), "2021-03-28 03:00 CEST");
    EXPECT_EQ(local("2021-10-31T00:59:59Z", "Europe/Berlin"), "2021-10-31 02:59 CEST");
    EXPECT_EQ(local("2021-10-31T01:00:00Z", "Europe/Berlin"), "2021-10-31 02:00 CET");
}

TEST(ZonedTime, ShowsTheMinuteThatHasBegunAndForgivesRoundingErrors) {
    const double noon = seconds("2021-07-14T12:00Z");
    EXPECT_EQ(*formatLocal({noon + 59.9}, "+00:00"), "2021-07-14 12:00 +00:00");
    EXPECT_EQ(*formatLocal({noon - 0.1}, "+00:00"), "2021-07-14 11:59 +00:00");
    EXPECT_EQ(*formatLocal({noon - 1e-6}, "+00:00"), "2021-07-14 12:00 +00:00");
}

TEST(ZonedTime, SaysInALineWhyATimeCannotBeShown) {
    const double nan = std::numeric_limits<double>::quiet_NaN();
    for (const auto& [when, zone, part] :
         {std::tuple{0.0, "Europe/Kolonia", "Europe/Kolonia"}, std::tuple{0.0, "+2", "form"},
          std::tuple{0.0, "+02:00x", "after the offset"}, std::tuple{0.0, "", "zone"},
          std::tuple{3e9, "Europe/Berlin", "2037"}, std::tuple{nan, "Europe/Berlin", "date"},
          std::tuple{1e300, "+02:00", "date"}, std::tuple{0.0, "a\nb", "a?b"}}) {
        const Result<std::string> text = formatLocal({when}, zone);
        ASSERT_FALSE(text) << zone;
        EXPECT_NE(text.error().message().find(part), std::string::npos) << text.error().message();
        EXPECT_EQ(text.error().message().find('\n'), std::string::npos);
    }
}
