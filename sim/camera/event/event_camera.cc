// SPDX-License-Identifier: Apache-2.0
#include "sim/camera/event/event_camera.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "base/random.h"

namespace kestrel::sim {
namespace {

constexpr double kLeastThreshold = 0.01;
constexpr std::int64_t kNever = std::numeric_limits<std::int64_t>::max();

cv::Mat1d Drawn(double mean, double spread, cv::Size size, RandomStream random) {
  cv::Mat1d thresholds(size, mean);
  if (spread > 0)
    for (double& threshold : thresholds)
      threshold = std::max(kLeastThreshold, mean + spread * random.Normal());
  return thresholds;
}

}  // namespace

EventCamera::EventCamera(const EventCameraParameters& parameters, cv::Size size, std::uint64_t seed)
    : parameters_(parameters),
      seed_(RandomStream(seed, "events by chance").Bits()),
      on_(Drawn(parameters.threshold_on, parameters.threshold_spread, size, {seed, "event threshold on"})),
      off_(Drawn(parameters.threshold_off, parameters.threshold_spread, size,
                 {seed, "event threshold off"})) {}

void EventCamera::Begin(const cv::Mat& brightness, std::int64_t t_ns) {
  brightness.copyTo(before_);
  before_.convertTo(up_, CV_64F);
  down_ = up_ - off_;
  up_ += on_;
  begun_ns_ = before_ns_ = t_ns;
  const std::size_t pixels = before_.total();
  if (parameters_.refractory_s > 0) last_ns_.assign(pixels, std::numeric_limits<std::int64_t>::min() / 2);
  if (parameters_.shot_hz > 0) {
    chances_.assign(pixels, 0);
    chance_ns_.resize(pixels);
    for (std::size_t i = 0; i < pixels; ++i) chance_ns_[i] = NextByChance(i, t_ns);
  }
}

// They come as from a Poisson process.
std::int64_t EventCamera::NextByChance(std::size_t pixel, std::int64_t after_ns) {
  const std::uint64_t bits = RandomStream::Mix(
      seed_ ^ RandomStream::Mix(static_cast<std::uint64_t>(pixel) << 32 | chances_[pixel]++));
  const double share = static_cast<double>(bits >> 11) * 0x1p-53;
  constexpr double kLongest_ns = 1e18;
  const double wait_ns = std::min(kLongest_ns, -std::log1p(-share) / parameters_.shot_hz * 1e9);
  return after_ns + 1 + static_cast<std::int64_t>(wait_ns);
}

double EventCamera::LargestChange(const cv::Mat& brightness) const {
  double largest = 0;
  for (int y = 0; y < before_.rows; ++y) {
    const float *now = brightness.ptr<float>(y), *before = before_[y];
    for (int x = 0; x < before_.cols; ++x) {
      const double change = static_cast<double>(now[x]) - before[x];
      largest = std::max(largest, change > 0 ? change / on_(y, x) : -change / off_(y, x));
    }
  }
  return largest;
}

std::vector<Event> EventCamera::Update(const cv::Mat& brightness, std::int64_t t_ns) {
  std::vector<Event> events;
  const double gap_ns = static_cast<double>(t_ns - before_ns_);
  const double leak_per_ns = parameters_.leak_hz * 1e-9;  // thresholds
  const double leaked_before = leak_per_ns * static_cast<double>(before_ns_ - begun_ns_);
  const double leaked = leak_per_ns * static_cast<double>(t_ns - begun_ns_);
  const auto refractory_ns = static_cast<std::int64_t>(std::llround(parameters_.refractory_s * 1e9));
  for (int y = 0; y < before_.rows; ++y) {
    const float *now = brightness.ptr<float>(y), *before = before_[y];
    double *up = up_[y], *down = down_[y];
    const double *on = on_[y], *off = off_[y];
    for (int x = 0; x < before_.cols; ++x) {
      const std::size_t i = static_cast<std::size_t>(y) * before_.cols + x;
      // What it holds falls by leakage: as if its brightness rose.
      const double to = now[x] + leaked * on[x];
      const bool by_chance = !chance_ns_.empty() && chance_ns_[i] <= t_ns;
      if (to < up[x] && to > down[x] && !by_chance) continue;
      const double from = before[x] + leaked_before * on[x];
      const auto reached_ns = [&](double level) {
        const double share = (level - from) / (to - from);
        return before_ns_ + std::clamp(static_cast<std::int64_t>(std::ceil(share * gap_ns)), std::int64_t{1},
                                       t_ns - before_ns_);
      };
      for (;;) {
        const std::int64_t crossing_ns = to >= up[x]     ? reached_ns(up[x])
                                         : to <= down[x] ? reached_ns(down[x])
                                                         : kNever;
        const std::int64_t chance_ns = chance_ns_.empty() ? kNever : chance_ns_[i];
        const std::int64_t at_ns = std::min(crossing_ns, chance_ns);
        if (at_ns > t_ns) break;
        bool brighter = to >= up[x];
        if (crossing_ns <= chance_ns) {
          // The level of the event is in the middle of the next two.
          up[x] += brighter ? on[x] : -off[x];
          down[x] += brighter ? on[x] : -off[x];
        } else {
          chance_ns_[i] = NextByChance(i, chance_ns);
          brighter = RandomStream::Mix(seed_ ^ static_cast<std::uint64_t>(chance_ns_[i])) & 1;
        }
        if (!last_ns_.empty()) {
          if (at_ns - last_ns_[i] < refractory_ns) continue;
          last_ns_[i] = at_ns;
        }
        events.push_back({at_ns, static_cast<std::uint16_t>(x), static_cast<std::uint16_t>(y), brighter});
      }
    }
  }
  // They are by row and column already, and a pixel's own in their order.
  std::stable_sort(events.begin(), events.end(),
                   [](const Event& a, const Event& b) { return a.t_ns < b.t_ns; });
  brightness.copyTo(before_);
  before_ns_ = t_ns;
  return events;
}

}  // namespace kestrel::sim
