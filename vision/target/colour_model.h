// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>

#include "base/yaml/fields.h"

namespace kestrel::vision {

// A target's colour by numbers.
struct ColourRange {
  double hue_deg = 0;
  double hue_half_width_deg = 15;
  double min_saturation = 0.45;
  double min_value = 0.12;
  double max_value = 1;
};

inline void Fields(FieldVisitor& v, ColourRange& r) {
  v({"hue_deg", "middle of the range of hues: red 0, green 120, blue 240"}, r.hue_deg, -360.0, 360.0);
  v({"hue_half_width_deg", "half the width of the range of hues"}, r.hue_half_width_deg, 1.0, 90.0);
  v(Renamed("min_saturation", "least_saturation",
            "minimum saturation, 0 to 1: below it a pixel is too grey to have a hue"),
    r.min_saturation, 0.0, 1.0);
  v(Renamed("min_value", "least_value",
            "minimum value (brightness) of a pixel, 0 to 1: below it a pixel is too dark to have a hue"),
    r.min_value, 0.0, 1.0);
  v(Renamed("max_value", "most_value", "maximum value (brightness) of a pixel, 0 to 1"), r.max_value, 0.0,
    1.0);
}

enum class TrainingState {
  kTrained,
  kBadPatch,         // not CV_8UC3 with a CV_8UC1 mask of its size
  kTooFewPixels,     // fewer than 30 in the patch
  kTooGrey,          // less than half of the patch has a hue
  kTooManyColours,   // the hues of the patch spread over more than half of the circle
  kLikeSurroundings  // more than half of what surrounds the patch matches as well
};
const char* NameOf(TrainingState state);

struct TrainedColour;

// The colour model of CamShift (Bradski 1998), thesis 5.4.1: a histogram of hues within gates of saturation
// and value, and its back-projection. Images are CV_8UC3 (blue, green, red).
class ColourModel {
 public:
  static constexpr int kBins = 256;  // of hue, all round

  explicit ColourModel(const ColourRange& range);

  // From a patch: the pixels of the image where the mask is not 0 (CV_8UC1). The others, if there are any,
  // are its surroundings, from which it has to differ.
  static TrainedColour Train(const cv::Mat& bgr, const cv::Mat& mask);

  // How well each pixel's colour belongs to the target, 0 to 255: CV_8UC1, of the image's size.
  void BackProject(const cv::Mat& bgr, cv::Mat& weights) const;
  // The share of the weights that match, i.e. are more than half of the most there can be.
  static double Matched(const cv::Mat& weights);

  const std::array<std::uint8_t, kBins>& histogram() const { return hue_; }
  int min_saturation() const { return min_saturation_; }  // of 255
  int min_value() const { return min_value_; }
  int max_value() const { return max_value_; }

 private:
  ColourModel() = default;

  std::array<std::uint8_t, kBins> hue_{};
  int min_saturation_ = 0, min_value_ = 0, max_value_ = 255;
};

struct TrainedColour {
  TrainingState state = TrainingState::kBadPatch;
  ColourModel model{ColourRange{}};  // of use only if learnt
};

}  // namespace kestrel::vision
