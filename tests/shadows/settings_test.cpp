#include "shadows/settings.h"

#include <gtest/gtest.h>

using namespace gnomon;

TEST(ShadowSettings, ReadsEveryMethodAndCulling) {
    EXPECT_EQ(*parseShadowMethod("off"), ShadowMethod::Off);
    EXPECT_EQ(*parseShadowMethod("single"), ShadowMethod::Single);
    EXPECT_EQ(*parseShadowMethod("csm"), ShadowMethod::Cascades);
    EXPECT_EQ(*parseShadowCull("auto"), ShadowCull::Auto);
    EXPECT_EQ(*parseShadowCull("none"), ShadowCull::None);
    EXPECT_EQ(*parseShadowCull("front"), ShadowCull::Front);
    EXPECT_EQ(*parseShadowCull("back"), ShadowCull::Back);
}

TEST(ShadowSettings, ReadsEveryFilter) {
    struct Row {
        const char* text;
        ShadowFilter filter;
        int width, blockers, samples; // 0: as they were
    };
    const ShadowSettings defaults;
    for (const Row& row :
         {Row{"none", ShadowFilter::None, 0, 0, 0},
          Row{"bilinear", ShadowFilter::Bilinear, 0, 0, 0},
          Row{"pcf:1", ShadowFilter::Pcf, 1, 0, 0}, Row{"pcf:2", ShadowFilter::Pcf, 2, 0, 0},
          Row{"pcf:9", ShadowFilter::Pcf, 9, 0, 0}, Row{"pcss", ShadowFilter::Pcss, 0, 0, 0},
          Row{"pcss:1,1", ShadowFilter::Pcss, 0, 1, 1},
          Row{"pcss:5,64", ShadowFilter::Pcss, 0, 5, 64},
          Row{"pcss:128,256", ShadowFilter::Pcss, 0, 128, 256}}) {
        ShadowSettings s;
        s.filter = row.filter == ShadowFilter::None ? ShadowFilter::Pcf : ShadowFilter::None;
        EXPECT_FALSE(parseShadowFilter(row.text, s)) << row.text;
        EXPECT_EQ(s.filter, row.filter) << row.text;
        EXPECT_EQ(s.pcfWidth, row.width ? row.width : defaults.pcfWidth) << row.text;
        EXPECT_EQ(s.blockerSamples, row.blockers ? row.blockers : defaults.blockerSamples);
        EXPECT_EQ(s.filterSamples, row.samples ? row.samples : defaults.filterSamples);
    }
}

TEST(ShadowSettings, RefuseWhatIsNoneOfThemNamingTheChoicesAndChangingNothing) {
    for (const char* text :
         {"",          "None",        "pcf",         "pcf:",         "pcf:0",
          "pcf:10",    "pcf:-1",      "pcf:3x",      "pcf: 3",       "pcf:3.0",
          "pcss:",     "pcss:16",     "pcss:16,",    "pcss:,32",     "pcss:0,32",
          "pcss:16,0", "pcss:129,32", "pcss:16,257", "pcss:16,32,1", "pcss:99999999999,1",
          "evsm",      "pcss ",       "bilinear2"}) {
        ShadowSettings s;
        s.filter = ShadowFilter::Pcf;
        s.pcfWidth = 7;
        const Failure failure = parseShadowFilter(text, s);
        ASSERT_TRUE(failure) << text;
        EXPECT_EQ(failure->kind, ErrorKind::Usage);
        EXPECT_NE(failure->message().find("pcss:BLOCKERS,SAMPLES"), std::string::npos);
        EXPECT_EQ(s.filter, ShadowFilter::Pcf) << text;
        EXPECT_EQ(s.pcfWidth, 7) << text;
        EXPECT_EQ(s.blockerSamples, 16) << text;
    }
    for (const char* text : {"", "CSM", "on", "cascades", "single "}) {
        const auto method = parseShadowMethod(text);
        ASSERT_FALSE(method) << text;
        EXPECT_EQ(method.error().kind, ErrorKind::Usage);
        EXPECT_NE(method.error().message().find("off, single, csm"), std::string::npos);
    }
    for (const char* text : {"", "both", "Front"})
        EXPECT_FALSE(parseShadowCull(text)) << text;
}

TEST(ShadowSettings, AreDescribedWithEveryChoiceThatMatters) {
    ShadowSettings s;
    EXPECT_EQ(describe(s), "csm+receiver-plane+pcss:16,32");
    s.filter = ShadowFilter::Pcf;
    s.pcfWidth = 5;
    s.cull = ShadowCull::None;
    EXPECT_EQ(describe(s), "csm+receiver-plane+pcf:5, cull none");
    s.method = ShadowMethod::Single;
    s.filter = ShadowFilter::Bilinear;
    s.cull = ShadowCull::Back;
    EXPECT_EQ(describe(s), "single+receiver-plane+bilinear, cull back");
    s.filter = ShadowFilter::None;
    s.cull = ShadowCull::Front;
    EXPECT_EQ(describe(s), "single+receiver-plane+none, cull front");
    s.method = ShadowMethod::Off;
    EXPECT_EQ(describe(s), "off");
}
