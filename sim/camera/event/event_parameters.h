// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/yaml/fields.h"

namespace kestrel::sim {

// A camera whose pixels tell when they have become brighter or darker, each by itself. Brightness is the
// logarithm of the light, of which white is 1. Everything that a real one adds is off.
struct EventCameraParameters {
  double threshold_on = 0.2, threshold_off = 0.2;  // change of brightness of an event
  double threshold_spread = 0;                     // standard deviation between pixels, of both
  double refractory_s = 0;
  double leak_hz = 0;
  double shot_hz = 0;
  double log_eps = 0.001;
  double largest_move_px = 0.5;
  double largest_change = 0;
};

inline void Fields(FieldVisitor& v, EventCameraParameters& p) {
  v({"threshold_on", "rise of the log of the light that makes an event"}, p.threshold_on, 0.01, 5.0);
  v({"threshold_off", "fall of the log of the light that makes an event"}, p.threshold_off, 0.01, 5.0);
  v({"threshold_spread",
     "standard deviation of the thresholds between pixels, drawn by the seed; none is below 0.01"},
    p.threshold_spread, 0.0, 1.0);
  v({"refractory_s", "time after an event for which its pixel gives none"}, p.refractory_s, 0.0, 1.0);
  v({"leak_hz", "rate at which a pixel on which nothing changes gives events that it has become brighter"},
    p.leak_hz, 0.0, 100.0);
  v({"shot_hz", "rate at which each pixel gives events by chance, as many of either sign"}, p.shot_hz, 0.0,
    1000.0);
  v({"log_eps", "light that is added before the logarithm, of which white is 1"}, p.log_eps, 1e-6, 1.0);
  v({"largest_move_px",
     "how far what is seen may move in the image between two samples of the light; less is slower and finer"},
    p.largest_move_px, 0.01, 10.0);
  v({"largest_change",
     "by how many thresholds a pixel's brightness may change between two samples, down to samples 20 us "
     "apart; 0: by any"},
    p.largest_change, 0.0, 100.0);
}

}  // namespace kestrel::sim
