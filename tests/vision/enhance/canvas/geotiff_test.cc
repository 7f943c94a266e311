// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/canvas/geotiff.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <stdexcept>
#include <string>
#include <vector>

#include "tests/support/temporary_folder.h"

namespace kestrel::vision {
namespace {

class GeoTiffTest : public InTemporaryFolder {};

// The tags of the first directory of a little-endian TIFF, by the format's own definition and without libtiff.
std::map<int, std::string> TagsOf(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  const std::string bytes((std::istreambuf_iterator<char>(in)), {});
  const auto u16 = [&](std::size_t at) {
    std::uint16_t v;
    std::memcpy(&v, bytes.data() + at, 2);
    return v;
  };
  const auto u32 = [&](std::size_t at) {
    std::uint32_t v;
    std::memcpy(&v, bytes.data() + at, 4);
    return v;
  };
  std::map<int, std::string> tags;
  if (bytes.substr(0, 2) != "II" || u16(2) != 42) return tags;
  const std::size_t directory = u32(4);
  const std::map<int, std::size_t> sizes = {{1, 1}, {2, 1}, {3, 2}, {4, 4}, {12, 8}};
  for (int i = 0; i < u16(directory); ++i) {
    const std::size_t entry = directory + 2 + 12 * static_cast<std::size_t>(i);
    const auto size = sizes.find(u16(entry + 2));
    if (size == sizes.end()) continue;
    const std::size_t length = size->second * u32(entry + 4);
    tags[u16(entry)] = bytes.substr(length > 4 ? u32(entry + 8) : entry + 8, length);
  }
  return tags;
}

template <class T>
std::vector<T> As(const std::string& bytes) {
  std::vector<T> values(bytes.size() / sizeof(T));
  std::memcpy(values.data(), bytes.data(), values.size() * sizeof(T));
  return values;
}

TEST_F(GeoTiffTest, SaysWhereEachPixelLies) {
  if (!GeoTiffIsAvailable()) GTEST_SKIP() << "without libtiff";
  MosaicPicture picture;
  picture.image.create(30, 40, CV_8UC3);
  cv::RNG(1).fill(picture.image, cv::RNG::UNIFORM, 0, 256);
  picture.shown = cv::Mat(30, 40, CV_8UC1, cv::Scalar(255));
  picture.shown(cv::Rect(0, 0, 5, 5)) = cv::Scalar(0);
  picture.origin = {-100, 50};
  picture.scale = 2;
  Eigen::Matrix3d ground;  // 0.05 m a pixel of the surface; its origin at 10 north, 20 east
  ground << 0, -0.05, 10, 0.05, 0, 20, 0, 0, 1;
  WriteGeoTiff(folder_ / "mosaic.tif", picture, ground);

  const cv::Mat read = cv::imread((folder_ / "mosaic.tif").string(), cv::IMREAD_UNCHANGED);
  ASSERT_EQ(read.type(), CV_8UC4);
  std::vector<cv::Mat> channels;
  cv::split(read, channels);
  cv::Mat bgr;
  cv::merge(std::vector<cv::Mat>(channels.begin(), channels.begin() + 3), bgr);
  EXPECT_EQ(cv::norm(channels[3], picture.shown, cv::NORM_INF), 0);
  // What is not opaque a reader may blacken.
  EXPECT_EQ(cv::norm(bgr, picture.image, cv::NORM_INF, picture.shown), 0);

  auto tags = TagsOf(folder_ / "mosaic.tif");
  const auto scale = As<double>(tags[33550]), tiepoint = As<double>(tags[33922]);
  ASSERT_EQ(scale.size(), 3u);
  ASSERT_EQ(tiepoint.size(), 6u);
  EXPECT_NEAR(scale[0], 0.1, 1e-12);
  EXPECT_NEAR(scale[1], 0.1, 1e-12);
  // Pixel is area: (0, 0) is the upper left corner of the first pixel, half a pixel before its middle.
  EXPECT_NEAR(tiepoint[3], 20 + 0.05 * (-100 - 1), 1e-12);
  EXPECT_NEAR(tiepoint[4], 10 - 0.05 * (50 - 1), 1e-12);
  const auto keys = As<std::uint16_t>(tags[34735]);
  ASSERT_EQ(keys.size(), 20u);
  EXPECT_EQ(keys[3], 4);  // keys
  EXPECT_EQ(std::vector<std::uint16_t>(keys.begin() + 8, keys.begin() + 12),
            (std::vector<std::uint16_t>{1025, 0, 1, 1}));  // pixel is area
  EXPECT_EQ(std::vector<std::uint16_t>(keys.begin() + 16, keys.end()),
            (std::vector<std::uint16_t>{3076, 0, 1, 9001}));  // metre
  EXPECT_EQ(keys[14], tags[34737].size() - 1);                // the citation's length
}

TEST_F(GeoTiffTest, AFolderThatIsNotThereIsNamed) {
  if (!GeoTiffIsAvailable()) GTEST_SKIP() << "without libtiff";
  MosaicPicture picture;
  picture.image = cv::Mat(3, 4, CV_8UC1, cv::Scalar(7));
  picture.shown = cv::Mat(3, 4, CV_8UC1, cv::Scalar(255));
  try {
    WriteGeoTiff(folder_ / "none" / "mosaic.tif", picture, Eigen::Matrix3d::Identity());
    FAIL();
  } catch (const std::runtime_error& e) {
    EXPECT_NE(std::string(e.what()).find("mosaic.tif"), std::string::npos);
  }
}

}  // namespace
}  // namespace kestrel::vision
