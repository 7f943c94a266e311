// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "vision/camera/camera_model.h"

namespace kestrel::vision {

// What joins the images of a mosaic.
enum class MosaicModel {
  kPlane,    // the camera moves before a plane, or far from what it sees: homographies of rays
  kRotation  // it turns on the spot: rotations
};

// The same place in two images of one camera.
struct PixelPair {
  Eigen::Vector2d a, b;  // px
};

struct MotionEstimate {
  Eigen::Matrix3d M_AB;          // takes rays of b to those of a; of a homography up to scale
  std::vector<PixelPair> pairs;  // that agree
  double rms_px = 0;             // of their distances in a
};

// The motion under which most pairs agree within a distance of threshold_px, by RANSAC, and fitted to all of
// those (thesis 3.2.3, algorithm 1; of rotations by two pairs and Kabsch's solution). The same pairs give the same
// bits. None: fewer than min_pairs agree, or what they agree on is no motion of a camera.
std::optional<MotionEstimate> EstimateMotion(MosaicModel model, const CameraModel& camera,
                                             std::span<const PixelPair> pairs, double threshold_px,
                                             int min_pairs);

}  // namespace kestrel::vision
