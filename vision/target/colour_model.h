// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <cstdint>
#include <opencv2/core.hpp>

namespace kestrel {

// A target's colour by numbers: hues of the usual circle (red 0, green 120, blue 240 degrees), saturation and
// value from 0 to 1. What is grey or dark has no hue worth the name, hence the gates.
struct ColourRange {
  double hue_deg = 0;
  double hue_half_width_deg = 15;
  double least_saturation = 0.45;
  double least_value = 0.12;
  double most_value = 1;
};

template <class Visitor>
void Fields(Visitor& v, ColourRange& r) {
  v("hue_deg", r.hue_deg, -360.0, 360.0);
  v("hue_half_width_deg", r.hue_half_width_deg, 1.0, 90.0);
  v("least_saturation", r.least_saturation, 0.0, 1.0);
  v("least_value", r.least_value, 0.0, 1.0);
  v("most_value", r.most_value, 0.0, 1.0);
}

enum class LessonState {
  kLearnt,
  kBadPatch,         // not CV_8UC3 with a CV_8UC1 mask of its size
  kTooFewPixels,     // fewer than 30 in the patch
  kTooGrey,          // less than half of the patch has a hue
  kTooManyColours,   // the hues of the patch spread over more than half of the circle
  kLikeSurroundings  // more than half of what surrounds the patch matches as well
};
const char* NameOf(LessonState state);

struct ColourLesson;

// The colour model of CamShift (Bradski 1998), thesis 5.4.1: a histogram of hues within gates of saturation
// and value, and its back-projection. Images are CV_8UC3 (blue, green, red).
class ColourModel {
 public:
  static constexpr int kBins = 256;  // of hue, all round

  explicit ColourModel(const ColourRange& range);

  // From a patch: the pixels of the image where the mask is not 0 (CV_8UC1). The others, if there are any,
  // are its surroundings, from which it has to differ.
  static ColourLesson Learn(const cv::Mat& bgr, const cv::Mat& mask);

  // How well each pixel's colour belongs to the target, 0 to 255: CV_8UC1, of the image's size.
  void BackProject(const cv::Mat& bgr, cv::Mat& weights) const;
  // The share of the weights that match, i.e. are more than half of the most there can be.
  static double Matched(const cv::Mat& weights);

  const std::array<std::uint8_t, kBins>& histogram() const { return hue_; }
  int least_saturation() const { return least_saturation_; }  // of 255
  int least_value() const { return least_value_; }
  int most_value() const { return most_value_; }

 private:
  ColourModel() = default;

  std::array<std::uint8_t, kBins> hue_{};
  int least_saturation_ = 0, least_value_ = 0, most_value_ = 255;
};

struct ColourLesson {
  LessonState state = LessonState::kBadPatch;
  ColourModel model{ColourRange{}};  // of use only if learnt
};

}  // namespace kestrel
