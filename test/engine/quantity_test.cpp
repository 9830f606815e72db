#include "engine/quantity.h"

#include <gtest/gtest.h>

#include <cmath>

namespace atrium {
namespace {

TEST(ParseSize, BinaryDecimalAndBareUnits) {
  EXPECT_EQ(*parse_size("64MiB"), 64ull * 1024 * 1024);
  EXPECT_EQ(*parse_size("64MB"), 64ull * 1000 * 1000);
  EXPECT_EQ(*parse_size("1.5GiB"), 3ull << 29);
  EXPECT_EQ(*parse_size("4096"), 4096ull);
  EXPECT_EQ(*parse_size("0"), 0ull);
  EXPECT_EQ(*parse_size("3kB"), 3000ull);
  EXPECT_EQ(*parse_size("2TiB"), 2ull << 40);
}

TEST(ParseSize, BareIntegersBeyondADoublesPrecisionStayExact) {
  EXPECT_EQ(*parse_size("18446744073709551615"), 18446744073709551615ull);
  EXPECT_EQ(*parse_size("9007199254740993"), 9007199254740993ull);
}

TEST(ParseSize, RefusesWithUsage) {
  for (const char* text : {"",
                           "MiB",
                           "-1",
                           "-1MiB",
                           "nan",
                           "inf",
                           "1e400",
                           "18446744073709551616",
                           "16777216TiB",
                           "64 MiB",
                           "64MiB ",
                           " 64MiB",
                           "64Mib",
                           "64m",
                           "1.5",
                           "+1",
                           "0x10",
                           "1,5GiB",
                           "1MiBMiB",
                           "-0",
                           "1e",
                           "64M"}) {
    const auto r = parse_size(text);
    ASSERT_FALSE(r.ok()) << text;
    EXPECT_EQ(r.status().code(), Code::kUsage) << text;
    EXPECT_NE(r.status().message().find(std::string("'") + text + "'"), std::string::npos);
  }
}

TEST(ParseLength, UnitsAgreeWithTheirDefinitions) {
  EXPECT_DOUBLE_EQ(*parse_length("25mm"), 0.025);
  EXPECT_DOUBLE_EQ(*parse_length("1in"), 0.0254);
  EXPECT_DOUBLE_EQ(*parse_length("12in"), *parse_length("1ft"));
  EXPECT_DOUBLE_EQ(*parse_length("0.025m"), 0.025);
  EXPECT_DOUBLE_EQ(*parse_length("2.5cm"), 0.025);
  EXPECT_DOUBLE_EQ(*parse_length("0.025"), 0.025);
  EXPECT_DOUBLE_EQ(*parse_length("1e-6m"), 1e-6);
}

TEST(ParseLength, RefusesWithUsage) {
  for (const char* text : {"", "mm", "-1mm", "nanm", "infinity", "1e999m", "1e308km", "1yd", "1 m",
                           "1mm.", "1in2", "--1"})
    EXPECT_FALSE(parse_length(text).ok()) << text;
}

TEST(ParseTime, UnitsAgreeWithEachOther) {
  EXPECT_DOUBLE_EQ(*parse_time("90s"), 90);
  EXPECT_DOUBLE_EQ(*parse_time("10min"), 600);
  EXPECT_DOUBLE_EQ(*parse_time("8h"), 8 * 3600);
  EXPECT_DOUBLE_EQ(*parse_time("100us"), 1e-4);
  EXPECT_DOUBLE_EQ(*parse_time("20ms"), 0.02);
  EXPECT_DOUBLE_EQ(*parse_time("1.5"), 1.5);
  for (const char* text : {"", "s", "-1s", "nan", "1m", "10 min", "1hour", "1e309"})
    EXPECT_FALSE(parse_time(text).ok()) << text;
}

TEST(ParseShare, PercentAndFraction) {
  EXPECT_DOUBLE_EQ(*parse_share("2%"), 0.02);
  EXPECT_DOUBLE_EQ(*parse_share("0.02"), 0.02);
  EXPECT_DOUBLE_EQ(*parse_share("100%"), 1);
  for (const char* text : {"", "%", "-2%", "nan%", "2", "101%", "2%%", "2 %", "inf"})
    EXPECT_FALSE(parse_share(text).ok()) << text;
}

TEST(ParseBandwidth, IsASizeASecond) {
  EXPECT_DOUBLE_EQ(*parse_bandwidth("1GB/s"), 1e9);
  EXPECT_DOUBLE_EQ(*parse_bandwidth("200MiB/s"), 200.0 * 1024 * 1024);
  for (const char* text : {"1GB", "/s", "-1GB/s", "1GB/h"})
    EXPECT_FALSE(parse_bandwidth(text).ok()) << text;
}

TEST(Format, ReadsBackAsWhatItWas) {
  EXPECT_EQ(format_size(1536ull << 20), "1.5 GiB");
  EXPECT_EQ(format_size(512), "512 B");
  EXPECT_EQ(format_length(0.0254), "25.4 mm");
  EXPECT_EQ(format_length(3.5), "3.5 m");
  EXPECT_EQ(format_time(3720), "1 h 02 min");
  EXPECT_EQ(format_time(90), "1 min 30 s");
  EXPECT_EQ(format_time(0.00456), "4.56 ms");
  EXPECT_EQ(format_share(0.025), "2.5%");
}

}  // namespace
}  // namespace atrium
