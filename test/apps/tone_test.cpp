#include "apps/picture/tone.h"

#include <gtest/gtest.h>

#include <cmath>

namespace atrium {
namespace {

TEST(Tone, IsLinearBelowTheShoulderAndNeverAboveWhite) {
  for (const float l : {0.0f, 1.0f, 10.0f, 70.0f}) {
    const Pixel p = tone_mapped({l, 2 * l, 1e9f}, -8);
    EXPECT_FLOAT_EQ(p[0], l / 256);
    EXPECT_FLOAT_EQ(p[1], 2 * l / 256);
    EXPECT_LE(p[2], 1);
  }
}

TEST(Tone, NeverFallsAsLuminanceRises) {
  float before = -1;
  for (int i = 0; i < 1000; ++i) {
    const float now = tone_mapped({static_cast<float>(i) / 100, 0, 0}, 0)[0];
    EXPECT_GE(now, before) << i;
    before = now;
  }
}

TEST(Tone, AutomaticExposureFollowsTheLight) {
  const std::vector<Weighted> room{{50, 1}, {100, 2}, {200, 1}, {0, 5}};
  std::vector<Weighted> brighter = room;
  for (Weighted& v : brighter) v.luminance *= 8;
  EXPECT_NEAR(automatic_exposure(brighter), automatic_exposure(room) - 3, 1e-12);
  EXPECT_EQ(automatic_exposure({}), 0);
}

TEST(Tone, SrgbOfKnownValues) {
  Image image(3, 1);
  image.pixels = {{0, 0, 0}, {1, 1, 1}, {0.5f, 0.0031308f, 2}};
  // 255 (1.055 · 0.5^(1/2.4) - 0.055) = 187.5 and 255 · 12.92 · 0.0031308 = 10.3 [IEC 61966-2-1]
  EXPECT_EQ(srgb_bytes(image), (std::vector<std::uint8_t>{0, 0, 0, 255, 255, 255, 188, 10, 255}));
}

}  // namespace
}  // namespace atrium
