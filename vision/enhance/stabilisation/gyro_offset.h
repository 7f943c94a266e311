// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "vision/enhance/stabilisation/gyro_track.h"

namespace kestrel::vision {

// How a camera turned between two images, as they show it: the rotation vector of R_C0C1, rad.
struct ImageTurn {
  double from_s = 0, to_s = 0;
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();
};

struct GyroOffset {
  double offset_s = 0;  // to be added to an image's time for the gyro's
  double unlike = 0;    // RMS of what the gyro does not explain of the turns, over their RMS
  int turns = 0;        // that were compared
  std::optional<double> other_s =
      {};  // another one that is about as good, as of a turning that repeats itself
};

// The offset of the gyro's clock, at most max_offset_s, by which its turns are most like those of the images. None: it
// covers fewer than 20 turns, or even the best offset explains less than half of them, as where the camera stands still
// or the axes are others.
std::optional<GyroOffset> EstimateGyroOffset(const std::vector<ImageTurn>& turns, const GyroTrack& gyro,
                                             double max_offset_s);

}  // namespace kestrel::vision
