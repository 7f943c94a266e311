// SPDX-License-Identifier: Apache-2.0
#include "sim/camera/vibration.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/random.h"
#include "geometry/tait_bryan.h"

namespace kestrel::sim {
namespace {

constexpr int kTones = 8;  // of a band on an axis: enough that their sum is nearly Gaussian

}  // namespace

Vibration::Vibration(const std::vector<vision::VibrationBand>& bands, std::uint64_t seed,
                     std::string_view stream) {
  RandomStream random(seed, stream);
  for (const vision::VibrationBand& band : bands) {
    for (int axis = 0; axis < 6; ++axis) {
      const double rms = axis < 3 ? Radians(band.rms_deg) : 1e-3 * band.rms_mm;
      for (int i = 0; i < kTones; ++i) {
        const double hz = random.Uniform(band.from_hz, band.until_hz);
        const double phase = random.Uniform(0, 2 * std::numbers::pi);
        if (rms <= 0) continue;
        tones_.push_back({axis, rms * std::sqrt(2.0 / kTones), 2 * std::numbers::pi * hz, phase});
        highest_hz_ = std::max(highest_hz_, hz);
      }
    }
  }
}

Pose Vibration::At(double t_s) const {
  Eigen::Matrix<double, 6, 1> shift = Eigen::Matrix<double, 6, 1>::Zero();
  for (const Tone& tone : tones_)
    shift[tone.axis] += tone.amplitude * std::sin(tone.rad_s * t_s + tone.phase);
  return {ExpRotation(shift.head<3>()), shift.tail<3>()};
}

}  // namespace kestrel::sim
