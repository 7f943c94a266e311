// SPDX-License-Identifier: Apache-2.0
#include "vision/capture/aravis_source.h"

#include <arv.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <atomic>

#include "base/stopwatch.h"
#include "vision/capture/live_camera.h"

namespace kestrel::vision {
namespace {

using testing::HasSubstr;

// The fake camera of Aravis, and a hand on the device that a source has opened.
class AravisSourceTest : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    // A search for real ones takes a second.
    arv_disable_interface("GigEVision");
    arv_disable_interface("USB3Vision");
    auto* fakes = ARV_DEVICE_CLASS(g_type_class_ref(ARV_TYPE_FAKE_DEVICE));
    create_stream_ = fakes->create_stream;
    fakes->create_stream = [](ArvDevice* device, ArvStreamCallback callback, void* data,
                              GDestroyNotify destroy, GError** error) {
      device_ = device;
      return create_stream_(device, paint_ ? paint_ : callback, data, destroy, error);
    };
  }
  static void TearDownTestSuite() {
    ARV_DEVICE_CLASS(g_type_class_peek(ARV_TYPE_FAKE_DEVICE))->create_stream = create_stream_;
  }
  void SetUp() override { arv_enable_interface("Fake"); }
  void TearDown() override {
    arv_disable_interface("Fake");
    paint_ = nullptr;
  }

  static void LoseControl() { g_signal_emit_by_name(device_.load(), "control-lost"); }

  static AravisSourceOptions Small() {
    AravisSourceOptions options;
    options.id = "Fake_1", options.size = {64, 48}, options.rate_hz = 100;
    return options;
  }

  inline static std::atomic<ArvDevice*> device_ = nullptr;
  inline static ArvStreamCallback paint_ = nullptr;

 private:
  inline static decltype(ArvDeviceClass::create_stream) create_stream_ = nullptr;
};

TEST_F(AravisSourceTest, ImagesComeAsAskedWithTheCamerasCountAndStampsOnTheMonotonicClock) {
  const auto source = AravisSource(Small())();
  ASSERT_TRUE(source->Open()) << source->Error();
  double last_s = 0;
  std::int64_t last = 0;
  for (int i = 0; i < 5; ++i) {
    const auto grabbed = source->Grab();
    ASSERT_TRUE(grabbed) << source->Error();
    EXPECT_EQ(grabbed->image.size(), cv::Size(64, 48));
    EXPECT_EQ(grabbed->image.type(), CV_8UC1);
    const double now_s = MonotonicNow_s();
    EXPECT_LE(*grabbed->stamp_s, now_s);
    EXPECT_GT(*grabbed->stamp_s, now_s - 1);
    EXPECT_GT(*grabbed->stamp_s, last_s);
    EXPECT_GT(*grabbed->count, last);
    last_s = *grabbed->stamp_s, last = *grabbed->count;
  }
}

TEST_F(AravisSourceTest, StampsAreAsFarApartAsTheCameraSays) {
  AravisSourceOptions options = Small();
  options.rate_hz = 20;
  const auto source = AravisSource(options)();
  ASSERT_TRUE(source->Open()) << source->Error();
  const auto first = source->Grab(), second = source->Grab();
  ASSERT_TRUE(first && second);
  const auto periods = static_cast<double>(*second->count - *first->count);
  EXPECT_NEAR(*second->stamp_s - *first->stamp_s, 0.05 * periods, 0.045 * periods);
}

TEST_F(AravisSourceTest, WithoutANameItIsTheFirstCamera) {
  AravisSourceOptions options = Small();
  options.id = "";
  const auto source = AravisSource(options)();
  ASSERT_TRUE(source->Open()) << source->Error();
  EXPECT_TRUE(source->Grab());
}

TEST_F(AravisSourceTest, ExposureAndGainAreSetInTheCamera) {
  AravisSourceOptions options = Small();
  options.exposure_us = 2500, options.gain = 7;
  const auto source = AravisSource(options)();
  ASSERT_TRUE(source->Open()) << source->Error();
  ASSERT_TRUE(source->Grab());
  GError* error = nullptr;
  EXPECT_NEAR(arv_device_get_float_feature_value(device_, "ExposureTimeAbs", &error), 2500, 1);
  EXPECT_EQ(arv_device_get_integer_feature_value(device_, "GainRaw", &error), 7);
  EXPECT_EQ(error, nullptr);
}

TEST_F(AravisSourceTest, WhatTheCameraDoesNotTakeIsRefusedByName) {
  AravisSourceOptions too_large = Small();
  too_large.size = {100000, 48};
  AravisSourceOptions too_long = Small();
  too_long.exposure_us = 9e9;
  AravisSourceOptions missing = Small();
  missing.id = "Nobody-1234";
  for (const auto& [options, why] :
       {std::pair{too_large, "size"}, {too_long, "exposure"}, {missing, "Nobody-1234"}}) {
    const auto source = AravisSource(options)();
    EXPECT_FALSE(source->Open()) << why;
    EXPECT_THAT(source->Error(), HasSubstr(why));
  }
}

// Red is 200, green 100, blue 50, as a sensor behind a Bayer pattern sees it: by GenICam's name, the first
// two letters are the first row.
void PaintBayer(void*, ArvStreamCallbackType type, ArvBuffer* buffer) {
  if (type != ARV_STREAM_CALLBACK_TYPE_BUFFER_DONE) return;
  const ArvPixelFormat format = arv_buffer_get_image_pixel_format(buffer);
  std::size_t bytes = 0;
  auto* data = static_cast<std::uint8_t*>(const_cast<void*>(arv_buffer_get_data(buffer, &bytes)));
  constexpr std::uint8_t r = 200, g = 100, b = 50;
  std::uint8_t tile[2][2] = {};
  if (format == ARV_PIXEL_FORMAT_BAYER_RG_8) tile[0][0] = r, tile[0][1] = g, tile[1][0] = g, tile[1][1] = b;
  if (format == ARV_PIXEL_FORMAT_BAYER_BG_8) tile[0][0] = b, tile[0][1] = g, tile[1][0] = g, tile[1][1] = r;
  if (format == ARV_PIXEL_FORMAT_BAYER_GB_8) tile[0][0] = g, tile[0][1] = b, tile[1][0] = r, tile[1][1] = g;
  if (format == ARV_PIXEL_FORMAT_BAYER_GR_8) tile[0][0] = g, tile[0][1] = r, tile[1][0] = b, tile[1][1] = g;
  for (int row = 0; row < 48; ++row)
    for (int column = 0; column < 64; ++column) data[64 * row + column] = tile[row % 2][column % 2];
}

TEST_F(AravisSourceTest, ABayerPatternBecomesItsColours) {
  paint_ = PaintBayer;
  AravisSourceOptions options = Small();
  options.colour = true;
  const auto source = AravisSource(options)();
  ASSERT_TRUE(source->Open()) << source->Error();
  // The library hands a buffer over before it calls back: now and then one is grabbed before it is painted.
  const cv::Vec3b painted(50, 100, 200);
  cv::Vec3b even, odd;
  for (int i = 0; i < 50 && !(even == painted && odd == painted); ++i) {
    const auto grabbed = source->Grab();
    ASSERT_TRUE(grabbed) << source->Error();
    ASSERT_EQ(grabbed->image.type(), CV_8UC3);
    even = grabbed->image.at<cv::Vec3b>(20, 30), odd = grabbed->image.at<cv::Vec3b>(21, 31);
  }
  EXPECT_EQ(even, painted);
  EXPECT_EQ(odd, painted);
}

TEST_F(AravisSourceTest, ControlThatIsLostIsAFailureAtOnce) {
  const auto source = AravisSource(Small())();
  ASSERT_TRUE(source->Open()) << source->Error();
  ASSERT_TRUE(source->Grab());
  LoseControl();
  EXPECT_FALSE(source->Grab());
  EXPECT_THAT(source->Error(), HasSubstr("control"));
}

TEST_F(AravisSourceTest, ACameraThatIsUnpluggedAndComesBackIsOpenedAgain) {
  LiveCamera camera(AravisSource(Small()), {.reopen_first_s = 0.01, .reopen_max_s = 0.02});
  const auto before = camera.Next(20);
  ASSERT_TRUE(before);
  arv_disable_interface("Fake");
  LoseControl();
  const double unplugged_s = MonotonicNow_s();
  while (camera.Health().error.find("Fake_1") == std::string::npos) {
    camera.Next(0.01);
    ASSERT_LT(MonotonicNow_s() - unplugged_s, 20);
  }
  EXPECT_EQ(camera.Health().openings, 1);
  arv_enable_interface("Fake");
  while (camera.Health().openings < 2) {
    camera.Next(0.01);
    ASSERT_LT(MonotonicNow_s() - unplugged_s, 20);
  }
  const auto after = camera.Next(20);
  ASSERT_TRUE(after);
  EXPECT_GT(after->t_s, before->t_s);
  EXPECT_GT(after->sequence, before->sequence);
}

}  // namespace
}  // namespace kestrel::vision
