// SPDX-License-Identifier: Apache-2.0
#include "vision/image_file.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <boost/crc.hpp>
#include <fstream>
#include <opencv2/imgcodecs.hpp>
#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "tests/support/temporary_folder.h"
#include "vision/image_header.h"

namespace kestrel::vision {
namespace {

using ::testing::HasSubstr;
using ::testing::IsEmpty;

std::string Encoded(const cv::Mat& pixels, const std::string& ending, const std::vector<int>& how = {}) {
  std::vector<uchar> bytes;
  cv::imencode(ending, pixels, bytes, how);
  return {bytes.begin(), bytes.end()};
}

// A PNG of OpenCV's with one more chunk after its header.
std::string WithSignificantBits(const cv::Mat& pixels, char bits) {
  std::string file = Encoded(pixels, ".png");
  constexpr std::size_t kAfterHeader = 33;
  const std::string chunk = std::string("sBIT") + bits;
  boost::crc_32_type sum;
  sum.process_bytes(chunk.data(), chunk.size());
  std::string last;
  for (int shift = 24; shift >= 0; shift -= 8) last += static_cast<char>(sum.checksum() >> shift);
  return file.insert(kAfterHeader, std::string("\0\0\0\1", 4) + chunk + last);
}

cv::Mat Ramp(int largest) {
  cv::Mat ramp(16, 256, CV_16U);
  for (int i = 0; i < 4096; ++i) ramp.at<std::uint16_t>(i / 256, i % 256) = i * largest / 4095;
  return ramp;
}

int Brightest(const cv::Mat& image) {
  double most = 0;
  cv::minMaxIdx(image.reshape(1), nullptr, &most);
  return static_cast<int>(most);
}

TEST(ImageHeader, SaysTheSizeOfEachFormat) {
  const cv::Mat colour(37, 61, CV_8UC3, cv::Scalar(10, 200, 90));
  for (const char* ending : {".png", ".jpg", ".tiff", ".bmp", ".ppm", ".webp"}) {
    const auto header = HeaderOf(Encoded(colour, ending));
    ASSERT_TRUE(header) << ending;
    EXPECT_EQ(header->size, cv::Size(61, 37)) << ending;
  }
  const auto grey = HeaderOf(Encoded(colour, ".jpg", {cv::IMWRITE_JPEG_PROGRESSIVE, 1}));
  ASSERT_TRUE(grey);
  EXPECT_EQ(grey->size, cv::Size(61, 37));
  const auto lossless = HeaderOf(Encoded(colour, ".webp", {cv::IMWRITE_WEBP_QUALITY, 101}));
  ASSERT_TRUE(lossless);
  EXPECT_EQ(lossless->size, cv::Size(61, 37));
  const auto noted = HeaderOf("P5\n# a note 7\n 640\t480 #\n4095\n");
  ASSERT_TRUE(noted);
  EXPECT_EQ(noted->size, cv::Size(640, 480));
  EXPECT_EQ(noted->white, 4095);
  EXPECT_EQ(HeaderOf("P4 8 9 ")->size, cv::Size(8, 9));
}

TEST(ImageHeader, OfACutOneNothingIsSaid) {
  const cv::Mat colour(37, 61, CV_8UC3, cv::Scalar(10, 200, 90));
  for (const char* ending : {".png", ".jpg", ".tiff", ".bmp", ".webp"}) {
    const std::string file = Encoded(colour, ending);
    for (std::size_t size = 0; size < 12; ++size)
      EXPECT_FALSE(HeaderOf(file.substr(0, size))) << ending << size;
    for (std::size_t size = 12; size < file.size(); ++size)
      HeaderOf(file.substr(0, size));  // and no harm is done
  }
  EXPECT_FALSE(HeaderOf("P5\n640"));
  EXPECT_FALSE(HeaderOf("no image"));
}

// 41 bytes of header, and not one of the gigabyte that they announce.
TEST(ImageFile, OneThatIsLargerThanAnyCameraIsRefusedBeforeItIsDecoded) {
  std::string file = Encoded(cv::Mat(8, 8, CV_8U, cv::Scalar(0)), ".png");
  file[18] = file[22] = 0x40;  // 16384 + 8
  const ImageFile bomb = DecodeImage(file, ImageColours::kGrey);
  EXPECT_TRUE(bomb.pixels.empty());
  EXPECT_EQ(bomb.error, "has 16392 x 16392 pixels; valid: up to 8192 x 8192");
  EXPECT_THAT(DecodeImage("P5 100000 100000 255\n", ImageColours::kGrey).error, HasSubstr("valid: up to"));
  EXPECT_THAT(DecodeImage("P5 9999999999999 1 255\n", ImageColours::kGrey).error, HasSubstr("valid: up to"));
  EXPECT_FALSE(
      DecodeImage(Encoded(cv::Mat(8, 8, CV_8U, cv::Scalar(0)), ".png"), ImageColours::kGrey).pixels.empty());
}

TEST(ImageFile, DamagedOnesAreSaidToBe) {
  const std::string file = Encoded(Ramp(65535), ".png");
  EXPECT_THAT(DecodeImage(file.substr(0, file.size() / 2), ImageColours::kGrey).error,
              HasSubstr("is a damaged image: it breaks off"));
  EXPECT_THAT(DecodeImage("text", ImageColours::kGrey).error, HasSubstr("is not an image"));
  EXPECT_THAT(DecodeImage("", ImageColours::kGrey).error, HasSubstr("is not an image"));
}

// What a camera of 12 bits says in a file of 16, each way that files have of saying it, or not.
TEST(PixelDepth, TwelveBitsAreTwelve) {
  const auto brightest = [](const std::string& file, std::optional<int> bits = std::nullopt) {
    const ImageFile image = DecodeImage(file, ImageColours::kGrey);
    PixelDepth depth(bits);
    EXPECT_THAT(depth.Include(image), IsEmpty());
    const cv::Mat eight = depth.EightBits(image);
    EXPECT_EQ(eight.type(), CV_8UC1);
    return Brightest(eight);
  };
  for (const char* ending : {".png", ".tiff"}) {
    EXPECT_EQ(brightest(Encoded(Ramp(4095), ending)), 255);  // upper bits empty
    EXPECT_EQ(brightest(Encoded(Ramp(2100), ending)), 2100 / 16);
    EXPECT_EQ(brightest(Encoded(Ramp(4095) * 16, ending)), 255);  // lower bits empty
    EXPECT_EQ(brightest(Encoded(Ramp(65535), ending)), 255);
    EXPECT_EQ(brightest(Encoded(Ramp(30000), ending)), 30000 / 256);
    EXPECT_EQ(brightest(Encoded(Ramp(1000), ending), 12), 1000 / 16);
  }
  EXPECT_EQ(brightest(WithSignificantBits(Ramp(1000), 12)), 1000 / 16);
  EXPECT_EQ(brightest(WithSignificantBits(Ramp(100) * 16, 12)), 1600 / 256);  // as the specification wants it
  // What says 16 bits as writers do of any file.
  EXPECT_EQ(brightest(WithSignificantBits(Ramp(4095), 16)), 255);
  EXPECT_EQ(brightest("P5 2 1 65535\n" + std::string("\x0f\xff\x00\x10", 4)), 255);
  EXPECT_EQ(brightest("P5 2 1 65535\n" + std::string("\xff\xff\x00\x10", 4)), 255);
  EXPECT_EQ(brightest("P5 2 1 4095\n" + std::string("\x08\x00\x00\x10", 4)), 128);
  EXPECT_EQ(brightest(Encoded(cv::Mat(4, 4, CV_8U, cv::Scalar(7)), ".png"), 12), 7);
}

TEST(PixelDepth, OneImageDecidesForAllThatDoNotSayIt) {
  const ImageFile dark = DecodeImage(Encoded(Ramp(900), ".png"), ImageColours::kGrey);
  const ImageFile bright = DecodeImage(Encoded(Ramp(4000), ".png"), ImageColours::kGrey);
  const ImageFile full = DecodeImage(Encoded(Ramp(65535), ".png"), ImageColours::kGrey);
  PixelDepth alone, both, all;
  alone.Include(dark);
  EXPECT_EQ(Brightest(alone.EightBits(dark)), 900 / 4);
  EXPECT_TRUE(alone.guessed());
  EXPECT_THAT(alone.Note(), HasSubstr("go up to 900: white is taken to be 1023; --bits N says it"));
  both.Include(dark), both.Include(bright);
  EXPECT_EQ(Brightest(both.EightBits(dark)), 900 / 16);
  EXPECT_EQ(Brightest(both.EightBits(bright)), 4000 / 16);
  all.Include(dark), all.Include(full);
  EXPECT_EQ(Brightest(all.EightBits(dark)), 900 / 256);
  EXPECT_FALSE(all.guessed());
  EXPECT_THAT(all.Note(), IsEmpty());
  PixelDepth twelve(12);
  EXPECT_THAT(twelve.Include(dark), IsEmpty());
  EXPECT_THAT(twelve.Include(full), HasSubstr("has values up to 65535, and 12 bits hold 4095"));
}

class ImageFileTest : public InTemporaryFolder {};

TEST_F(ImageFileTest, AMaskIsWhatIsNotBlackInAnyDepth) {
  cv::Mat deep(4, 4, CV_16U, cv::Scalar(0));
  deep.at<std::uint16_t>(1, 2) = 1;
  cv::imwrite((folder_ / "mask.png").string(), deep);
  Mistakes mistakes;
  const cv::Mat mask = ReadMask(folder_ / "mask.png", "--mask", "", mistakes);
  EXPECT_THAT(mistakes.Texts(), IsEmpty());
  EXPECT_EQ(mask.at<std::uint8_t>(1, 2), 255);
  EXPECT_EQ(cv::countNonZero(mask), 1);
  EXPECT_TRUE(ReadMask(folder_, "f.yaml", "own_parts", mistakes).empty());
  EXPECT_THAT(mistakes.Texts(), testing::ElementsAre(testing::StartsWith("f.yaml: own_parts: '")));
}

}  // namespace
}  // namespace kestrel::vision
