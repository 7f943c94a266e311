// SPDX-License-Identifier: Apache-2.0
#include "bench/bench_stream.h"

#include <fmt/format.h>

#include <chrono>
#include <map>
#include <mutex>
#include <stdexcept>
#include <thread>

#include "base/statistics.h"
#include "base/stopwatch.h"
#include "flight/simulated/scenario.h"
#include "sim/server/camera_server.h"
#include "vision/capture/live_camera.h"

namespace kestrel::bench {
namespace {

constexpr int kImages = 400, kPictures = 40;
constexpr double kPeriod_s = 0.05;
constexpr double kPatience_s = 30;
constexpr int kBits = 16, kSquare_px = 16;  // an image's number, in squares at its upper left

std::vector<cv::Mat> Pictures() {
  sim::Simulator simulator(flight::LoadScenario("landing").simulator);
  std::vector<cv::Mat> pictures;
  while (pictures.size() < kPictures) pictures.push_back(simulator.Next().value().image);
  return pictures;
}

cv::Rect Square(int bit) { return {bit * kSquare_px, 0, kSquare_px, kSquare_px}; }

cv::Mat Numbered(const cv::Mat& picture, int number) {
  cv::Mat image = picture.clone();
  for (int bit = 0; bit < kBits; ++bit) image(Square(bit)).setTo((number >> bit & 1) != 0 ? 255 : 0);
  return image;
}

int NumberOf(const cv::Mat& image) {
  int number = 0;
  for (int bit = 0; bit < kBits; ++bit) number |= (cv::mean(image(Square(bit)))[0] > 128 ? 1 : 0) << bit;
  return number;
}

void Measure(vision::RtpStream::Coding coding, const std::vector<cv::Mat>& pictures,
             std::vector<records::Figure>& table) {
  vision::RtpStream stream;
  stream.coding = coding;
  // Not the same for both: the receiver before may still listen there, and receivers share what comes.
  stream.port = coding == vision::RtpStream::Coding::kRaw ? 5697 : 5698;
  const cv::Size size = pictures.front().size();
  sim::CameraServer server(stream, size, 1 / kPeriod_s, false);
  vision::LiveCamera camera(vision::RtpSource(stream, size, false), {});

  std::mutex mutex;
  std::map<int, double> published_s;
  std::jthread publisher([&](const std::stop_token& stop) {
    auto due = std::chrono::steady_clock::now();
    // Before they count, images until the receiver is there.
    for (int k = 0; k < kImages && !stop.stop_requested();) {
      std::this_thread::sleep_until(due += std::chrono::microseconds(static_cast<int>(1e6 * kPeriod_s)));
      const bool counts = camera.Health().images > 0;
      if (counts) ++k;
      const cv::Mat image = Numbered(pictures[static_cast<std::size_t>(k) % pictures.size()], counts ? k : 0);
      const double now_s = MonotonicNow_s();
      if (counts) {
        const std::lock_guard lock(mutex);
        published_s[k] = now_s;
      }
      server.Publish(image);
    }
  });
  std::vector<double> ms;
  double seen_s = MonotonicNow_s();
  while (MonotonicNow_s() < seen_s + kPatience_s) {
    const auto frame = camera.Next(1);
    if (!frame) {
      const std::lock_guard lock(mutex);
      if (!ms.empty() && static_cast<int>(published_s.size()) == kImages) break;
      continue;
    }
    seen_s = MonotonicNow_s();
    const std::lock_guard lock(mutex);
    const auto found = published_s.find(NumberOf(frame->image));
    if (found != published_s.end()) ms.push_back(1e3 * (seen_s - found->second));
  }
  if (ms.empty()) throw std::runtime_error(vision::ToText(stream) + ": no image came");
  const std::string name = coding == vision::RtpStream::Coding::kRaw ? "raw RTP" : "RTP/MJPEG";
  table.push_back({name + ", published until received, mean", Mean(ms), "ms", 25, false, ""});
  table.push_back({name + ", the same, median", Quantile(ms, 0.5), "ms", {}, false, ""});
  table.push_back({name + ", the same, 99th percentile", Quantile(ms, 0.99), "ms", 50, false, ""});
  table.push_back({name + ", images that never came",
                   static_cast<double>(kImages) - static_cast<double>(ms.size()),
                   fmt::format("of {}", kImages),
                   {},
                   false,
                   ""});
}

}  // namespace

void BenchStream(std::vector<records::Figure>& table) {
  const std::vector<cv::Mat> pictures = Pictures();
  Measure(vision::RtpStream::Coding::kJpeg, pictures, table);
  Measure(vision::RtpStream::Coding::kRaw, pictures, table);
}

}  // namespace kestrel::bench
