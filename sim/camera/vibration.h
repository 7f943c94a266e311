// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string_view>
#include <vector>

#include "geometry/pose.h"
#include "vision/camera/camera_mount.h"

namespace kestrel::sim {

// How a mount, or the hand that holds it, shakes: on each axis some tones for each band, their frequencies
// and phases drawn by the seed. A function of time alone.
class Vibration {
 public:
  Vibration(const std::vector<vision::VibrationBand>& bands, std::uint64_t seed,
            std::string_view stream = "mount vibration");

  bool still() const { return tones_.empty(); }
  double highest_hz() const { return highest_hz_; }
  Pose At(double t_s) const;  // X_CS: of the shaken camera S in the camera C of a mount that is still

 private:
  struct Tone {
    int axis;  // 0 to 2: turns about x, y, z; 3 to 5: moves along them
    double amplitude, rad_s, phase;
  };
  std::vector<Tone> tones_;
  double highest_hz_ = 0;
};

}  // namespace kestrel::sim
