// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "base/yaml/fields.h"

// Waves of a sea as a sum of regular ones, by a published spectrum.
namespace kestrel::sim {

struct WaveParameters {
  std::string spectrum = "none";
  int sea_state = 0;
  double height_m = 0, peak_s = 0;
  double from_deg = 0;
};

inline void Fields(FieldVisitor& v, WaveParameters& p) {
  v({"spectrum",
     "bretschneider: by height and period; jonswap: the same, narrower (peakedness 3.3); pierson_moskowitz: "
     "by "
     "height alone, of a fully developed sea"},
    p.spectrum, {"none", "bretschneider", "jonswap", "pierson_moskowitz"});
  v({"sea_state",
     "sea state from 2 to 6, which gives height_m and peak_s where they are 0; 0: they are given themselves"},
    p.sea_state, 0, 6);
  v({"height_m", "significant height: the mean of the highest third, from trough to crest"}, p.height_m, 0.0,
    15.0);
  v({"peak_s", "period at which the spectrum has its peak"}, p.peak_s, 0.0, 25.0);
  v({"from_deg", "where the waves come from, clockwise from north"}, p.from_deg, 0.0, 360.0);
}

// Significant height, m, and peak period, s, that go with a sea state from 2 to 6: the means of the heights, and
// the most probable modal periods of the open North Atlantic, as NATO has them (STANAG 4194; S. L. Bales, W. T. Lee
// and J. M. Voelker, "Standardized wave and wind environments for NATO operational areas", DTNSRDC/SPD-0919-01,
// 1981).
struct SeaState {
  double height_m = 0, peak_s = 0;
};
SeaState SeaStateOf(int sea_state);

// The density of the elevation's variance, m^2 s, over angular frequency, rad/s. m0, its integral, is the variance;
// the significant height is 4 sqrt(m0).
//   Bretschneider (ITTC, 15th conference, 1978): 5/16 H^2 wp^4 / w^5 exp(-5/4 (wp / w)^4)
//   Pierson and Moskowitz (J. Geophysical Research 69(24), 1964): 0.0081 g^2 / w^5 exp(-B / w^4), where
//     B = 4 * 0.0081 g^2 / H^2 makes H its significant height; peak at 0.401 sqrt(g / H)
//   JONSWAP (K. Hasselmann et al., Deutsche Hydrographische Zeitschrift A8(12), 1973): that of Bretschneider times
//     3.3^exp(-(w - wp)^2 / (2 s^2 wp^2)), s = 0.07 below the peak and 0.09 above, scaled so that H stays H
class WaveSpectrum {
 public:
  // parameters: with a spectrum, and a height and a period as far as it has them.
  explicit WaveSpectrum(const WaveParameters& parameters);

  double At(double w) const;
  double peak_rad_s() const { return peak_; }
  double height_m() const { return height_m_; }

 private:
  double height_m_, peak_;
  bool jonswap_;
  double scale_ = 1;
};

// One of the regular waves: elevation amplitude cos(w t + phase) where the ship is.
struct Wave {
  double amplitude_m = 0, w = 0, phase = 0;
};

// The spectrum in cells of equal width from half of its peak frequency to five times it, a wave each, anywhere in
// its cell, with the variance of the cell, scaled so that all have that of the whole spectrum.
std::vector<Wave> WavesOf(const WaveSpectrum& spectrum, std::uint64_t seed);

}  // namespace kestrel::sim
