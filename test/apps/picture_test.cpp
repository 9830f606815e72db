#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>
#include <gtest/gtest.h>

#include <numbers>

#include <nlohmann/json.hpp>

#include "test/apps/program.h"

namespace atrium::testing {
namespace {

std::uint32_t big_endian(const std::string& bytes, std::size_t at) {
  std::uint32_t word = 0;
  for (std::size_t i = 0; i < 4; ++i) word = word << 8 | static_cast<unsigned char>(bytes[at + i]);
  return word;
}

TEST(Picture, PngHasTheSizeAskedFor) {
  const Folder folder;
  const Ended e = run({"render", furnace_run(), "-o", folder / "a.png", "--width", "64", "--height",
                       "48", "--samples", "1", "--json"});
  ASSERT_EQ(e.code, 0) << e.err;
  const std::string png = read_file(folder / "a.png");
  ASSERT_GT(png.size(), 33u);
  EXPECT_EQ(png.substr(1, 3), "PNG");
  EXPECT_EQ(big_endian(png, 16), 64u);  // [PNG §11.2.2]
  EXPECT_EQ(big_endian(png, 20), 48u);
  EXPECT_TRUE(nlohmann::json::accept(e.out));
}

// Seen from inside, every direction of the furnace has L = B/π.
TEST(Picture, ExrHoldsLuminance) {
  const Folder folder;
  const Ended e = run({"render", furnace_run(), "-o", folder / "a.exr", "--eye", "0.5,0.5,0.5",
                       "--look-at", "0.9,0.2,0.3", "--width", "40", "--height", "30"});
  ASSERT_EQ(e.code, 0) << e.err;
  Imf::InputFile file((folder / "a.exr").c_str());
  const auto window = file.header().dataWindow();
  ASSERT_EQ(window.max.x - window.min.x + 1, 40);
  ASSERT_EQ(window.max.y - window.min.y + 1, 30);
  std::vector<float> green(40 * 30);
  Imf::FrameBuffer frame;
  frame.insert("G", Imf::Slice(Imf::FLOAT, reinterpret_cast<char*>(green.data()), sizeof(float),
                               40 * sizeof(float)));
  file.setFrameBuffer(frame);
  file.readPixels(window.min.y, window.max.y);
  const double expected = kFurnaceRadiosity / std::numbers::pi;
  for (const float g : green) EXPECT_NEAR(g, expected, 0.02 * expected);
}

TEST(Picture, TheSameViewGivesTheSameBytesForAnyNumberOfThreads) {
  const Folder folder;
  for (const char* threads : {"1", "3"})
    ASSERT_EQ(run({"render", furnace_run(), "-o", folder / (std::string(threads) + ".png"),
                   "--width", "80", "--overhead", "--mesh", "--threads", threads})
                  .code,
              0);
  EXPECT_EQ(read_file(folder / "1.png"), read_file(folder / "3.png"));
}

TEST(Picture, HalfACameraIsAUsageError) {
  const Folder folder;
  const std::string view = folder / "a.png";
  EXPECT_EQ(run({"render", furnace_run(), "-o", view, "--eye", "0,0,0"}).code, 2);
  EXPECT_EQ(run({"render", furnace_run(), "-o", view, "--eye", "0,0", "--look-at", "1,0,0"}).code,
            2);
  EXPECT_EQ(run({"render", furnace_run(), "-o", view, "--fov", "180"}).code, 2);
  EXPECT_EQ(run({"render", furnace_run(), "-o", view, "--cut-height", "1"}).code, 2);
  EXPECT_EQ(run({"render", furnace_run()}).code, 2);
  EXPECT_FALSE(std::filesystem::exists(view));
}

}  // namespace
}  // namespace atrium::testing
