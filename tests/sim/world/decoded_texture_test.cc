// SPDX-License-Identifier: Apache-2.0
#include "sim/world/decoded_texture.h"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <cstdint>
#include <map>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "sim/world/mjcf.h"

namespace kestrel::sim {
namespace {

// 4 x 2 pixels of a palette of three colours, one of them transparent and one half.
const std::string kWithPalette(
    "\x89\x50\x4e\x47\x0d\x0a\x1a\x0a\x00\x00\x00\x0d\x49\x48\x44\x52\x00\x00\x00\x04\x00\x00\x00\x02"
    "\x08\x03\x00\x00\x00\x48\x76\x8d\x51\x00\x00\x00\x09\x50\x4c\x54\x45\xfa\x0a\x14\x1e\xf0\x32\x3c"
    "\x46\xe6\x6b\x1b\xb4\x77\x00\x00\x00\x02\x74\x52\x4e\x53\x00\x80\x9b\x2b\x4e\x18\x00\x00\x00\x0f"
    "\x49\x44\x41\x54\x78\xda\x63\x60\x60\x64\x62\x00\x61\x46\x00\x00\x2b\x00\x08\x2e\x51\x13\xfc\x00"
    "\x00\x00\x00\x49\x45\x4e\x44\xae\x42\x60\x82",
    107);

std::string Png(int type, const std::vector<int>& how = {}) {
  cv::Mat picture(6, 10, type);
  cv::RNG random(1);
  random.fill(picture, cv::RNG::UNIFORM, 0, picture.depth() == CV_16U ? 65536 : 256);
  std::vector<std::uint8_t> bytes;
  cv::imencode(".png", picture, bytes, how);
  return {bytes.begin(), bytes.end()};
}

std::vector<mjtByte> TexelsOf(const char* file, const std::map<std::string, std::string>& files) {
  const std::string mjcf =
      fmt::format(R"(<mujoco><asset><texture name="t" type="2d" file="{}"/></asset></mujoco>)", file);
  const CompiledModel compiled = CompileMjcf(mjcf, files);
  EXPECT_TRUE(compiled.model) << compiled.message;
  if (!compiled.model) return {};
  return {compiled.model->tex_rgb, compiled.model->tex_rgb + compiled.model->ntexdata};
}

TEST(DecodedTexture, IsWhatMuJoCoItselfDecodes) {
  for (const std::string& png : {Png(CV_8UC1), Png(CV_8UC3), Png(CV_8UC4), Png(CV_16UC1), Png(CV_16UC3),
                                 Png(CV_16UC4), Png(CV_8UC1, {cv::IMWRITE_PNG_BILEVEL, 1}), kWithPalette}) {
    const std::vector<mjtByte> own = TexelsOf("picture.png", {{"picture.png", png}});
    EXPECT_GT(own.size(), 0u);
    if (const auto decoded = DecodedTexture(png))
      EXPECT_EQ(TexelsOf("/decoded texture 0", {{"/decoded texture 0", *decoded}}), own) << own.size();
    else
      EXPECT_EQ(png[24], 16) << "only 16 bits are left to MuJoCo";
  }
}

TEST(DecodedTexture, IsNoneOfWhatIsNoPng) {
  std::vector<std::uint8_t> jpeg;
  cv::imencode(".jpg", cv::Mat(8, 8, CV_8UC3, cv::Scalar(1, 2, 3)), jpeg);
  EXPECT_FALSE(DecodedTexture({jpeg.begin(), jpeg.end()}));
  EXPECT_FALSE(DecodedTexture(""));
  const std::string whole = Png(CV_8UC3);
  EXPECT_FALSE(DecodedTexture(whole.substr(0, 40)));
  EXPECT_TRUE(DecodedTexture(whole));
  EXPECT_EQ(DecodedTexture(whole), DecodedTexture(whole));  // kept
}

}  // namespace
}  // namespace kestrel::sim
