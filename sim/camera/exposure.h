// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "base/yaml/fields.h"

namespace kestrel::sim {

// When the pixels gather light. The bytes of a rendered image are what the sensor sees in time_s at a gain of
// 1: time_s alone changes what is smeared, not how bright it is.
struct ExposureParameters {
  double time_s = 0;  // of a row; 0: an instant, nothing is smeared
  double line_s = 0;  // from a row's exposure to that of the row below; 0: global shutter
  int samples = 4;    // instants of the exposure at which light is gathered, while time_s > 0
};

inline void Fields(FieldVisitor& v, ExposureParameters& p) {
  v({"time_s", "exposure time of a row; 0: an instant, without motion blur"}, p.time_s, 0.0, 1.0);
  v({"line_s", "delay from the exposure of a row to that of the next one; 0: global shutter"}, p.line_s, 0.0,
    0.01);
  v({"samples", "instants of the exposure at which the scene is rendered, while time_s is over 0"}, p.samples,
    1, 256);
}

// Keeps the mean of the image at a level, by the time of the exposure as far as that goes, beyond it by the
// gain. With a time_s of 0 there is no time to change: an iris takes its place where less light is wanted.
struct AutoExposureParameters {
  double target_grey = 0;  // mean of the pixels that the lens lights, 0 to 255; 0: off
  double lag_s = 0.25;     // the logarithm of the exposure nears its goal with this time constant
  double shortest_s = 2e-5, longest_s = 0.02;  // time of the exposure
  double highest_gain = 16;                    // and 1 / it is the smallest iris
};

inline void Fields(FieldVisitor& v, AutoExposureParameters& p) {
  v({"target_grey", "mean grey level, 0 to 255, that auto-exposure keeps; 0: it is off"}, p.target_grey, 0.0,
    250.0);
  v({"lag_s", "time constant with which the logarithm of the exposure follows"}, p.lag_s, 0.0, 60.0);
  v({"shortest_s", "shortest exposure time that auto-exposure sets"}, p.shortest_s, 1e-6, 1.0);
  v({"longest_s", "longest exposure time that auto-exposure sets"}, p.longest_s, 1e-6, 1.0);
  v({"highest_gain", "highest gain that auto-exposure sets; its inverse is the smallest iris"},
    p.highest_gain, 1.0, 1000.0);
}

struct ExposureSetting {
  double time_s = 0;
  double light = 1;  // gathered, as a multiple of what the rendered image holds
  double gain = 1;   // from electrons to grey levels: of the signal and of its noise
};

// The setting of each frame, from how bright the frames before it were. Frames are metered in their order;
// without a target_grey the setting stays as it began.
class ExposureControl {
 public:
  // gain: that of the first frame. gamma: of the image (see ImageParameters).
  ExposureControl(const ExposureParameters& exposure, const AutoExposureParameters& automatic, double gain,
                  double gamma);

  bool automatic() const { return automatic_.target_grey > 0; }
  ExposureSetting setting() const;
  void Meter(double mean_grey, double t_s);  // of a frame that was exposed with setting() at t_s

 private:
  ExposureParameters exposure_;
  AutoExposureParameters automatic_;
  double gamma_;
  double lowest_, highest_;  // of exposure_value_
  double exposure_value_;    // light times gain
  std::optional<double> metered_s_;
};

}  // namespace kestrel::sim
