// SPDX-License-Identifier: Apache-2.0
#include "vision/capture/recorded/raw_image.h"

#include <gmock/gmock.h>

#include <opencv2/imgproc.hpp>

namespace kestrel::vision {
namespace {

using ::testing::AllOf;
using ::testing::HasSubstr;

// An image of one colour, of each of its pixels these values.
template <class Value>
std::string Data(std::initializer_list<Value> pixel, int pixels) {
  std::string data;
  for (int i = 0; i < pixels; ++i)
    for (const Value value : pixel) data.append(reinterpret_cast<const char*>(&value), sizeof value);
  return data;
}

RawImage Image(const std::string& encoding, const std::string& data, std::uint32_t pixel_bytes) {
  return {.width_px = 4, .height_px = 3, .step = 4 * pixel_bytes, .encoding = encoding, .data = data};
}

TEST(RawImage, EachColourComesWhereOpenCvHasIt) {
  using B = std::uint8_t;
  const cv::Vec3b expected(10, 20, 30);  // blue, green, red
  for (const auto& [encoding, data, bytes] : {std::tuple{"bgr8", Data<B>({10, 20, 30}, 12), 3U},
                                              {"rgb8", Data<B>({30, 20, 10}, 12), 3U},
                                              {"bgra8", Data<B>({10, 20, 30, 7}, 12), 4U},
                                              {"rgba8", Data<B>({30, 20, 10, 7}, 12), 4U}}) {
    const ImageFile image = DecodeRawImage(Image(encoding, data, bytes), ImageColours::kColour);
    ASSERT_EQ(image.error, "");
    ASSERT_EQ(image.pixels.type(), CV_8UC3) << encoding;
    EXPECT_EQ(image.pixels.at<cv::Vec3b>(1, 2), expected) << encoding;
    EXPECT_EQ(image.white, 255);
  }
  EXPECT_EQ(DecodeRawImage(Image("mono8", Data<B>({77}, 12), 1), ImageColours::kGrey).pixels.at<B>(2, 3), 77);
}

// A red wall before each mosaic: whatever is between the pixels, inside it is red.
TEST(RawImage, AMosaicHasItsColours) {
  struct {
    const char* encoding;
    int row, column;  // of its red pixel
  } const mosaics[] = {
      {"bayer_rggb8", 0, 0}, {"bayer_bggr8", 1, 1}, {"bayer_gbrg8", 1, 0}, {"bayer_grbg8", 0, 1}};
  for (const auto& mosaic : mosaics) {
    std::string data(8 * 8, '\0');
    for (int v = mosaic.row; v < 8; v += 2)
      for (int u = mosaic.column; u < 8; u += 2) data[static_cast<std::size_t>(8 * v + u)] = '\xC8';
    RawImage raw{.width_px = 8, .height_px = 8, .step = 8, .encoding = mosaic.encoding, .data = data};
    const ImageFile image = DecodeRawImage(raw, ImageColours::kColour);
    for (int v = 2; v < 6; ++v)
      for (int u = 2; u < 6; ++u)
        EXPECT_EQ(image.pixels.at<cv::Vec3b>(v, u), cv::Vec3b(0, 0, 200)) << mosaic.encoding;
  }
}

TEST(RawImage, SixteenBitsOfEitherByteOrderStayAsTheyAre) {
  const std::string little = Data<std::uint8_t>({0x34, 0x12}, 12), big = Data<std::uint8_t>({0x12, 0x34}, 12);
  RawImage raw = Image("mono16", little, 2);
  const ImageFile image = DecodeRawImage(raw, ImageColours::kGrey);
  EXPECT_EQ(image.pixels.at<std::uint16_t>(1, 1), 0x1234);
  EXPECT_FALSE(image.white);
  raw.data = big, raw.big_endian = true;
  EXPECT_EQ(DecodeRawImage(raw, ImageColours::kGrey).pixels.at<std::uint16_t>(1, 1), 0x1234);
}

TEST(RawImage, RowsMayBeLongerThanTheirPixels) {
  std::string data(6 * 3, '\0');
  data[6 * 2 + 3] = 5;
  RawImage raw{.width_px = 4, .height_px = 3, .step = 6, .encoding = "mono8", .data = data};
  EXPECT_EQ(DecodeRawImage(raw, ImageColours::kGrey).pixels.at<std::uint8_t>(2, 3), 5);
  raw.data = raw.data.substr(0, 16);  // the last row needs no padding
  EXPECT_EQ(DecodeRawImage(raw, ImageColours::kGrey).error, "");
}

TEST(RawImage, WhatIsNoImageIsRefusedByName) {
  const std::string data(48, '\0');
  EXPECT_THAT(DecodeRawImage(Image("yuv422", data, 2), ImageColours::kGrey).error,
              AllOf(HasSubstr("'yuv422'"), HasSubstr("mono8"), HasSubstr("bayer_rggb8")));
  EXPECT_THAT(DecodeRawImage(Image("32FC1", data, 4), ImageColours::kGrey).error, HasSubstr("'32FC1'"));
  RawImage raw = Image("rgb8", data, 3);
  raw.data = raw.data.substr(0, 35);
  EXPECT_THAT(DecodeRawImage(raw, ImageColours::kGrey).error, HasSubstr("has 35 bytes; valid: 36"));
  raw.step = 11;
  EXPECT_THAT(DecodeRawImage(raw, ImageColours::kGrey).error, HasSubstr("rows of 11 bytes"));
  raw.width_px = 0;
  EXPECT_THAT(DecodeRawImage(raw, ImageColours::kGrey).error, HasSubstr("no pixels"));
  raw.width_px = raw.height_px = raw.step = 0xFFFFFFFF;
  EXPECT_THAT(DecodeRawImage(raw, ImageColours::kGrey).error, HasSubstr("valid: up to"));
}

}  // namespace
}  // namespace kestrel::vision
