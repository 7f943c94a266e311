// SPDX-License-Identifier: Apache-2.0
#include "sim/camera/event/event_renderer.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>
#include <tuple>

#include "geometry/tait_bryan.h"
#include "tests/sim/scenes.h"

namespace kestrel::sim {
namespace {

constexpr double kStep_s = 0.002, kHeight_m = 5;
const vision::Pinhole kCamera{96, 64, 100, 100, 47.5, 31.5};

// A camera that looks down from 5 m, its top to the north, on ground, light as it is painted.
class EventsOverTheGround : public ::testing::Test {
 protected:
  static ModelPtr Ground(const std::string& assets, const std::string& geoms) {
    return CompileScene(R"(<mujoco>
        <visual><headlight ambient="1 1 1" diffuse="0 0 0" specular="0 0 0"/></visual>
        <asset>)" + assets +
                        R"(</asset>
        <worldbody><body name="vehicle"><freejoint/><geom size="0.001" rgba="0 0 0 0"/></body>)" +
                        geoms + "</worldbody></mujoco>");
  }
  static ModelPtr Chequered() {
    return Ground(R"(<texture name="c" type="2d" builtin="checker" rgb1="0.2 0.2 0.2" rgb2="0.8 0.8 0.8"
                              width="128" height="128"/>
                     <material name="c" texture="c" texrepeat="0.5 0.5" texuniform="true" specular="0"/>)",
                  R"(<geom type="plane" size="50 50 1" material="c"/>)");
  }
  // Bright in the east, dark in the west.
  static ModelPtr Halves() {
    return Ground("", R"(<geom type="box" size="50 50 0.1" pos="0 0 -0.2" rgba="0.2 0.2 0.2 1"/>
                         <geom type="box" size="40 40 0.01" pos="0 -40 -0.01" rgba="0.8 0.8 0.8 1"/>)");
  }
  using Way = std::function<Pose(double)>;
  // Looking down from there, turned by so much.
  static Pose Above(double north_m, double east_m, double turned_rad) {
    return {HeadingRotation(turned_rad) * HeadingRotation(std::numbers::pi / 2),
            {north_m, east_m, -kHeight_m}};
  }
  struct Flown {
    std::vector<Event> events;
    cv::Mat begin, end;  // brightness
    cv::Mat1d on, off;
    std::int64_t samples;
  };
  static Flown Fly(const ModelPtr& model, const Way& way, double duration_s,
                   const EventCameraParameters& parameters = {}, int threads = 1) {
    EventRenderer renderer(model.get(), kCamera, {.threads = threads}, {}, {}, Vibration({}, 1), parameters,
                           1);
    const DataPtr data = MakeData(model.get());
    Flown flown;
    for (int i = 0; i * kStep_s < duration_s + 1e-9; ++i) {
      Snapshot now = SnapshotOf(model.get(), data.get(), kStep_s * i);
      now.X_NC = way(kStep_s * i);
      renderer.Add(std::move(now));
      if (i == 0) flown.begin = renderer.brightness().clone();
    }
    renderer.Finish();
    flown.events = renderer.Take();
    flown.end = renderer.brightness();
    flown.on = renderer.camera().threshold_on(), flown.off = renderer.camera().threshold_off();
    flown.samples = renderer.samples();
    return flown;
  }
  // Goes 1 m/s east, 0.5 m/s north and turns by 0.5 rad/s.
  static Pose Sweep(double t_s) { return Above(0.5 * t_s, t_s, 0.5 * t_s); }
};

TEST_F(EventsOverTheGround, AStillCameraGivesNone) {
  const Flown flown = Fly(
      Chequered(), [](double) { return Above(0.3, 0.1, 0.2); }, 0.1);
  EXPECT_EQ(flown.events.size(), 0u);
  EXPECT_LE(flown.samples, 12);  // one in 10 ms
}

// The edge goes west by 1 m/s: 20 px/s. The middle of a pixel at x is reached at (x - 47.5) / 20 px/s before
// the camera stands over the edge. Six thresholds fit between 0.2 and 0.8.
TEST_F(EventsOverTheGround, AnEdgeThatPassesGivesItsEventsWhileItIsInThePixel) {
  const Flown flown = Fly(
      Halves(), [](double t_s) { return Above(0, t_s - 1, 0); }, 2);
  std::map<std::pair<int, int>, int> of_pixel;
  double most_px = 0;
  for (const Event& e : flown.events) {
    EXPECT_TRUE(e.on);
    ++of_pixel[{e.x, e.y}];
    const double edge_px = 47.5 - 20 * (static_cast<double>(e.t_ns) * 1e-9 - 1);
    most_px = std::max(most_px, std::abs(edge_px - e.x));
  }
  for (int y = 0; y < 64; ++y)
    for (int x = 29; x < 67; ++x) EXPECT_EQ((of_pixel[{x, y}]), 6) << x << ' ' << y;
  EXPECT_LT(most_px, 1);  // half a pixel, and half a pixel between samples
}

// What an event says is that its pixel's brightness has changed by its threshold.
TEST_F(EventsOverTheGround, TheirSumIsTheChangeOfBrightnessWithinAThreshold) {
  const Flown flown = Fly(Chequered(), Sweep, 0.3, {.threshold_off = 0.15, .threshold_spread = 0.02});
  ASSERT_GT(flown.events.size(), 1000u);
  cv::Mat1d sum;
  flown.begin.convertTo(sum, CV_64F);
  for (const Event& e : flown.events) sum(e.y, e.x) += e.on ? flown.on(e.y, e.x) : -flown.off(e.y, e.x);
  for (int y = 0; y < sum.rows; ++y) {
    for (int x = 0; x < sum.cols; ++x) {
      const double missing = flown.end.at<float>(y, x) - sum(y, x);
      EXPECT_LT(missing, flown.on(y, x) + 1e-9);
      EXPECT_GT(missing, -flown.off(y, x) - 1e-9);
    }
  }
}

TEST_F(EventsOverTheGround, AreTheSameForAnyNumberOfThreads) {
  const Flown one = Fly(Chequered(), Sweep, 0.05), three = Fly(Chequered(), Sweep, 0.05, {}, 3);
  ASSERT_GT(one.events.size(), 100u);
  EXPECT_EQ(one.events, three.events);
}

// A finer sampling finds the same events at the same times: of ten times as many samples.
TEST_F(EventsOverTheGround, FinerSamplesChangeLittle) {
  using Pixels = std::map<std::tuple<int, int, bool>, std::vector<std::int64_t>>;
  const auto pixels_of = [](const Flown& flown) {
    Pixels pixels;
    for (const Event& e : flown.events) pixels[{e.x, e.y, e.on}].push_back(e.t_ns);
    return pixels;
  };
  const Flown fine = Fly(Chequered(), Sweep, 0.2, {.largest_move_px = 0.05});
  const auto near = [&](double move_px) {
    const Flown coarse = Fly(Chequered(), Sweep, 0.2, {.largest_move_px = move_px});
    Pixels truth = pixels_of(fine);
    int found = 0;
    for (const auto& [pixel, times] : pixels_of(coarse))
      for (const std::int64_t t_ns : times) {
        const auto& all = truth[pixel];
        found += std::any_of(all.begin(), all.end(),
                             [&](auto other) { return std::abs(other - t_ns) < 1'000'000; });
      }
    return found / static_cast<double>(std::max(coarse.events.size(), fine.events.size()));
  };
  const double at_half = near(0.5), at_quarter = near(0.25);
  EXPECT_GT(at_half, 0.8);
  EXPECT_GT(at_quarter, 0.9);
}

// An interval in which a pixel changes by more than a threshold is halved.
TEST_F(EventsOverTheGround, ABoundOnTheChangeOfBrightnessTakesMoreSamples) {
  const Flown free = Fly(Chequered(), Sweep, 0.02);
  const Flown bound = Fly(Chequered(), Sweep, 0.02, {.largest_change = 1});
  EXPECT_GT(bound.samples, 2 * free.samples);
}

}  // namespace
}  // namespace kestrel::sim
