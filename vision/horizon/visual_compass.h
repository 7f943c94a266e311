// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <variant>
#include <vector>

#include "vision/horizon/panorama_strip.h"
#include "vision/horizon/strip_match.h"

namespace kestrel::vision {

struct CompassOptions {
  double new_keyframe_below = 0.75;  // likeness to all that are known
  double lost_below = 0.35;
  double ambiguous_share = 0.93;  // a second turn that is nearly as alike, by this share of the first
  int max_keyframes = 48;
  int matched_each_frame = 6;
};

struct CompassHeading {
  double turned = 0;    // since the first image, rad, clockwise seen from above, over any number of turns
  double variance = 0;  // rad^2
  double likeness = 0;  // to the keyframe, -1 to 1
  int keyframe = 0;     // that it was compared with
  bool learnt = false;  // this image became a keyframe
};

enum class NoHeading {
  kNoVertical,      // no "down" was given
  kTooLittle,       // of the surroundings in view
  kNothingMatches,  // no keyframe is like this image
  kAmbiguous,       // the surroundings repeat themselves
};
const char* NameOf(NoHeading reason);
using CompassResult = std::variant<CompassHeading, NoHeading>;

// Heading from what stands round about, thesis 6.3.4. Deviations: the panorama stands by the measured
// vertical, so that tilt does not bend it; and each image is compared with keyframes and not with the one
// before, so that errors do not add up: they grow only from keyframe to keyframe, on the way to places that
// were never seen, and go back as the aircraft does.
class VisualCompass {
 public:
  VisualCompass(const CameraModel& camera, const Eigen::Matrix3d& R_BC, const cv::Mat& forbidden,
                const CompassOptions& options);

  // image: CV_8UC3 of the camera's size. expected: what something else says; only turns near it are looked
  // for, and what becomes a keyframe keeps the mean of both headings by their variances, so that it must be
  // told without this compass, or with it as a filter with gyros does, over a longer time.
  struct Expected {
    double turn = 0;      // rad
    double sigma = 0.05;  // rad
  };
  CompassResult Turn(const cv::Mat& image, const std::optional<Eigen::Vector3d>& down_C,
                     const std::optional<Expected>& expected = {});

  int keyframes() const { return static_cast<int>(keyframes_.size()); }
  const PanoramaStrip& last_strip() const { return last_strip_; }
  void Forget();

 private:
  struct Keyframe {
    StripReference reference;
    double heading = 0, variance = 0;
  };
  struct Guess {
    std::size_t keyframe = 0;
    double turn = 0, likeness = -1;
    bool ambiguous = false;
  };
  Guess Compare(const Keyframe& k, const StripReference& now, const std::optional<Expected>& expected) const;
  std::vector<std::size_t> ToCompare();
  void Learn(const StripReference& now, double heading, double variance);

  StripMaker maker_;
  CompassOptions options_;
  std::vector<Keyframe> keyframes_;
  std::optional<Keyframe> last_;  // the image before: if no keyframe is like this one, it may be
  std::size_t current_ = 0, next_other_ = 0;
  double total_ = 0;
  PanoramaStrip last_strip_;
};

}  // namespace kestrel::vision
