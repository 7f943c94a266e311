// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <complex>
#include <functional>
#include <vector>

// How far a loop that servoes a place by velocities (control/law/pbvs.h) is from swinging, by the answer of the
// autopilot to a velocity as it was measured. What the sight is late is not reckoned: the estimators make up
// for it.
namespace kestrel::control {

// An answer to a step of the velocity asked for, as a share of the step, at even times from 0, when it was
// asked for, until it has settled.
struct VelocityStep {
  double dt_s = 0;
  std::vector<double> answer;

  // Its transfer function at j w, the Fourier transform of its derivative. w: rad/s.
  std::complex<double> At(double w) const;
  // The mean of its impulse response, as in control/estimate/velocity_lag.h.
  double Late_s() const;
};

struct ServoLoop {
  double lambda_per_s = 0;
  double reckoned_s = 0;  // of the lateness, by control/estimate/late_following.h; 0: none
  double hold_s = 0;      // for which a command stands: the time between two frames
};

// Of the place by the velocities, at j w: with the way to come X(s) = (1 - exp(-s L)) / s and the hold Z(s) = (1 -
// exp(-s T)) / (s T) it is lambda / (1 + lambda X) H Z / s.
std::complex<double> OpenLoop(const VelocityStep& answer, const ServoLoop& loop, double w);

// A margin that nothing limits is infinite.
struct LoopMargins {
  double gain = 0;  // by which times as much it would swing; below 1: by which times as little it would not
  double phase_deg = 0;        // by which it may turn, either way; negative: it swings
  double delay_s = 0;          // more dead time with which it would swing; negative: it swings
  double crossover_rad_s = 0;  // where the gain is 1, the lowest
};

// Of an open loop that integrates once and is stable otherwise, by a scan of the frequencies from low to high,
// rad/s, in which its gain must fall through 1.
LoopMargins Margins(const std::function<std::complex<double>(double)>& open_loop, double low = 0.01,
                    double high = 60);

}  // namespace kestrel::control
