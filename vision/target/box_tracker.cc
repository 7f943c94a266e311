// SPDX-License-Identifier: Apache-2.0
#include "vision/target/box_tracker.h"

#include <memory>
#include <opencv2/tracking.hpp>

namespace kestrel::vision {

namespace {

template <class Peer>
BoxTracker PeerBoxes(const char* name) {
  const auto peer = std::make_shared<cv::Ptr<Peer>>();
  BoxTracker tracker;
  tracker.name = name;
  tracker.start = [peer](const cv::Mat& bgr, const cv::Rect2d& box) {
    try {
      *peer = Peer::create();
      (*peer)->init(bgr, cv::Rect(box) & cv::Rect(0, 0, bgr.cols, bgr.rows));
      return true;
    } catch (const cv::Exception&) {
      peer->reset();
      return false;
    }
  };
  tracker.track = [peer](const cv::Mat& bgr) -> std::optional<cv::Rect2d> {
    if (peer->empty()) return {};
    try {
      cv::Rect box;
      if (!(*peer)->update(bgr, box)) return {};
      return cv::Rect2d(box);
    } catch (const cv::Exception&) {
      return {};
    }
  };
  return tracker;
}

}  // namespace

BoxTracker CamShiftBoxes(const ColourModel& model, const ColourTrackerOptions& options) {
  const auto tracker = std::make_shared<ColourTracker>(model, options);
  return {"CamShift",
          [tracker, model, options](const cv::Mat& bgr, const cv::Rect2d& box) {
            *tracker = ColourTracker(model, options);
            tracker->Correct(box);
            return tracker->Track(bgr).target.has_value();
          },
          [tracker](const cv::Mat& bgr) -> std::optional<cv::Rect2d> {
            const auto target = tracker->Track(bgr).target;
            return target ? std::optional(target->box) : std::nullopt;
          }};
}

BoxTracker BalloonBoxes(const ColourModel& model, const CameraModel& camera,
                        const BalloonTrackerOptions& options) {
  const auto tracker = std::make_shared<BalloonTracker>(model, camera, options);
  return {"CamShift and outline",
          [tracker, model, camera, options](const cv::Mat& bgr, const cv::Rect2d& box) {
            *tracker = BalloonTracker(model, camera, options);
            tracker->Begin(box);
            return tracker->Track(bgr).cone.has_value();
          },
          [tracker, camera](const cv::Mat& bgr) -> std::optional<cv::Rect2d> {
            const auto cone = tracker->Track(bgr).cone;
            return cone ? OutlineBox(camera, *cone) : std::nullopt;
          }};
}

BoxTracker KcfBoxes() { return PeerBoxes<cv::TrackerKCF>("KCF"); }
BoxTracker CsrtBoxes() { return PeerBoxes<cv::TrackerCSRT>("CSRT"); }

double Overlap(const cv::Rect2d& a, const cv::Rect2d& b) {
  const double both = (a & b).area();
  const double all = a.area() + b.area() - both;
  return all > 0 ? both / all : 0;
}

}  // namespace kestrel::vision
