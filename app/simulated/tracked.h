// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "base/yaml/fields.h"
#include "mission/caption/caption.h"
#include "vision/camera/camera_model.h"
#include "vision/camera/views.h"
#include "vision/landmark/pad_tracker.h"
#include "vision/target/balloon_tracker.h"

// What `kestrel track` follows.
namespace kestrel::app {

using Corners = std::array<Eigen::Vector2d, 4>;

// The corners "x,y" of a landmark in an image, from the top left of its picture clockwise as it is seen from
// above. Those of no quadrangle are a mistake of --corners.
std::optional<Corners> ReadCorners(const std::vector<std::string>& texts, const std::optional<cv::Size>& size,
                                   Mistakes& mistakes);

class TrackedLandmark {
 public:
  static constexpr bool kByColour = false;

  // A camera that sees along its own axis. corners: in the first image. Where they are none of a plane before the
  // camera it is a mistake.
  TrackedLandmark(vision::PadReference reference, const vision::CameraModel& camera,
                  const std::optional<Corners>& corners, Mistakes& mistakes);

  static std::string Columns();      // of what follows frame and t_s in the table
  bool Track(const cv::Mat& image);  // whether it is seen
  std::string Row() const;           // of the last image
  std::string Sentence() const;
  void Draw(cv::Mat& bgr) const;
  std::vector<mission::Caption> Captions() const;

 private:
  vision::CameraModel camera_;
  vision::Pinhole view_;                      // the tracker's camera, of the same C
  std::optional<vision::ViewTable> to_view_;  // none: the image is the view
  vision::PadTracker tracker_;
  std::optional<Pose> X_CT_begin_;  // for the first image
  std::optional<vision::PadObservation> seen_;
};

struct BallParameters {
  vision::ColourRange colour;
  double diameter_m = 0.5;
};

inline void Fields(FieldVisitor& v, BallParameters& p) {
  Fields(v, p.colour);
  v({"diameter_m", "true diameter of the ball"}, p.diameter_m, 0.01, 20.0);
}

// The words "key=value" of --ball.
BallParameters ReadBall(const std::vector<std::string>& words, Mistakes& mistakes);

class TrackedBall {
 public:
  static constexpr bool kByColour = true;

  TrackedBall(const BallParameters& ball, const vision::CameraModel& camera);

  static std::string Columns();
  bool Track(const cv::Mat& bgr);
  std::string Row() const;
  std::string Sentence() const;
  void Draw(cv::Mat& bgr) const;
  std::vector<mission::Caption> Captions() const;

 private:
  vision::CameraModel camera_;
  double diameter_m_;
  vision::BalloonTracker tracker_;
  std::optional<vision::BalloonObservation> seen_;
};

}  // namespace kestrel::app
