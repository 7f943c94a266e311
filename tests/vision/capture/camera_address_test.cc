// SPDX-License-Identifier: Apache-2.0
#include "vision/capture/camera_address.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <filesystem>
#include <fstream>
#include <map>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <opencv2/videoio.hpp>
#include <string>
#include <thread>
#include <vector>

#include "base/diagnostics.h"
#include "base/stopwatch.h"
#include "tests/support/diagnostic_texts.h"
#include "vision/capture/live_camera.h"

namespace kestrel::vision {
namespace {

using Kind = OpenCvSourceOptions::Kind;
using testing::AllOf;
using testing::HasSubstr;

OpenCvSourceOptions OpenCv(const std::string& address) {
  return std::get<OpenCvSourceOptions>(ParseCameraAddress(address));
}

TEST(CameraAddress, NamesADeviceOfVideo4Linux) {
  const auto plain = OpenCv("v4l2:/dev/video0");
  EXPECT_EQ(plain.kind, Kind::kV4l2);
  EXPECT_EQ(plain.what, "/dev/video0");
  EXPECT_TRUE(plain.size.empty());
  EXPECT_FALSE(plain.colour);
  const auto full = OpenCv("v4l2:/dev/v4l/by-id/cam:1?width=640&height=480&rate=29.97&colour=true");
  EXPECT_EQ(full.what, "/dev/v4l/by-id/cam:1");
  EXPECT_EQ(full.size, cv::Size(640, 480));
  EXPECT_EQ(full.rate_hz, 29.97);
  EXPECT_TRUE(full.colour);
}

TEST(CameraAddress, NamesAPipelineWhichMayHaveAQuestionMarkOfItsOwn) {
  const std::string pipeline = "souphttpsrc location=http://10.0.0.1/mjpg?day=1 ! jpegdec ! videoconvert";
  EXPECT_EQ(OpenCv("gst:" + pipeline).kind, Kind::kGStreamer);
  EXPECT_EQ(OpenCv("gst:" + pipeline).what, pipeline);
  EXPECT_EQ(OpenCv("gst:" + pipeline + "?colour=true").what, pipeline);
  EXPECT_TRUE(OpenCv("gst:" + pipeline + "?colour=true").colour);
}

TEST(CameraAddress, NamesAStreamThatComesToAnAddress) {
  const auto mjpeg = OpenCv("rtp://127.0.0.1:5600");
  EXPECT_EQ(mjpeg.kind, Kind::kGStreamer);
  EXPECT_THAT(mjpeg.what, HasSubstr("udpsrc address=127.0.0.1 port=5600 "));
  EXPECT_THAT(mjpeg.what, HasSubstr("rtpjpegdepay"));
  EXPECT_THAT(mjpeg.what, HasSubstr("format=GRAY8"));
  const auto raw = OpenCv("raw://0.0.0.0:5601?width=640&height=480&colour=true");
  EXPECT_EQ(raw.size, cv::Size(640, 480));
  EXPECT_THAT(raw.what,
              HasSubstr("sampling=(string)YCbCr-4:2:0,depth=(string)8,width=(string)640,height=(string)480"));
  EXPECT_THAT(raw.what, HasSubstr("format=BGR"));
}

TEST(CameraAddress, NamesACameraOfIeee1394ByItsNumber) {
  EXPECT_EQ(OpenCv("dc1394:1").kind, Kind::kIeee1394);
  EXPECT_EQ(OpenCv("dc1394:1").what, "1");
}

TEST(CameraAddress, NamesAGenICamCamera) {
  EXPECT_EQ(std::get<AravisSourceOptions>(ParseCameraAddress("aravis:")).id, "");
  const auto camera = std::get<AravisSourceOptions>(ParseCameraAddress(
      "aravis:Basler-21237813?width=640&height=480&rate=50&exposure_us=5000&gain=6&colour=true"));
  EXPECT_EQ(camera.id, "Basler-21237813");
  EXPECT_EQ(camera.size, cv::Size(640, 480));
  EXPECT_EQ(camera.rate_hz, 50);
  EXPECT_EQ(camera.exposure_us, 5000);
  EXPECT_EQ(camera.gain, 6);
  EXPECT_TRUE(camera.colour);
}

TEST(CameraAddress, TheSizeIsKnownOfEveryKind) {
  EXPECT_EQ(SizeAt(ParseCameraAddress("aravis:?width=64&height=48")), cv::Size(64, 48));
  EXPECT_EQ(SizeAt(ParseCameraAddress("v4l2:/dev/video0?width=64&height=48")), cv::Size(64, 48));
  EXPECT_TRUE(SizeAt(ParseCameraAddress("rtp://127.0.0.1:5600")).empty());
}

class CameraAddressFiles : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::path(testing::TempDir()) /
              testing::UnitTest::GetInstance()->current_test_info()->name();
    std::filesystem::create_directories(folder_);
    for (const int i : {1, 2, 10})
      cv::imwrite(folder_ / ("view" + std::to_string(i) + ".png"),
                  cv::Mat(24, 32, CV_8UC3, cv::Scalar::all(i)));
    std::ofstream(folder_ / "notes.txt") << "no image\n";
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }
  std::filesystem::path folder_;
};

TEST_F(CameraAddressFiles, AFolderGivesItsImagesInTheOrderOfTheirNumbersAndEnds) {
  const auto source = SourceAt(ParseCameraAddress("file:" + folder_.string() + "?width=32&height=24"))();
  ASSERT_TRUE(source->Open()) << source->Error();
  for (const int i : {1, 2, 10}) {
    const auto grabbed = source->Grab();
    ASSERT_TRUE(grabbed);
    ASSERT_EQ(grabbed->image.type(), CV_8UC1);
    EXPECT_EQ(grabbed->image.at<std::uint8_t>(3, 3), i);
  }
  EXPECT_FALSE(source->Grab());
  EXPECT_TRUE(source->Ended());
}

TEST_F(CameraAddressFiles, AnImageOfAnotherSizeIsAFailureWithItsName) {
  const auto source = SourceAt(ParseCameraAddress("file:" + folder_.string() + "?width=64&height=24"))();
  ASSERT_TRUE(source->Open());
  EXPECT_FALSE(source->Grab());
  EXPECT_THAT(source->Error(), HasSubstr("view1.png"));
}

TEST_F(CameraAddressFiles, APatternGivesTheImagesThatItMatches) {
  cv::imwrite(folder_ / "other3.png", cv::Mat(24, 32, CV_8UC3, cv::Scalar::all(3)));
  cv::imwrite(folder_ / "view4b.png", cv::Mat(24, 32, CV_8UC3, cv::Scalar::all(4)));
  for (const auto& [name, values] : std::map<std::string, std::vector<int>>{
           {"view%d.png", {1, 2, 10}}, {"view%02d.png", {1, 2, 10}}, {"view2.png", {2}}}) {
    const auto source = SourceAt(ParseCameraAddress("file:" + (folder_ / name).string()))();
    ASSERT_TRUE(source->Open()) << source->Error();
    for (const int value : values) {
      const auto grabbed = source->Grab();
      ASSERT_TRUE(grabbed) << name;
      EXPECT_EQ(grabbed->image.at<std::uint8_t>(3, 3), value) << name;
    }
    EXPECT_FALSE(source->Grab()) << name;
  }
}

TEST_F(CameraAddressFiles, AVideoMayHaveAQuestionMarkInItsName) {
  const std::string odd = (folder_ / "what?now=no more.mp4").string();
  std::ofstream(odd) << "no video\n";
  EXPECT_EQ(OpenCv("file:" + odd).what, odd);
  EXPECT_EQ(OpenCv("file:" + odd + "?rate=20").rate_hz, 20);
  EXPECT_EQ(OpenCv("file:" + odd).kind, Kind::kFile);
}

// Cameras of 12 bits leave the upper four of 16 empty.
TEST_F(CameraAddressFiles, PixelsOf16BitsThatDoNotSayTheirDepthAreAskedFor) {
  const auto folder = folder_ / "deep";
  std::filesystem::create_directories(folder);
  cv::imwrite(folder / "1.png", cv::Mat(24, 32, CV_16U, cv::Scalar(0x123)));
  cv::imwrite(folder / "2.png", cv::Mat(24, 32, CV_16U, cv::Scalar(0xfff)));
  const auto asks = SourceAt(ParseCameraAddress("file:" + folder.string()))();
  ASSERT_TRUE(asks->Open());
  EXPECT_FALSE(asks->Grab());
  EXPECT_THAT(asks->Error(), AllOf(HasSubstr("1.png"), HasSubstr("?bits=N")));
  const auto told = SourceAt(ParseCameraAddress("file:" + folder.string() + "?bits=12"))();
  ASSERT_TRUE(told->Open());
  for (const int value : {0x12, 0xff}) {
    const auto grabbed = told->Grab();
    ASSERT_TRUE(grabbed) << told->Error();
    EXPECT_EQ(grabbed->image.at<std::uint8_t>(3, 3), value);
  }
}

TEST(CameraAddress, WhatIsWrongIsRefusedWithWhatIsValid) {
  for (const auto& [address, why] : std::initializer_list<std::pair<const char*, const char*>>{
           {"", "v4l2:/dev/video0"},
           {"/dev/video0", "v4l2:/dev/video0"},
           {"v4l:/dev/video0", "did you mean v4l2:?"},
           {"webcam:0", "aravis:ID"},
           {"v4l2:0", "path of a device"},
           {"v4l2:", "v4l2:/dev/video0"},
           {"gst:", "names nothing"},
           {"rtp:127.0.0.1:5600", "rtp://HOST:PORT"},
           {"rtp://127.0.0.1", "rtp://HOST:PORT"},
           {"rtp://127.0.0.1:0", "from 1 to 65535"},
           {"rtp://127.0.0.1:65536", "from 1 to 65535"},
           {"rtp://a ! filesink location=b:5600", "rtp://HOST:PORT"},
           {"raw://127.0.0.1:5600", "needs width and height"},
           {"dc1394:one", "number of a camera"},
           {"dc1394:-1", "number of a camera"},
           {"file:/nowhere/at/all.mp4", "no file or folder"},
           {"v4l2:/dev/video0?width=640", "height: must be given too"},
           {"v4l2:/dev/video0?width=0&height=480", "from 1 to 16384"},
           {"v4l2:/dev/video0?width=640.5&height=480", "whole number"},
           {"v4l2:/dev/video0?width=nan&height=480", "must be a number"},
           {"v4l2:/dev/video0?rate=fast", "must be a number"},
           {"v4l2:/dev/video0?rate=20&rate=30", "given twice"},
           {"v4l2:/dev/video0?color=true", "did you mean colour?"},
           {"v4l2:/dev/video0?colour=yes", "true or false"},
           {"v4l2:/dev/video0?exposure_us=100", "no option of v4l2"},
           {"v4l2:/dev/video0?fast", "key=value"},
           {"aravis:?exposure_us=-5", "must be a number"},
       }) {
    try {
      ParseCameraAddress(address);
      ADD_FAILURE() << address << " was taken";
    } catch (const InputError& error) {
      EXPECT_THAT(error.what(), HasSubstr(why)) << address;
    }
  }
}

TEST(CameraAddress, EveryMistakeIsToldAtOnce) {
  try {
    ParseCameraAddress("v4l2:video0?rate=fast&colour=yes&zoom=2");
    ADD_FAILURE();
  } catch (const InputError& error) {
    EXPECT_EQ(Texts(error).size(), 4u);
  }
}

// A port on loopback that is free: the system's choice, given back at once.
int FreePort() {
  const int socket = ::socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in at{.sin_family = AF_INET, .sin_port = 0, .sin_addr = {htonl(INADDR_LOOPBACK)}, .sin_zero = {}};
  socklen_t size = sizeof at;
  EXPECT_EQ(bind(socket, reinterpret_cast<sockaddr*>(&at), size), 0);
  EXPECT_EQ(getsockname(socket, reinterpret_cast<sockaddr*>(&at), &size), 0);
  close(socket);
  return ntohs(at.sin_port);
}

// Sends the same image to a port for as long as it lives.
class Sender {
 public:
  Sender(const std::string& pay, int port, const cv::Mat& image)
      : writer_("appsrc ! " + pay + " ! udpsink sync=false host=127.0.0.1 port=" + std::to_string(port),
                cv::CAP_GSTREAMER, 0, 50, image.size(), image.channels() == 3),
        thread_([this, image] {
          while (!stop_ && writer_.isOpened()) {
            writer_.write(image);
            std::this_thread::sleep_for(std::chrono::milliseconds(20));
          }
        }) {}
  ~Sender() {
    stop_ = true;
    thread_.join();
  }
  bool Works() const { return writer_.isOpened(); }

 private:
  cv::VideoWriter writer_;
  std::atomic<bool> stop_ = false;
  std::thread thread_;
};

// Dark on the left, bright on the right, with a block in the upper left that tells up from down.
cv::Mat RenderedFrame() {
  cv::Mat image(48, 64, CV_8UC1);
  for (int column = 0; column < 64; ++column) image.col(column).setTo(4 * column);
  cv::rectangle(image, {8, 8, 16, 8}, cv::Scalar(200), cv::FILLED);
  return image;
}

double MeanDifference(const cv::Mat& a, const cv::Mat& b) {
  cv::Mat difference;
  cv::absdiff(a, b, difference);
  return cv::mean(difference.reshape(1))[0];
}

constexpr const char* kJpeg = "videoconvert ! video/x-raw,format=I420 ! jpegenc quality=95 ! rtpjpegpay";

TEST(CameraAddress, MjpegOverRtpArrivesAsItWasSentAndComesBackAfterItsSenderWasAway) {
  const int port = FreePort();
  const cv::Mat image = RenderedFrame();
  auto sender = std::make_unique<Sender>(kJpeg, port, image);
  ASSERT_TRUE(sender->Works()) << "GStreamer's plugins: gstreamer1.0-plugins-base and -good";
  LiveCamera camera(SourceAt(ParseCameraAddress("rtp://127.0.0.1:" + std::to_string(port))),
                    {.stalled_s = 0.5, .reopen_first_s = 0.02, .reopen_max_s = 0.1});
  const auto frame = camera.Next(20);
  ASSERT_TRUE(frame);
  ASSERT_EQ(frame->image.size(), image.size());
  ASSERT_EQ(frame->image.type(), CV_8UC1);
  EXPECT_LT(MeanDifference(frame->image, image), 4);
  sender.reset();
  const double begun_s = MonotonicNow_s();
  while (camera.Health().state != LiveCameraState::kStalled && MonotonicNow_s() - begun_s < 20)
    camera.Next(0.05);
  EXPECT_EQ(camera.Health().state, LiveCameraState::kStalled);
  sender = std::make_unique<Sender>(kJpeg, port, image);
  const auto again = camera.Next(20);
  ASSERT_TRUE(again);
  EXPECT_LT(MeanDifference(again->image, image), 4);
}

TEST(CameraAddress, RawVideoOverRtpArrivesAsItWasSent) {
  cv::Mat colour;
  cv::cvtColor(RenderedFrame(), colour, cv::COLOR_GRAY2BGR);
  cv::add(colour, cv::Scalar(0, 20, 50), colour);
  struct {
    cv::Mat image;
    std::string format, option;
    double most;
  } const kinds[] = {{RenderedFrame(), "I420", "", 1.5}, {colour, "I420", "&colour=true", 5}};
  for (const auto& [image, format, option, most] : kinds) {
    const int port = FreePort();
    const Sender sender("videoconvert ! video/x-raw,format=" + format + " ! rtpvrawpay", port, image);
    ASSERT_TRUE(sender.Works());
    LiveCamera camera(SourceAt(ParseCameraAddress("raw://127.0.0.1:" + std::to_string(port) +
                                                  "?width=64&height=48" + option)),
                      {});
    // Of the first images some packets may have come before it listened.
    double difference = 0;
    for (int i = 0; i == 0 || (difference > most && i < 5); ++i) {
      const auto frame = camera.Next(20);
      ASSERT_TRUE(frame) << format << ": " << camera.Health().error;
      ASSERT_EQ(frame->image.type(), image.type());
      difference = MeanDifference(frame->image, image);
    }
    EXPECT_LE(difference, most) << format;
  }
}

}  // namespace
}  // namespace kestrel::vision
