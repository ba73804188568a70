#include "viewer/camera_path.h"

#include "geo/crs.h"
#include "tests/viewer/files.h"

#include <glm/geometric.hpp>
#include <gtest/gtest.h>

#include <cmath>

using namespace gnomon;

namespace {

constexpr double kAspect = 2.0;

std::string kml(const std::string& playlist, const std::string& before = "") {
    return "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
           "<kml xmlns=\"http://www.opengis.net/kml/2.2\" "
           "xmlns:gx=\"http://www.google.com/kml/ext/2.2\"><Document>" +
           before + "<gx:Tour><name>Round trip</name><gx:Playlist>" + playlist +
           "</gx:Playlist></gx:Tour></Document></kml>";
}

std::string element(const std::string& name, const std::string& text) {
    return "<" + name + ">" + text + "</" + name.substr(0, name.find(' ')) + ">";
}

std::string flyTo(const std::string& view, double seconds = 0, const std::string& mode = "") {
    return element("gx:FlyTo", element("gx:duration", std::to_string(seconds)) +
                                   (mode.empty() ? "" : element("gx:flyToMode", mode)) + view);
}

std::string camera(double lon, double lat, double altitude, double heading, double tilt,
                   const std::string& more = "<altitudeMode>absolute</altitudeMode>") {
    return element("Camera", element("longitude", std::to_string(lon)) +
                                 element("latitude", std::to_string(lat)) +
                                 element("altitude", std::to_string(altitude)) +
                                 element("heading", std::to_string(heading)) +
                                 element("tilt", std::to_string(tilt)) + more);
}

std::string lookAt(double lon, double lat, double heading, double tilt, double range,
                   const std::string& more = "<altitudeMode>absolute</altitudeMode>") {
    return element("LookAt", element("longitude", std::to_string(lon)) +
                                 element("latitude", std::to_string(lat)) +
                                 element("heading", std::to_string(heading)) +
                                 element("tilt", std::to_string(tilt)) +
                                 element("range", std::to_string(range)) + more);
}

Result<CameraPath> parse(const std::string& text) {
    return CameraPath::parse(text, "t.kml", 45.0, kAspect);
}

CameraPath tour(const std::string& playlist) {
    const auto path = parse(kml(playlist));
    if (!path)
        throw std::runtime_error(path.error().message());
    return *path;
}

// East, north and up on a sphere's or ellipsoid's surface, by the book and not by our code.
struct Axes {
    glm::dvec3 east, north, up;
    Axes(double lonDegrees, double latDegrees) {
        const double lon = lonDegrees * M_PI / 180, lat = latDegrees * M_PI / 180;
        east = {-std::sin(lon), std::cos(lon), 0};
        north = {-std::sin(lat) * std::cos(lon), -std::sin(lat) * std::sin(lon), std::cos(lat)};
        up = {std::cos(lat) * std::cos(lon), std::cos(lat) * std::sin(lon), std::sin(lat)};
    }
};

// By the closed formula of the WGS 84 ellipsoid.
glm::dvec3 onEarth(double lonDegrees, double latDegrees, double height) {
    const double a = 6378137.0, f = 1 / 298.257223563, e2 = f * (2 - f);
    const double lon = lonDegrees * M_PI / 180, lat = latDegrees * M_PI / 180;
    const double n = a / std::sqrt(1 - e2 * std::sin(lat) * std::sin(lat));
    return {(n + height) * std::cos(lat) * std::cos(lon),
            (n + height) * std::cos(lat) * std::sin(lon), (n * (1 - e2) + height) * std::sin(lat)};
}

void expectNear(const glm::dvec3& a, const glm::dvec3& b, double tolerance,
                const std::string& what = "") {
    EXPECT_LE(glm::length(a - b), tolerance) << what << ": " << a.x << ' ' << a.y << ' ' << a.z
                                             << " is not " << b.x << ' ' << b.y << ' ' << b.z;
}

std::string refusal(const std::string& text) {
    const auto path = parse(text);
    EXPECT_FALSE(bool(path)) << text.substr(0, 200);
    return path ? "" : path.error().message();
}

} // namespace

TEST(KmlTour, ACameraTiltsFromStraightDownByTheHorizonToTheSky) {
    const Axes at(7, 51);
    const double sea = *egm96GeoidHeight(7, 51);
    EXPECT_NEAR(sea, 46, 2); // EGM96 in the Rhineland, by its chart
    for (const auto& [tilt, heading, forward, up] :
         {std::tuple{0.0, 0.0, -at.up, at.north}, std::tuple{0.0, 90.0, -at.up, at.east},
          std::tuple{90.0, 0.0, at.north, at.up}, std::tuple{90.0, 90.0, at.east, at.up},
          std::tuple{90.0, 180.0, -at.north, at.up}, std::tuple{180.0, 0.0, at.up, -at.north},
          std::tuple{45.0, 270.0, (-at.east - at.up) / std::sqrt(2.0),
                     (at.up - at.east) / std::sqrt(2.0)}}) {
        const Camera seen = tour(flyTo(camera(7, 51, 300, heading, tilt))).sample(0).camera;
        const std::string what = std::to_string(tilt) + " " + std::to_string(heading);
        expectNear(seen.position.xyz, onEarth(7, 51, 300 + sea), 1e-6, what);
        expectNear(seen.forward.xyz, forward, 1e-9, what);
        expectNear(seen.up.xyz, up, 1e-9, what);
    }
}

TEST(KmlTour, ARollTurnsClockwiseAsTheHeadingDoesWhenLookingDown) {
    const std::string absolute = "<altitudeMode>absolute</altitudeMode>";
    const Axes at(7, 51);
    const Camera level =
        tour(flyTo(camera(7, 51, 300, 0, 90, "<roll>30</roll>" + absolute))).sample(0).camera;
    expectNear(level.up.xyz, std::cos(M_PI / 6) * at.up + std::sin(M_PI / 6) * at.east, 1e-9);
    const Camera down =
        tour(flyTo(camera(7, 51, 300, 20, 0, "<roll>30</roll>" + absolute))).sample(0).camera;
    const Camera turned = tour(flyTo(camera(7, 51, 300, 50, 0))).sample(0).camera;
    expectNear(down.up.xyz, turned.up.xyz, 1e-9);
}

TEST(KmlTour, ALookAtStandsBehindAndAboveItsPoint) {
    const Axes at(7, 51);
    const glm::dvec3 point = onEarth(7, 51, *egm96GeoidHeight(7, 51));
    const double s = std::sin(M_PI / 3), c = std::cos(M_PI / 3);
    for (const auto& [heading, tilt, behind] :
         {std::tuple{0.0, 0.0, at.up}, std::tuple{0.0, 90.0, -at.north},
          std::tuple{90.0, 60.0, -s * at.east + c * at.up}}) {
        const Camera seen = tour(flyTo(lookAt(7, 51, heading, tilt, 2000))).sample(0).camera;
        expectNear(seen.position.xyz, point + 2000.0 * behind, 1e-6);
        expectNear(seen.forward.xyz, -behind, 1e-9);
    }
}

TEST(KmlTour, FliesByItsDurationsAndWaits) {
    const CameraPath path =
        tour(flyTo(camera(7, 51, 300, 0, 60), 9) + flyTo(camera(7.01, 51, 300, 0, 60), 4) +
             element("gx:Wait", "<gx:duration>2.5</gx:duration>") +
             flyTo(camera(7.01, 51.01, 300, 0, 60), 3));
    // The first has nowhere to come from: it is there at once.
    EXPECT_EQ(path.startSeconds(), 0.0);
    EXPECT_EQ(path.endSeconds(), 9.5);
    const auto at = [&](double t) { return path.sample(t).camera.position.xyz; };
    const auto there = [](double lon, double lat) {
        return onEarth(lon, lat, 300 + *egm96GeoidHeight(lon, lat));
    };
    expectNear(at(0), there(7, 51), 1e-6);
    for (const double t : {4.0, 5.0, 6.5})
        expectNear(at(t), there(7.01, 51), 1e-6);
    expectNear(at(9.5), there(7.01, 51.01), 1e-6);
    // Halfway in time is halfway in space between two rests.
    expectNear(at(2), 0.5 * (there(7, 51) + there(7.01, 51)), 1e-6);
}

TEST(KmlTour, BouncesRestAtEachViewAndSmoothSeriesOnlyAtTheirEnds) {
    const auto speeds = [](const std::string& mode) {
        const CameraPath path = tour(flyTo(camera(7, 51, 300, 0, 60), 0, mode) +
                                     flyTo(camera(7.01, 51, 300, 0, 60), 4, mode) +
                                     flyTo(camera(7.02, 51, 300, 0, 60), 4, mode) +
                                     flyTo(camera(7.03, 51, 300, 0, 60), 4, mode));
        std::vector<double> speed;
        for (const double t : {0.0, 4.0, 8.0, 12.0 - 1e-4}) {
            const auto at = [&](double s) { return path.sample(s).camera.position.xyz; };
            speed.push_back(glm::length(at(t + 1e-4) - at(t)) / 1e-4);
        }
        return speed;
    };
    const double mean = 701.0 / 4; // 0.01 degrees at latitude 51 are 701 m
    for (const char* mode : {"bounce", ""})
        for (const double speed : speeds(mode))
            EXPECT_LT(speed, 0.01 * mean);
    const auto smooth = speeds("smooth");
    EXPECT_LT(smooth[0], 0.01 * mean);
    EXPECT_NEAR(smooth[1], mean, 0.02 * mean);
    EXPECT_NEAR(smooth[2], mean, 0.02 * mean);
    EXPECT_LT(smooth[3], 0.01 * mean);
}

TEST(KmlTour, AFlightWithoutDurationIsACut) {
    const CameraPath path =
        tour(flyTo(camera(7, 51, 300, 0, 60)) + flyTo(camera(7.01, 51, 300, 0, 60), 2, "smooth") +
             flyTo(camera(8, 52, 300, 0, 60)) + flyTo(camera(8.01, 52, 300, 0, 60), 2, "smooth"));
    EXPECT_EQ(path.endSeconds(), 4.0);
    const auto at = [&](double t) { return path.sample(t).camera.position.xyz; };
    const auto there = [](double lon, double lat) {
        return onEarth(lon, lat, 300 + *egm96GeoidHeight(lon, lat));
    };
    expectNear(at(2 - 1e-9), there(7.01, 51), 1e-3);
    expectNear(at(2), there(8, 52), 1e-6);
    expectNear(at(4), there(8.01, 52), 1e-6);
    for (double t = 0; t <= 4; t += 0.01)
        EXPECT_TRUE(std::isfinite(at(t).x));
}

TEST(KmlTour, GoesRoundWhatItLooksAtInACircle) {
    std::string playlist;
    for (int i = 0; i <= 4; ++i)
        playlist += flyTo(lookAt(7, 51, 90 * i, 60, 1000), 5, "smooth");
    const CameraPath path = tour(playlist);
    const glm::dvec3 point = onEarth(7, 51, *egm96GeoidHeight(7, 51));
    for (double t = 0; t <= 20; t += 0.1) {
        const Camera seen = path.sample(t).camera;
        EXPECT_NEAR(glm::length(seen.position.xyz - point), 1000, 1e-6);
        expectNear(seen.forward.xyz, glm::normalize(point - seen.position.xyz), 1e-9);
    }
}

TEST(KmlTour, HeightsAboveTheGroundWaitForIt) {
    const std::string relative = "<altitudeMode>relativeToGround</altitudeMode>";
    const std::string floor = "<gx:altitudeMode>relativeToSeaFloor</gx:altitudeMode>";
    const CameraPath path =
        tour(flyTo(camera(7, 51, 50, 0, 60, relative)) +
             flyTo(camera(7.01, 51, 50, 0, 60, floor), 1) + flyTo(camera(7, 51, 50, 0, 60, ""), 1) +
             flyTo(lookAt(7, 51, 0, 0, 500, ""), 1) + flyTo(camera(7, 51, 300, 0, 60), 1));
    EXPECT_TRUE(path.needsGround());
    ASSERT_EQ(path.notes().size(), 1u);
    EXPECT_TRUE(path.notes()[0].starts_with("4 of its views are given above the ground"));
    const CameraPath there =
        path.onGround([](double lon, double) { return lon > 7.005 ? 120.0 : 80.0; });
    const auto heightAt = [&](double t) {
        return geodeticOf(there.sample(t).camera.position).heightMetres;
    };
    EXPECT_NEAR(heightAt(0), 130, 1e-6);
    EXPECT_NEAR(heightAt(1), 170, 1e-6);
    EXPECT_NEAR(heightAt(2), 81.7, 1e-6); // eye height: its altitude does not count
    EXPECT_NEAR(heightAt(3), 580, 1e-6);
    EXPECT_NEAR(heightAt(4), 300 + *egm96GeoidHeight(7, 51), 1e-6);
    EXPECT_FALSE(tour(flyTo(camera(7, 51, 300, 0, 60))).needsGround());
}

TEST(KmlTour, ItsTimesMoveTheSun) {
    const auto at = [](const std::string& time) {
        return camera(7, 51, 300, 0, 60, time + "<altitudeMode>absolute</altitudeMode>");
    };
    const CameraPath path =
        tour(flyTo(at("<gx:TimeStamp><when>2021-07-14T18:00:00Z</when></gx:TimeStamp>")) +
             flyTo(at("<gx:TimeStamp><when>2021-07-14T22:00:00+02:00</when></gx:TimeStamp>"), 2) +
             flyTo(at("<gx:TimeSpan><begin>2001</begin><end>2021-07-15</end></gx:TimeSpan>"), 2));
    const double begin = 1626285600; // date -u -d 2021-07-14T18:00:00 +%s
    EXPECT_EQ(path.sample(0).time->seconds, begin);
    EXPECT_NEAR(path.sample(2).time->seconds, begin + 7200, 1e-6);
    EXPECT_NEAR(path.sample(4).time->seconds, begin + 6 * 3600, 1e-6);
    EXPECT_EQ(path.timeZone(), "+02:00");
    for (const char* year : {"2021", "2021-01", "2021-01-01"})
        EXPECT_EQ(tour(flyTo(at("<TimeStamp><when>" + std::string(year) + "</when></TimeStamp>")))
                      .sample(0)
                      .time->seconds,
                  1609459200)
            << year;
}

TEST(KmlTour, ItsFieldOfViewIsFromSideToSide) {
    const Camera seen =
        tour(flyTo(camera(7, 51, 300, 0, 60,
                          "<altitudeMode>absolute</altitudeMode><gx:horizFov>90</gx:horizFov>")))
            .sample(0)
            .camera;
    // tan(90 / 2) = 1 across, so 1 / 2 up with pictures twice as wide as high.
    EXPECT_NEAR(seen.verticalFovRadians, 2 * std::atan(0.5), 1e-12);
    EXPECT_NEAR(tour(flyTo(camera(7, 51, 300, 0, 60))).sample(0).camera.verticalFovRadians,
                M_PI / 4, 1e-12);
}

TEST(KmlTour, PrefixesAndNamespacesMayBeOthers) {
    const std::string inside =
        "Tour><P:Playlist><P:FlyTo><K:Camera><K:longitude>7</K:longitude>"
        "<K:latitude> 51\n</K:latitude><K:altitude>+3e2</K:altitude>"
        "<K:altitudeMode>absolute</K:altitudeMode></K:Camera></P:FlyTo></P:Playlist></P:Tour>";
    const auto with = [&](const std::string& kmlSpace, const std::string& gxSpace) {
        return "<K:kml xmlns:K=\"" + kmlSpace + "\" xmlns:P=\"" + gxSpace + "\"><P:" + inside +
               "</K:kml>";
    };
    const auto expected = tour(flyTo(camera(7, 51, 300, 0, 0))).sample(0).camera.position;
    for (const auto& [kmlSpace, gxSpace] :
         {std::pair{"http://www.opengis.net/kml/2.2", "http://www.google.com/kml/ext/2.2"},
          std::pair{"http://www.opengis.net/kml/2.3", "http://www.opengis.net/kml/2.3"},
          std::pair{"http://earth.google.com/kml/2.1", "http://www.google.com/kml/ext/2.2"}}) {
        const auto path = parse(with(kmlSpace, gxSpace));
        ASSERT_TRUE(bool(path)) << path.error().message();
        expectNear(path->sample(0).camera.position.xyz, expected.xyz, 1e-6);
    }
    std::string bare = with("x", "x").substr(0);
    bare = "<kml><" + inside + "</kml>";
    for (const char* prefix : {"K:", "P:"})
        for (auto at = bare.find(prefix); at != std::string::npos; at = bare.find(prefix))
            bare.erase(at, 2);
    EXPECT_TRUE(bool(parse(bare))) << bare;
    EXPECT_NE(refusal(with("http://www.opengis.net/kml/2.2", "http://example.org/other"))
                  .find("without a gx:Tour"),
              std::string::npos);
}

TEST(KmlTour, KnowsXmlByItsContentAndReadsUtf16) {
    const std::string text = kml(flyTo(camera(7, 51, 300, 0, 60)));
    EXPECT_TRUE(bool(parse("\xef\xbb\xbf" + text)));
    std::string wide = "\xff\xfe";
    for (const char c :
         "<?xml version=\"1.0\" encoding=\"UTF-16\"?>" + text.substr(text.find("<kml")))
        wide += {c, '\0'};
    const auto path = parse(wide);
    EXPECT_TRUE(bool(path)) << path.error().message();
}

TEST(KmlTour, WhatElseItsFileHasIsLeftAlone) {
    const std::string other =
        "<Placemark><name>x</name><Camera><longitude>1</longitude></Camera></Placemark>";
    const std::string rest = "<gx:SoundCue><href>file:///etc/passwd</href></gx:SoundCue>"
                             "<gx:AnimatedUpdate><gx:duration>3</gx:duration><Update><Change>"
                             "<Placemark><description>" +
                             std::string(5000, 'x') +
                             "</description></Placemark></Change></Update></gx:AnimatedUpdate>"
                             "<gx:TourControl><gx:playMode>pause</gx:playMode></gx:TourControl>";
    const std::string second = "<gx:Tour><gx:Playlist>" + flyTo(camera(1, 2, 3, 4, 5)) +
                               "</gx:Playlist></gx:Tour></Document></kml>";
    std::string text = kml(flyTo(camera(7, 51, 300, 0, 60)) + rest, other);
    text = text.substr(0, text.find("</Document>")) + second;
    const auto path = parse(text);
    ASSERT_TRUE(bool(path)) << path.error().message();
    EXPECT_EQ(path->size(), 1u);
    ASSERT_EQ(path->notes().size(), 4u);
    EXPECT_NE(path->notes()[0].find("2 tours; the first, \"Round trip\""), std::string::npos);
}

TEST(KmlTour, RefusesWhatIsWrongAndSaysWhere) {
    const auto expect = [](const std::string& text, const std::string& words) {
        const std::string message = refusal(text);
        EXPECT_TRUE(message.starts_with("t.kml: ")) << message;
        EXPECT_NE(message.find(words), std::string::npos) << message;
        EXPECT_EQ(message.find('\n'), std::string::npos);
    };
    expect("<kml/>", "without a gx:Tour");
    expect("<kml", "line 1: unclosed token");
    expect("<kml>\n<a></b></kml>", "line 2: mismatched tag");
    expect("<kml><gx:Tour/></kml>", "unbound prefix");
    expect("PK\x03\x04rest", "KMZ");
    expect(kml(""), "no gx:FlyTo");
    expect(kml(element("gx:Wait", "<gx:duration>1</gx:duration>")), "no gx:FlyTo");
    expect(kml(flyTo("")), "step 1 of the tour, a FlyTo: neither Camera nor LookAt");
    const std::string good = flyTo(camera(7, 51, 300, 0, 60));
    expect(kml(good + flyTo(camera(7, 91, 300, 0, 60))), "step 2 of the tour, a FlyTo");
    expect(kml(flyTo(camera(7, 91, 300, 0, 60))), "<Camera/latitude> is out of range");
    expect(kml(flyTo("<Camera><latitude>1</latitude></Camera>")), "<Camera/longitude> is missing");
    expect(kml(flyTo("<Camera><latitude>1</latitude><longitude>nan</longitude></Camera>")),
           "<Camera/longitude> is no number");
    expect(kml(flyTo("<LookAt><latitude>1</latitude><longitude>1</longitude></LookAt>")),
           "<LookAt/range> is missing");
    expect(kml(flyTo(camera(7, 51, 300, 0, 60), 1, "fast")), "<flyToMode>");
    expect(kml(flyTo(camera(7, 51, 300, 0, 60), -1)), "<duration> is out of range");
    expect(kml(flyTo(camera(7, 51, 3, 0, 6, "<altitudeMode>high</altitudeMode>"))), "altitudeMode");
    expect(kml(flyTo(camera(7, 51, 3, 0, 6, "<TimeStamp><when>noon</when></TimeStamp>"))), "when");
    expect(kml(good + element("gx:Wait", "<gx:duration>x</gx:duration>")), "a Wait");
    expect(kml(good + flyTo(camera(7, 51, 3, 0, 6), 9e8) + flyTo(camera(7, 51, 3, 0, 6), 9e8)),
           "longer than");
    expect(kml(flyTo(camera(7, 51, 3, 0, 6, element("roll", std::string(10000, '1'))))),
           "more than it should have");
}

TEST(KmlTour, EntityBombsAndDeepNestingAreRefused) {
    const std::string bomb =
        "<?xml version=\"1.0\"?><!DOCTYPE kml [<!ENTITY a \"aaaaaaaaaa\">"
        "<!ENTITY b \"&a;&a;&a;&a;&a;&a;&a;&a;\"><!ENTITY c \"&b;&b;&b;&b;&b;&b;&b;&b;\">]>"
        "<kml>&c;</kml>";
    EXPECT_NE(refusal(bomb).find("declares entities"), std::string::npos);
    const std::string outside = "<?xml version=\"1.0\"?><!DOCTYPE kml [<!ENTITY x SYSTEM "
                                "\"file:///etc/passwd\">]><kml>&x;</kml>";
    EXPECT_NE(refusal(outside).find("declares entities"), std::string::npos);
    std::string deep;
    for (int i = 0; i < 200000; ++i)
        deep += "<a>";
    EXPECT_NE(refusal(deep).find("nested deeper than 64"), std::string::npos);
    const std::string many = kml([] {
        std::string text = "<gx:FlyTo>";
        for (int i = 0; i < 100000; ++i)
            text += "<a" + std::to_string(i) + ">x</a" + std::to_string(i) + ">";
        return text + "</gx:FlyTo>";
    }());
    EXPECT_NE(refusal(many).find("more than it should have"), std::string::npos);
    const std::string whole = kml(flyTo(camera(7, 51, 300, 0, 60)));
    for (std::size_t n = 0; n < whole.size(); ++n)
        EXPECT_FALSE(bool(parse(whole.substr(0, n)))) << n;
}
