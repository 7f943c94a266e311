// SPDX-License-Identifier: Apache-2.0
#include "sim/server/camera_server.h"

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>
#include <unistd.h>

#include <memory>
#include <stdexcept>

#include "base/stopwatch.h"
#include "vision/capture/live_camera.h"

namespace kestrel::sim {
namespace {

constexpr double kDeadline_s = 30;

// One that nobody has now.
int FreeUdpPort() {
  const int s = socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in address = {};
  address.sin_family = AF_INET;
  address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t length = sizeof(address);
  EXPECT_EQ(bind(s, reinterpret_cast<const sockaddr*>(&address), length), 0);
  EXPECT_EQ(getsockname(s, reinterpret_cast<sockaddr*>(&address), &length), 0);
  close(s);
  return ntohs(address.sin_port);
}

// Sixteen flat patches from black to white, the first of them turned on by k.
cv::Mat Patches(cv::Size size, int type, int k = 0) {
  cv::Mat image(size, type);
  for (int i = 0; i < 16; ++i) {
    const int level = 17 * ((i + k) % 16);
    const cv::Rect patch(i % 4 * size.width / 4, i / 4 * size.height / 4, size.width / 4, size.height / 4);
    image(patch).setTo(type == CV_8UC1 ? cv::Scalar(level) : cv::Scalar(level, 255 - level, 128));
  }
  return image;
}

// Away from the patches' edges.
double FarthestOff(const cv::Mat& a, const cv::Mat& b) {
  double farthest = 0;
  for (int i = 0; i < 16; ++i) {
    const int w = a.cols / 4, h = a.rows / 4;
    const cv::Rect inner(i % 4 * w + 16, i / 4 * h + 16, w - 32, h - 32);
    farthest = std::max(farthest, cv::norm(a(inner), b(inner), cv::NORM_INF));
  }
  return farthest;
}

class CameraServerTest : public testing::TestWithParam<vision::RtpStream::Coding> {
 protected:
  void SetUp() override {
    stream_.coding = GetParam();
    stream_.port = FreeUdpPort();
  }
  std::unique_ptr<CameraServer> Server(cv::Size size, bool colour) {
    try {
      return std::make_unique<CameraServer>(stream_, size, 20, colour);
    } catch (const std::runtime_error& e) {
      reason_ = e.what();
      return nullptr;
    }
  }
  vision::RtpStream stream_;
  std::string reason_;
};

TEST_P(CameraServerTest, ImagesArriveAsTheyWereSent) {
  const cv::Size size(640, 480);
  for (const bool colour : {false, true}) {
    const auto server = Server(size, colour);
    if (!server) GTEST_SKIP() << reason_;
    vision::LiveCamera camera(vision::RtpSource(stream_, size, colour), {});
    const cv::Mat sent = Patches(size, colour ? CV_8UC3 : CV_8UC1);
    // Uncoded grey levels are the same; a coding, and colours on their way to luminance and back, may err.
    const bool exact = GetParam() == vision::RtpStream::Coding::kRaw && !colour;
    const double most = exact ? 0 : colour ? 6 : 2;
    // Until the receiver is there, and has an image of which no packet was lost.
    std::optional<vision::Frame> frame;
    double off = 255;
    for (const double begun_s = MonotonicNow_s(); off > most && MonotonicNow_s() < begun_s + kDeadline_s;) {
      server->Publish(sent);
      frame = camera.Next(0.05);
      if (!frame) continue;
      ASSERT_EQ(frame->image.size(), size);
      ASSERT_EQ(frame->image.type(), sent.type());
      off = FarthestOff(frame->image, sent);
    }
    EXPECT_LE(off, most) << colour;
    stream_.port = FreeUdpPort();
  }
}

TEST_P(CameraServerTest, NewImagesFollowOldOnes) {
  const cv::Size size(160, 120);
  const auto server = Server(size, false);
  if (!server) GTEST_SKIP() << reason_;
  vision::LiveCamera camera(vision::RtpSource(stream_, size, false), {});
  for (int k = 0; k < 5; ++k) {
    const cv::Mat sent = Patches(size, CV_8UC1, k);
    const auto matches = [&] {
      const auto frame = camera.Next(0.05);
      return frame && cv::norm(frame->image(cv::Rect(10, 10, 20, 10)), sent(cv::Rect(10, 10, 20, 10)),
                               cv::NORM_INF) <= 3;
    };
    bool came = false;
    for (const double begun_s = MonotonicNow_s(); !came && MonotonicNow_s() < begun_s + kDeadline_s;) {
      server->Publish(sent);
      came = matches();
    }
    EXPECT_TRUE(came) << k;
  }
  EXPECT_GE(server->sent(), 5);
}

TEST_P(CameraServerTest, ASecondReceiverIsRefusedAndTheFirstGoesOn) {
  const cv::Size size(160, 120);
  const auto server = Server(size, false);
  if (!server) GTEST_SKIP() << reason_;
  const cv::Mat image = Patches(size, CV_8UC1);
  vision::LiveCamera first(vision::RtpSource(stream_, size, false), {});
  const auto comes = [&](vision::LiveCamera& camera) {
    for (const double begun_s = MonotonicNow_s(); MonotonicNow_s() < begun_s + kDeadline_s;) {
      server->Publish(image);
      if (camera.Next(0.05)) return true;
    }
    return false;
  };
  ASSERT_TRUE(comes(first));
  vision::LiveCamera second(vision::RtpSource(stream_, size, false), {});
  for (const double begun_s = MonotonicNow_s();
       second.Health().error.empty() && MonotonicNow_s() < begun_s + kDeadline_s;)
    second.Next(0.01);
  EXPECT_NE(second.Health().error.find("is in use by another program"), std::string::npos)
      << second.Health().error;
  EXPECT_TRUE(comes(first));
  EXPECT_EQ(second.Health().images, 0);
}

TEST_P(CameraServerTest, PublishingNeverWaitsAndCountsWhatItDrops) {
  const cv::Size size(640, 480);
  const auto server = Server(size, false);
  if (!server) GTEST_SKIP() << reason_;
  const cv::Mat image = Patches(size, CV_8UC1);
  constexpr int kImages = 200;
  for (int k = 0; k < kImages; ++k) server->Publish(image);
  const double deadline_s = MonotonicNow_s() + kDeadline_s;
  while (server->sent() + server->overwritten() < kImages && MonotonicNow_s() < deadline_s)
    std::this_thread::yield();
  EXPECT_EQ(server->sent() + server->overwritten(), kImages);
  EXPECT_GT(server->overwritten(), 0);
}

INSTANTIATE_TEST_SUITE_P(Codings, CameraServerTest,
                         testing::Values(vision::RtpStream::Coding::kJpeg, vision::RtpStream::Coding::kRaw),
                         [](const auto& i) {
                           return i.param == vision::RtpStream::Coding::kRaw ? "raw" : "jpeg";
                         });

}  // namespace
}  // namespace kestrel::sim
