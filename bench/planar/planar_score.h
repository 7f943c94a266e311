// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "bench/planar/planar_sequence.h"
#include "bench/planar/planar_trackers.h"

namespace kestrel::bench {

// Root mean square distance of the picture's four corners from where they are, px: the alignment error of
// POT-210.
double AlignmentError_px(const Eigen::Matrix3d& H_w, const Eigen::Matrix3d& H_true);

// How a tracker did. A frame counts while enough of the picture is to be seen.
struct PlanarScore {
  static constexpr double kCounts =
      0.3;  // share of the picture that is visible, from which on a frame counts
  static constexpr double kLost_px = 15;  // an answer that is farther off is none
  static constexpr double kRight_px = 5;

  std::vector<double> error_px;    // of each frame that counts; endless where there is no answer
  std::vector<double> recovery_s;  // after each time out of view, until it is right again; endless: never
  std::vector<double> ms;          // of each image
  int losses = 0;              // times that it was within kLost_px and then was not, while the frame counts
  int gone = 0, imagined = 0;  // frames with nothing of the picture in them; those with an answer

  double Precision(double within_px) const;  // share of the frames that count
  double Accuracy_px() const;                // mean error of those within kLost_px
  void Add(const PlanarScore& other);
};

// Time is of the processor, of this thread.
PlanarScore ScoreOf(const PlanarTracker& tracker, const std::vector<PlanarFrame>& frames);

}  // namespace kestrel::bench
