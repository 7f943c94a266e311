// SPDX-License-Identifier: Apache-2.0
#include "flight/simulated/check/check_image.h"

#include <fmt/format.h>

#include <optional>

#include "geometry/tait_bryan.h"

namespace kestrel::flight {
namespace {

constexpr double kRounding_s = 1e-9;
constexpr double kMinLit = 1e-3;  // of the pixels: with less there is no image

void CheckTiming(const sim::ImageParameters& p, int rows, const Place& where, Mistakes& mistakes) {
  const double exposure_s = sim::LongestExposure_s(p), readout_s = sim::LongestReadout_s(p, rows);
  const double period_s = 1 / p.rate_hz, needed_s = (exposure_s + readout_s) / 2;
  const bool automatic = exposure_s > 0 && p.auto_exposure.target_grey > 0;
  if (exposure_s > period_s + kRounding_s) {
    mistakes.Add(where, automatic ? "image.auto_exposure.longest_s" : "image.exposure.time_s",
                 fmt::format("an exposure of up to {:g} s does not fit into the period of {:g} s", exposure_s,
                             period_s),
                 "valid: that much at most, or a lower image.rate_hz");
  }
  if (readout_s > period_s + kRounding_s) {
    mistakes.Add(where, "image.exposure.line_s",
                 fmt::format("{} rows take up to {:g} s to read out, longer than the period of {:g} s", rows,
                             readout_s, period_s),
                 fmt::format("valid: {:g} at most, or a lower image.rate_hz",
                             period_s / (rows - 1) - p.scatter.line_s));
  }
  if (p.latency_s < needed_s - kRounding_s) {
    mistakes.Add(where, "image.latency_s",
                 fmt::format("{} ends before the image is read out: it counts from the middle of an exposure "
                             "of up to {:g} s and a readout of up to {:g} s",
                             p.latency_s, exposure_s, readout_s),
                 fmt::format("valid: {:g} or more", needed_s));
  }
}

// The pixels to which light comes; none where nothing can keep it off.
std::optional<int> LitPixels(const sim::LensParameters& lens, const vision::CameraModel& camera) {
  const cv::Mat shade = sim::Shade(lens, camera);
  if (shade.empty()) return std::nullopt;
  int lit = 0;
  for (int y = 0; y < shade.rows; ++y) {
    for (int x = 0; x < shade.cols; ++x)
      lit += shade.at<float>(y, x) > 0 && vision::Ray(camera, Eigen::Vector2d(x, y)).has_value();
  }
  return lit;
}

void CheckLight(const sim::LensParameters& lens, const vision::CameraModel& camera, const Place& where,
                Mistakes& mistakes) {
  const int pixels = vision::WidthPx(camera) * vision::HeightPx(camera);
  const auto dark = [&](const std::optional<int>& lit) { return lit && *lit < kMinLit * pixels; };
  const auto lit = LitPixels(lens, camera);
  if (!dark(lit)) return;
  sim::LensParameters rim, reflection;
  rim.rim_px = lens.rim_px, reflection.reflection_deg = lens.reflection_deg;
  const std::string left = fmt::format("leaves light to {} of {} pixels", *lit, pixels);
  if (dark(LitPixels(rim, camera))) {
    const Eigen::VectorXd numbers = vision::Parameters(camera);
    mistakes.Add(where, "image.lens.rim_px",
                 fmt::format("{} {}: it is the radius in pixels about the principal point ({:g}, {:g}) of an "
                             "image of {} x {} px",
                             lens.rim_px, left, numbers[2], numbers[3], vision::WidthPx(camera),
                             vision::HeightPx(camera)),
                 "valid: 0 for no rim, or more");
  } else if (dark(LitPixels(reflection, camera))) {
    mistakes.Add(where, "image.lens.reflection_deg",
                 fmt::format("{} {}: the lens sees to {:.4g} deg from its axis", lens.reflection_deg, left,
                             Degrees(vision::MaxAngle(camera))),
                 "valid: less than that");
  } else {
    mistakes.Add(
        where, "image.lens",
        fmt::format("vignetting, rim and reflection together leave light to {} of {} pixels", *lit, pixels));
  }
}

void CheckAutoExposure(const sim::ImageParameters& p, const Place& where, Mistakes& mistakes) {
  const sim::AutoExposureParameters& a = p.auto_exposure;
  if (a.target_grey > 0 && a.longest_s <= a.shortest_s) {
    mistakes.Add(where, "image.auto_exposure.longest_s",
                 fmt::format("{} is not above shortest_s = {}", a.longest_s, a.shortest_s));
  }
}

void CheckFaults(const sim::ImageParameters& p, const Place& where, Mistakes& mistakes) {
  for (std::size_t i = 0; i < p.faults.size(); ++i) {
    const sim::CameraFault& f = p.faults[i];
    const std::string key = fmt::format("image.faults.{}.", i);
    if (f.until_s <= f.from_s) {
      mistakes.Add(where, key + "until_s", fmt::format("{} is not after from_s = {}", f.until_s, f.from_s));
    }
    if (f.type == "slow" && f.rate_hz >= p.rate_hz) {
      mistakes.Add(where, key + "rate_hz",
                   fmt::format("{} is not slower than image.rate_hz = {}", f.rate_hz, p.rate_hz));
    }
  }
}

}  // namespace

void CheckImage(const sim::ImageParameters& image, const vision::CameraModel* camera, const Place& where,
                Mistakes& mistakes) {
  CheckTiming(image, camera ? vision::HeightPx(*camera) : 1, where, mistakes);
  if (camera) CheckLight(image.lens, *camera, where, mistakes);
  CheckAutoExposure(image, where, mistakes);
  CheckFaults(image, where, mistakes);
}

void CheckMount(const vision::CameraMount& mount, const Place& where, Mistakes& mistakes) {
  for (std::size_t i = 0; i < mount.vibration.size(); ++i) {
    const vision::VibrationBand& band = mount.vibration[i];
    if (band.until_hz < band.from_hz) {
      mistakes.Add(where, fmt::format("mount.vibration.{}.until_hz", i),
                   fmt::format("{} is below from_hz = {}", band.until_hz, band.from_hz));
    }
  }
}

}  // namespace kestrel::flight
