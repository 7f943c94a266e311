// SPDX-License-Identifier: Apache-2.0
#include "scenarios/check_image.h"

#include <fmt/format.h>

namespace kestrel {
namespace {

constexpr double kRounding_s = 1e-9;

void CheckTiming(const ImageParameters& p, int rows, const std::string& where, Mistakes& mistakes) {
  const double exposure_s = LongestExposure_s(p), readout_s = LongestReadout_s(p, rows);
  const double period_s = 1 / p.rate_hz, needed_s = (exposure_s + readout_s) / 2;
  const bool automatic = exposure_s > 0 && p.auto_exposure.target_grey > 0;
  if (exposure_s > period_s + kRounding_s) {
    mistakes.Add(
        where, automatic ? "image.auto_exposure.longest_s" : "image.exposure.time_s",
        fmt::format("an exposure of up to {:g} s does not fit into the period of {:g} s; valid: that much "
                    "at most, or a lower image.rate_hz",
                    exposure_s, period_s));
  }
  if (readout_s > period_s + kRounding_s) {
    mistakes.Add(
        where, "image.exposure.line_s",
        fmt::format("{} rows take up to {:g} s to read out, longer than the period of {:g} s; valid: {:g} "
                    "at most, or a lower image.rate_hz",
                    rows, readout_s, period_s, period_s / (rows - 1) - p.scatter.line_s));
  }
  if (p.latency_s < needed_s - kRounding_s) {
    mistakes.Add(
        where, "image.latency_s",
        fmt::format("{} ends before the image is read out: it counts from the middle of an exposure of up "
                    "to {:g} s and a readout of up to {:g} s; valid: {:g} or more",
                    p.latency_s, exposure_s, readout_s, needed_s));
  }
}

void CheckAutoExposure(const ImageParameters& p, const std::string& where, Mistakes& mistakes) {
  const AutoExposureParameters& a = p.auto_exposure;
  if (a.target_grey > 0 && a.longest_s <= a.shortest_s) {
    mistakes.Add(where, "image.auto_exposure.longest_s",
                 fmt::format("{} is not above shortest_s = {}", a.longest_s, a.shortest_s));
  }
}

void CheckFaults(const ImageParameters& p, const std::string& where, Mistakes& mistakes) {
  for (std::size_t i = 0; i < p.faults.size(); ++i) {
    const CameraFault& f = p.faults[i];
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

void CheckImage(const ImageParameters& image, int rows, const std::string& where, Mistakes& mistakes) {
  CheckTiming(image, rows, where, mistakes);
  CheckAutoExposure(image, where, mistakes);
  CheckFaults(image, where, mistakes);
}

void CheckMount(const CameraMount& mount, const std::string& where, Mistakes& mistakes) {
  for (std::size_t i = 0; i < mount.vibration.size(); ++i) {
    const VibrationBand& band = mount.vibration[i];
    if (band.until_hz < band.from_hz) {
      mistakes.Add(where, fmt::format("mount.vibration.{}.until_hz", i),
                   fmt::format("{} is below from_hz = {}", band.until_hz, band.from_hz));
    }
  }
}

}  // namespace kestrel
