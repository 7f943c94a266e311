// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <limits>
#include <optional>
#include <vector>

#include "geometry/pose.h"
#include "vision/camera/camera_model.h"

// One camera and the poses of one board before it, adjusted together to what was seen. Levenberg-Marquardt on
// the normal equations with the poses eliminated (Schur's complement), a small matter here. The usual solver,
// Ceres, is linked with GPL parts of SuiteSparse in Debian, so this program may not link it.
namespace kestrel::vision {

struct SeenPoint {
  Eigen::Vector3d p_T;  // on the board, m
  Eigen::Vector2d pixel;
  Eigen::Matrix2d whiten;  // makes the error of the pixel one of unit deviation along each axis
  int corner = 0;          // of the board, its number
};

// How far a board's corners are from where its file has them: printed unevenly, or not flat. It is the same
// in all views.
struct BoardShape {
  std::vector<Eigen::Vector3d> offsets_m;  // in T, by number; empty: as the file says, and held so
  // What is expected of them, one deviation in the plane of the board and out of it. It also holds what no
  // view tells: where the board lies, how it is turned, how large it is.
  double in_plane_m = 0, out_of_plane_m = 0;
};

struct AdjustedView {
  Pose X_CT;
  std::vector<SeenPoint> points;
};

struct Adjustment {
  CameraModel camera;
  std::vector<AdjustedView> views;
  BoardShape board = {};  // its offsets are in the views' p_T already
};

struct AdjustOptions {
  std::vector<int> free;  // which of Parameters(camera) are found; the others stay
  double huber = std::numeric_limits<double>::infinity();  // whitened error beyond which it counts linearly
  int max_steps = 60;
};

// Minimises the sum of squares of whitened errors, of large ones by Huber, and of the board's offsets over what
// is expected of them, if it has any; returns it. A point that the camera cannot see counts as an error of
// kLostError.
inline constexpr double kLostError_px = 300;
double Adjust(Adjustment& adjustment, const AdjustOptions& options);

// What Adjust minimises, and the part of it that is the board's.
double CostOf(const Adjustment& adjustment, double huber);
double CostOf(const BoardShape& board);

// Where a camera says that a point is less where it was seen, px, and that whitened; none where the camera
// cannot see it.
std::optional<Eigen::Vector2d> PixelError(const CameraModel& camera, const Pose& X_CT,
                                          const SeenPoint& point);
std::optional<Eigen::Vector2d> WhitenedError(const CameraModel& camera, const Pose& X_CT,
                                             const SeenPoint& point);

// Of the free parameters, (J^T J)^-1 with poses and board free too, for errors of unit deviation. None: they cannot
// be told apart.
std::optional<Eigen::MatrixXd> ParameterCovariance(const Adjustment& adjustment,
                                                   const std::vector<int>& free);

// The same where the errors of one view may be alike, whatever deviation they have: from how far each view
// alone pulls at the camera (Liang and Zeger, Biometrika 73, 1986, with views as clusters). Of many views; of
// few it is too small, as each pulls the camera its own way.
std::optional<Eigen::MatrixXd> ClusteredCovariance(const Adjustment& adjustment,
                                                   const std::vector<int>& free);

// How many of the offsets, in the plane and out of it, the views determine rather than what is expected: from
// 0 to 2 and 1 for each corner (MacKay, Neural Computation 4, 1992).
Eigen::Vector2d DeterminedOffsets(const Adjustment& adjustment, const std::vector<int>& free);

}  // namespace kestrel::vision
