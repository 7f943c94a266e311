// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>

#include "base/yaml/fields.h"
#include "vision/target/colour_model.h"

namespace kestrel::vision {

struct ColourTrackerOptions {
  double min_diameter_px = 6;
  double min_roundness = 0.5;
  double rival_share = 0.5;
  double max_matched = 0.3;
  double close_share = 0.5;
  double min_confidence = 0.3;
  double return_factor = 2;
  int forget_frames = 60;
};

inline void Fields(FieldVisitor& v, ColourTrackerOptions& o) {
  v(Renamed("min_diameter_px", "least_diameter_px", "minimum diameter of a target"), o.min_diameter_px, 3.0,
    200.0);
  v(Renamed(
        "min_roundness", "least_roundness",
        "minimum share of its box's ellipse that a newly found target fills, and short side over long side"),
    o.min_roundness, 0.0, 1.0);
  v({"rival_share",
     "area over that of the best candidate from which a second one makes the target ambiguous"},
    o.rival_share, 0.0, 1.0);
  v(Renamed("max_matched", "most_matched",
            "share of the image that matches the colour beyond which the colour tells nothing"),
    o.max_matched, 0.01, 1.0);
  v({"close_share", "share of the image that the target's box covers beyond which it is too close"},
    o.close_share, 0.05, 1.0);
  v(Renamed("min_confidence", "least_confidence",
            "minimum density of matching pixels inside a tracked target less that around it, 0 to 1"),
    o.min_confidence, 0.0, 1.0);
  v({"return_factor",
     "maximum factor in size by which a lost target may have grown or shrunk when it is found again"},
    o.return_factor, 1.0, 100.0);
  v({"forget_frames",
     "number of images after which a lost target is forgotten and one of any size is accepted"},
    o.forget_frames, 0, 100000);
}

enum class TrackState {
  kSearching,       // not seen so far, or forgotten
  kTracked,         // seen, whole
  kAmbiguous,       // two alike; there is a target only if one of them continues what was tracked
  kTooClose,        // it fills the image: its centre and its size are unknown
  kAtEdge,          // cut by the edge of the image: its centre and its size are those of what is seen of it
  kLost,            // seen before, not now
  kMatchesTooMuch,  // the colour is that of much of the image
  kBadImage         // not CV_8UC3, or empty
};
const char* NameOf(TrackState state);

// The coloured area, as CamShift gives it, px.
struct ColourTarget {
  // The first pixel's centre is (0, 0); to a whole or half pixel of what was searched, as OpenCV rounds.
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  double diameter_px = 0;  // mean axis of the ellipse of its second moments
  cv::Rect2d box;          // of that ellipse within the image, whose first pixel spans 0 to 1, as in OpenCV
  double confidence = 0;   // density of the back-projection inside less that around it, 0 to 1
};

struct ColourTrack {
  TrackState state = TrackState::kSearching;
  std::optional<ColourTarget> target;
};

// CamShift (Bradski 1998; OpenCV's) on the back-projection of a target's colour, thesis 5.4.1, which begins
// by itself: whole image and the largest sound blob while there is nothing to track, then a window around the
// last place. There is never an old place: no target, no answer.
class ColourTracker {
 public:
  ColourTracker(const ColourModel& model, const ColourTrackerOptions& options);

  ColourTrack Track(const cv::Mat& bgr);  // CV_8UC3 (blue, green, red)
  // Where the target was in the last image, by whoever knows better: the fit of its outline, so that CamShift
  // does not creep over what has the same colour; or, before the first image, the one who points at it.
  void Correct(const cv::Rect2d& box);

  // What is tracked is not the target, by whoever looked closer: the next largest blob is tried in its place,
  // and after the last the first again.
  void Refuse();

  const ColourModel& model() const { return model_; }
  // What the last Track() looked at, for the overlay, px.
  const cv::Rect& window() const { return window_; }

 private:
  struct Search {
    TrackState state = TrackState::kLost;
    std::optional<cv::Rect2d> box;
  };
  Search Find(const cv::Mat& bgr);
  std::optional<ColourTarget> Follow(const cv::Mat& bgr, const cv::Rect2d& box, bool& rival);
  TrackState Classify(const cv::Mat& bgr, const ColourTarget& target, bool rival) const;

  ColourModel model_;
  ColourTrackerOptions options_;
  cv::Rect window_;
  std::optional<cv::Rect2d> box_;                      // of the target in the last image, if it was tracked
  Eigen::Vector2d step_px_ = Eigen::Vector2d::Zero();  // its motion from image to image
  std::optional<cv::Rect2d> remembered_;               // where it was seen last, and its size
  int missing_frames_ = 0;
  std::size_t refused_ = 0;  // so many of the largest blobs
};

}  // namespace kestrel::vision
