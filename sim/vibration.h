// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <vector>

#include "config/fields.h"
#include "geometry/pose.h"

namespace kestrel {

// A band of frequencies in which a camera shakes on its mount, about and along each of its axes alike.
struct VibrationBand {
  double from_hz = 80, until_hz = 120;  // such as rotors make
  double rms_deg = 0;                   // of the angle about each axis
  double rms_mm = 0;                    // of the way along each axis
};

template <class Visitor>
void Fields(Visitor& v, VibrationBand& b) {
  v("from_hz", b.from_hz, 0.1, 500.0);
  v("until_hz", b.until_hz, 0.1, 500.0);
  v("rms_deg", b.rms_deg, 0.0, 5.0);
  v("rms_mm", b.rms_mm, 0.0, 50.0);
}

// How a mount shakes: on each axis some tones for each band, their frequencies and phases drawn by the seed.
// A function of time alone.
class Vibration {
 public:
  Vibration(const std::vector<VibrationBand>& bands, std::uint64_t seed);

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

}  // namespace kestrel
