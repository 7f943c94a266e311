// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "geometry/pose.h"
#include "vision/calibration/board/board_detector.h"
#include "vision/calibration/view_adjustment.h"
#include "vision/camera/camera_model.h"

// What a calibration starts from and what comes of it.
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
  // distortion that the images do not show (vision/calibration/distortion_terms.h); these stay 0. The covariance is (J^T J)^-1 times the
  // variance that the residuals show; where the errors of one image are alike, so much that this would say
  // too little, it is ClusteredCovariance (vision/calibration/view_adjustment.h), and a note says so.
  std::vector<int> free;
  Eigen::VectorXd sigma;       // of free
  Eigen::MatrixXd covariance;  // of free
  std::vector<CalibratedView> views;
  BoardShape board;  // offsets: empty where the images show the board to be as its file says
  int corners = 0, corners_not_used = 0;  // of the views that were used
  double rms_px = 0;                      // over all used corners
  double worst_uncertainty_px = 0;        // see vision/calibration/calibration_uncertainty.h
  double max_angle_seen_rad = 0;          // of a used corner from the axis
  std::vector<std::string> notes;         // what a user should know, in words
};

// The best camera of the model leaves more residual than is accepted.
struct PoorFit : InputError {
  using InputError::InputError;
};

}  // namespace kestrel::vision
