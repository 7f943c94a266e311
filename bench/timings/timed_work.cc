// SPDX-License-Identifier: Apache-2.0
#include "bench/timings/timed_work.h"

#include <time.h>

#include <algorithm>
#include <cstddef>
#include <memory>
#include <opencv2/imgproc.hpp>
#include <optional>
#include <stdexcept>
#include <utility>
#include <variant>

#include "base/diagnostics.h"
#include "bench/named_camera.h"
#include "bench/pad_scene.h"
#include "bench/timings/calibration.h"
#include "bench/timings/timed_scene.h"
#include "flight/simulated/runner.h"
#include "vision/horizon/horizon_attitude.h"
#include "vision/landmark/pad_tracker.h"

namespace kestrel::bench {
namespace {

double Now_ms(clockid_t clock) {
  timespec t;
  clock_gettime(clock, &t);
  return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_nsec) * 1e-6;
}

// Frames of a world along a short path, each drawn anew.
Block Frames(const std::string& scenario, const std::string& camera, double height_m, int frames) {
  auto scene = std::make_shared<TimedScene>(scenario, NamedCamera(camera));
  return [scene, height_m, frames] {
    const WorkClock clock;
    for (int i = 0; i < frames; ++i) scene->Draw(PathPose(height_m, i));
    return clock.Taken(frames);
  };
}

// Images of a path, there and back, so that each is near the one before, however often it is gone.
class ThereAndBack {
 public:
  explicit ThereAndBack(std::vector<cv::Mat> images) : images_(std::move(images)) {}
  const cv::Mat& Next() {
    const std::size_t last = images_.size() - 1, at = next_++ % (2 * last);
    return images_[at <= last ? at : 2 * last - at];
  }
  int both_ways() const { return 2 * static_cast<int>(images_.size() - 1); }

 private:
  std::vector<cv::Mat> images_;
  std::size_t next_ = 0;
};

Block PadTracking() {
  constexpr int kImages = 21;
  constexpr double kHeight_m = 3, kFrame_s = 1.0 / 20;
  PadScene scene;
  const PadSway sway(1, "timings");
  const sim::ImageSensor sensor = scene.Sensor(1);
  std::vector<cv::Mat> images;
  for (int k = 0; k < kImages; ++k)
    images.push_back(sensor.Expose(scene.Render(sway.X_TC(kHeight_m, k * kFrame_s)), k));
  auto path = std::make_shared<ThereAndBack>(std::move(images));
  auto tracker = std::make_shared<vision::PadTracker>(
      scene.loaded().pad, std::get<vision::Pinhole>(scene.loaded().simulator.camera),
      scene.loaded().scenario.pilot.tracker);
  return [path, tracker] {
    const WorkClock clock;
    for (int i = 0; i < path->both_ways(); ++i) {
      cv::Mat grey = path->Next();
      if (grey.channels() == 3) cv::cvtColor(grey, grey, cv::COLOR_BGR2GRAY);
      tracker->Track(grey, std::nullopt);
    }
    return clock.Taken(path->both_ways());
  };
}

// The image in which a pad is lost, the dearest: it is followed in vain in every way, and then searched for. Beside the
// pad nothing but ground is in view.
Block LossOfThePad() {
  constexpr int kImages = 6, kTries = 9;  // to see it again: features look in each third image
  constexpr double kHeight_m = 3, kFrame_s = 1.0 / 20, kBeside_m = 6;
  PadScene scene;
  const PadSway sway(1, "timings");
  const sim::ImageSensor sensor = scene.Sensor(1);
  const auto image = [&](double along_m, int k) {
    Pose X_TC = sway.X_TC(kHeight_m, k * kFrame_s);
    X_TC.p.x() += along_m;
    cv::Mat grey = sensor.Expose(scene.Render(X_TC), k);
    if (grey.channels() == 3) cv::cvtColor(grey, grey, cv::COLOR_BGR2GRAY);
    return grey.clone();
  };
  std::vector<cv::Mat> with, without;
  for (int k = 0; k < kImages; ++k) with.push_back(image(0, k)), without.push_back(image(kBeside_m, k));
  auto tracker = std::make_shared<vision::PadTracker>(
      scene.loaded().pad, std::get<vision::Pinhole>(scene.loaded().simulator.camera),
      scene.loaded().scenario.pilot.tracker);
  return [with, without, tracker] {
    WorkTimes all{0, 0, kImages};
    for (int k = 0; k < kImages; ++k) {
      int tries = 0;
      while (!tracker->Track(with[k], std::nullopt))
        if (++tries == kTries)
          throw std::runtime_error("bench timings: the pad that is to be lost is not found");
      const WorkClock clock;
      tracker->Track(without[k], std::nullopt);
      const WorkTimes taken = clock.Taken(1);
      all.processor_ms += taken.processor_ms;
      all.wall_ms += taken.wall_ms;
    }
    return all;
  };
}

Block SkylineAndCompass() {
  constexpr int kImages = 6;
  constexpr double kHeight_m = 30;
  TimedScene scene("attitude_2");
  std::vector<cv::Mat> images;
  for (int k = 0; k < kImages; ++k) images.push_back(scene.Draw(PathPose(kHeight_m, k)).clone());
  auto path = std::make_shared<ThereAndBack>(std::move(images));
  auto horizon = std::make_shared<vision::HorizonAttitude>(scene.camera(), scene.X_BC().R.toRotationMatrix(),
                                                           scene.OwnParts(), vision::SkylineOptions(),
                                                           vision::CompassOptions());
  return [path, horizon] {
    const WorkClock clock;
    for (int i = 0; i < path->both_ways(); ++i) horizon->Measure(path->Next());
    return clock.Taken(path->both_ways());
  };
}

flight::LoadedScenario Landing(const std::string& duration) {
  flight::LoadedScenario loaded =
      flight::LoadScenario("landing", {"seed=3", "criteria={}", "duration_s=" + duration});
  loaded.simulator.draw_beside = false;
  return loaded;
}

// Seconds of a flight, without its start.
Block LandingFlight() {
  auto loaded = std::make_shared<flight::LoadedScenario>(Landing("1"));
  return [loaded] {
    std::optional<WorkClock> clock;
    double from_s = 0, to_s = 0;
    WorkTimes taken;
    flight::RunOptions options;
    options.progress = [&](const records::LogRow& row) {
      if (!clock) {
        clock.emplace();
        from_s = row.now.t_s;
      }
      to_s = row.now.t_s;
      taken = clock->Taken(to_s - from_s);
      return true;
    };
    flight::RunFlight(*loaded, options);
    return taken;
  };
}

// From a scenario's name to the first frames of its flight.
Block StartOfAFlight() {
  return [] {
    const WorkClock clock;
    flight::RunFlight(Landing("0.1"), {});
    return clock.Taken(1);
  };
}

struct Maker {
  TimedWork work;
  Block (*make)();
};

const std::vector<Maker>& Makers() {
  static const std::vector<Maker> makers = {
      {{"pinhole, airfield", "frame", 10}, [] { return Frames("survey_airfield", "thesis_6mm", 5, 10); }},
      {{"mirror, airfield", "frame", 10},
       [] { return Frames("survey_airfield", "hyperbolic_mirror", 5, 8); }},
      {{"fisheye, airfield", "frame", 10}, [] { return Frames("survey_airfield", "fisheye", 5, 8); }},
      {{"mirror, landscape", "frame"}, [] { return Frames("attitude_2", "hyperbolic_mirror", 20, 4); }},
      {{"pad tracking", "frame", 10}, PadTracking},
      {{"loss of the pad", "loss"}, LossOfThePad},
      {{"skyline and compass", "frame"}, SkylineAndCompass},
      {{"landing", "second flown"}, LandingFlight},
      {{"start of a flight", "start"}, StartOfAFlight},
      {{kArithmetic, "loop"}, ArithmeticLoop},
      {{kMemory, "loop", 10}, MemoryLoop}};
  return makers;
}

}  // namespace

WorkClock::WorkClock() : processor_ms_(Now_ms(CLOCK_PROCESS_CPUTIME_ID)), wall_ms_(Now_ms(CLOCK_MONOTONIC)) {}

WorkTimes WorkClock::Taken(double pieces) const {
  return {Now_ms(CLOCK_PROCESS_CPUTIME_ID) - processor_ms_, Now_ms(CLOCK_MONOTONIC) - wall_ms_, pieces};
}

std::vector<TimedWork> AllTimedWork() {
  std::vector<TimedWork> all;
  for (const Maker& maker : Makers()) all.push_back(maker.work);
  return all;
}

Block PrepareWork(const std::string& name) {
  for (const Maker& maker : Makers())
    if (maker.work.name == name) return maker.make();
  throw InputError("bench timings", "there is no work '" + name + "'");
}

}  // namespace kestrel::bench
