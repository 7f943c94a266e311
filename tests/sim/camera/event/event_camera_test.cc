// SPDX-License-Identifier: Apache-2.0
#include "sim/camera/event/event_camera.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <tuple>

namespace kestrel::sim {
namespace {

constexpr std::int64_t kMs = 1'000'000;  // ns

cv::Mat Flat(double brightness, cv::Size size = {1, 1}) {
  return cv::Mat1f(size, static_cast<float>(brightness));
}

std::vector<std::int64_t> TimesOf(const std::vector<Event>& events) {
  std::vector<std::int64_t> times;
  for (const Event& e : events) times.push_back(e.t_ns);
  return times;
}

// Brightness that rises by 1 in 10 ms reaches 0.25, 0.5, 0.75 and 1 after quarters of that.
TEST(EventCamera, ARisingPixelCrossesItsThresholdsWhenItReachesThem) {
  EventCamera camera({.threshold_on = 0.25}, {1, 1}, 1);
  camera.Begin(Flat(-3), 5 * kMs);
  const auto events = camera.Update(Flat(-2), 15 * kMs);
  EXPECT_EQ(TimesOf(events), (std::vector<std::int64_t>{7'500'000, 10 * kMs, 12'500'000, 15 * kMs}));
  for (const Event& e : events) EXPECT_TRUE(e.on);
}

// Up by 1.1 threshold and down by it: the event on the way down comes one threshold below that of the way up.
TEST(EventCamera, EachSignHasItsThresholdAndCountsFromTheLastEvent) {
  EventCamera camera({.threshold_on = 0.5, .threshold_off = 0.25}, {1, 1}, 1);
  camera.Begin(Flat(0), 0);
  const auto up = camera.Update(Flat(0.625), 10 * kMs);
  ASSERT_EQ(up.size(), 1u);
  EXPECT_TRUE(up[0].on);
  EXPECT_EQ(up[0].t_ns, 8 * kMs);  // 0.5 of 0.625
  const auto down = camera.Update(Flat(0), 15 * kMs);
  ASSERT_EQ(down.size(), 2u);  // at 0.25 and 0
  EXPECT_FALSE(down[0].on);
  EXPECT_EQ(down[0].t_ns, 13 * kMs);  // after 0.375 of 0.625, in 5 ms
  EXPECT_EQ(down[1].t_ns, 15 * kMs);
}

// A ramp of brightness 0.1 x moves right by 40 px/s: the pixel at x is at 0.1 (x - 40 t). It is darker by n
// thresholds of 0.2 at t = n / 20 s, wherever it is, however often it is looked at.
TEST(EventCamera, AMovingRampGivesItsEventsAtTheTimesThatItsSlopeSays) {
  const auto ramp = [](double t_s) {
    cv::Mat1f image(2, 6);
    for (int y = 0; y < image.rows; ++y)
      for (int x = 0; x < image.cols; ++x) image(y, x) = static_cast<float>(0.1 * (x - 40 * t_s));
    return image;
  };
  for (const int samples : {1, 7, 50}) {
    EventCamera camera({}, {6, 2}, 1);
    camera.Begin(ramp(0), 0);
    std::vector<Event> all;
    for (int i = 1; i <= samples; ++i) {
      const std::int64_t t_ns = 230 * kMs * i / samples;
      for (const Event& e : camera.Update(ramp(static_cast<double>(t_ns) * 1e-9), t_ns)) all.push_back(e);
    }
    ASSERT_EQ(all.size(), 4u * 12) << samples;
    for (const Event& e : all) {
      EXPECT_FALSE(e.on);
      const double n = std::round(static_cast<double>(e.t_ns) / (50 * kMs));
      EXPECT_NEAR(static_cast<double>(e.t_ns), n * 50 * kMs, 100) << samples;  // floats, of 2e9 ns a unit
    }
    EXPECT_TRUE(std::is_sorted(all.begin(), all.end(), [](const Event& a, const Event& b) {
      return std::tie(a.t_ns, a.y, a.x) < std::tie(b.t_ns, b.y, b.x);
    }));
  }
}

TEST(EventCamera, EventsOfOneInstantComeRowByRow) {
  EventCamera camera({}, {3, 2}, 1);
  camera.Begin(Flat(0, {3, 2}), 0);
  const auto events = camera.Update(Flat(0.25, {3, 2}), kMs);
  ASSERT_EQ(events.size(), 6u);
  for (int i = 0; i < 6; ++i) {
    EXPECT_EQ(events[i].x, i % 3);
    EXPECT_EQ(events[i].y, i / 3);
    EXPECT_EQ(events[i].t_ns, events[0].t_ns);
  }
}

// Events of a steady rise come every 2 ms; in 5 ms after one there is none, but the pixel follows.
TEST(EventCamera, EventsInTheRefractoryTimeOfAnotherAreLost) {
  EventCamera camera({.threshold_on = 0.2, .refractory_s = 0.005}, {1, 1}, 1);
  camera.Begin(Flat(0), 0);
  const auto events = camera.Update(Flat(2.02), 20'200'000);
  EXPECT_EQ(events.size(), 4u);  // of those at 2, 4 ... 20 ms: 2, 8, 14, 20
  for (std::size_t i = 0; i < events.size(); ++i)
    EXPECT_NEAR(static_cast<double>(events[i].t_ns), (2 + 6.0 * static_cast<double>(i)) * kMs, 1000);
}

TEST(EventCamera, LeakageMakesAStillPixelBrighterAtItsRate) {
  EventCamera camera({.threshold_on = 0.3, .leak_hz = 10}, {1, 1}, 1);
  camera.Begin(Flat(-1), 0);
  std::vector<Event> all;
  for (int i = 1; i <= 52; ++i)
    for (const Event& e : camera.Update(Flat(-1), i * 10 * kMs)) all.push_back(e);
  ASSERT_EQ(all.size(), 5u);  // in 0.52 s
  for (std::size_t i = 0; i < all.size(); ++i) {
    EXPECT_TRUE(all[i].on);
    EXPECT_NEAR(static_cast<double>(all[i].t_ns), 100.0 * kMs * static_cast<double>(i + 1), 100);
  }
}

// 2,500 pixels at 4 Hz for 1 s: 10,000 events, with a deviation of 100; of either sign half, with one of 50.
// They do not depend on how often the pixels are looked at.
TEST(EventCamera, EventsByChanceComeAtTheirRateWhateverTheSamples) {
  const auto events_of = [](int samples, std::uint64_t seed) {
    EventCamera camera({.shot_hz = 4}, {50, 50}, seed);
    camera.Begin(Flat(0, {50, 50}), 0);
    std::vector<Event> all;
    for (int i = 1; i <= samples; ++i)
      for (const Event& e : camera.Update(Flat(0, {50, 50}), 1000 * kMs * i / samples)) all.push_back(e);
    return all;
  };
  const auto events = events_of(1, 5);
  EXPECT_NEAR(static_cast<double>(events.size()), 10'000, 400);
  const auto on = std::count_if(events.begin(), events.end(), [](const Event& e) { return e.on; });
  EXPECT_NEAR(static_cast<double>(on), static_cast<double>(events.size()) / 2, 200);
  EXPECT_EQ(events, events_of(13, 5));
  EXPECT_NE(events, events_of(13, 6));
}

TEST(EventCamera, ThresholdsSpreadAsIsAskedAndEventsAreByEachPixelsOwn) {
  EventCamera camera({.threshold_on = 0.3, .threshold_off = 0.4, .threshold_spread = 0.02}, {80, 80}, 3);
  cv::Scalar mean, deviation;
  cv::meanStdDev(camera.threshold_on(), mean, deviation);
  EXPECT_NEAR(mean[0], 0.3, 0.001);
  EXPECT_NEAR(deviation[0], 0.02, 0.001);
  cv::meanStdDev(camera.threshold_off(), mean, deviation);
  EXPECT_NEAR(mean[0], 0.4, 0.001);
  EXPECT_NEAR(deviation[0], 0.02, 0.001);
  camera.Begin(Flat(0, {80, 80}), 0);
  for (const Event& e : camera.Update(Flat(-0.5, {80, 80}), 500 * kMs)) {
    EXPECT_FALSE(e.on);
    EXPECT_NEAR(static_cast<double>(e.t_ns) * 1e-9, camera.threshold_off()(e.y, e.x), 1e-8);
  }
}

TEST(EventCamera, TheLargestChangeIsInThresholds) {
  EventCamera camera({.threshold_on = 0.5, .threshold_off = 0.1}, {2, 1}, 1);
  camera.Begin(Flat(0, {2, 1}), 0);
  EXPECT_NEAR(camera.LargestChange(cv::Mat1f({1.0f, 0.0f}).reshape(1, 1)), 2, 1e-6);
  EXPECT_NEAR(camera.LargestChange(cv::Mat1f({1.0f, -0.3f}).reshape(1, 1)), 3, 1e-6);
}

}  // namespace
}  // namespace kestrel::sim
