// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <opencv2/core.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "geometry/pose.h"
#include "vision/calibration/board.h"
#include "vision/calibration/board_detector.h"
#include "vision/camera/camera_model.h"

namespace kestrel::vision {

// What one image shows of the board.
struct BoardView {
  std::string name;  // of the image, for messages
  std::vector<BoardCorner> corners;
};

// A corner beside its place by the calibration.
struct CornerResidual {
  int index = 0;
  Eigen::Vector2d pixel, error_px;  // error: projected less seen; NaN if the camera cannot see it there
  bool used = true;                 // no: too far off to be noise
};

struct CalibratedView {
  std::string name;
  std::string left_out;      // why, in words; empty: it was used
  std::optional<Pose> X_CT;  // of the board
  double rms_px = 0;         // of the distances of the used corners, root mean square
  std::vector<CornerResidual> corners;
};

struct Calibration {
  CameraModel camera;
  // What was found of Parameters(camera): everything but k3 and skew, which Kalibr's models do not have, and
  // the distortion of a unified camera that shows none; these stay 0. The covariance is (J^T J)^-1 times the
  // variance that the residuals show; where the errors of one image are alike, so much that this would say
  // too little, it is ClusteredCovariance (vision/calibration/view_adjustment.h), and a note says so.
  std::vector<int> free;
  Eigen::VectorXd sigma;       // of free
  Eigen::MatrixXd covariance;  // of free
  std::vector<CalibratedView> views;
  int corners = 0, corners_not_used = 0;  // of the views that were used
  double rms_px = 0;                      // over all used corners
  double worst_uncertainty_px = 0;        // of where a known ray is seen, over the image, one deviation
  double max_angle_seen_rad = 0;          // of a used corner from the axis
  std::vector<std::string> notes;         // what a user should know, in words
};

// The best camera of the model leaves more residual than is accepted.
struct PoorFit : InputError {
  using InputError::InputError;
};

inline constexpr double kAcceptedResidual_px = 0.5;  // usual among users of Kalibr and OpenCV

// Finds a camera of the same model and image size as `like`, whose numbers do not matter, and the pose of the
// board in every view. Starts from many focal lengths and shapes of the lens, so that it holds from 20 to 200
// degrees of view; large errors count less (Huber), and corners more than five deviations off are set aside,
// as is a view with more than a third of such; every view that is not used says why. Corners weigh by their
// covariance. Throws InputError, with what was seen, if the views cannot determine the camera: fewer than
// four different ones, boards all parallel or all in the middle of the image, a focal length that stays open
// by more than a twentieth (a fiftieth of a double sphere), more than a third of the views not of the camera
// of the others; PoorFit if more than accepted_px are left, root mean square, as when the board's numbers are
// wrong, the images are of two cameras, or the model is not of this lens.
Calibration Calibrate(const Board& board, std::span<const BoardView> views, const CameraModel& like,
                      double accepted_px = kAcceptedResidual_px);

// The views with their corners placed anew by a calibration of them (RefitBoard), for another one; views that
// it did not use stay as they are. images: those of the views.
std::vector<BoardView> Refit(const Board& board, std::span<const cv::Mat> images,
                             std::span<const BoardView> views, const Calibration& calibration);

// The models that a calibration can find, by name: "pinhole" (with the distortion of Brown and Conrady),
// "unified", "fisheye" (Kannala and Brandt), "double_sphere".
std::vector<std::string> CalibratedModels();
CameraModel CameraLike(const std::string& model, cv::Size image);

// The image in cells: which of them lie within the lens, and how many used corners each has. What is dark in
// all the images, grey ones of the views, is beyond the rim of the lens or mirror.
struct Coverage {
  int cols = 16, rows = 12;
  std::vector<bool> in_lens;  // by rows
  std::vector<int> corners;
  double share = 0;  // of the cells within the lens that have a corner
};
Coverage CoverageOf(const Calibration& calibration, std::span<const cv::Mat> images);

}  // namespace kestrel::vision
