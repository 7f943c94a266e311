// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "flight/dataset/format/format.h"

namespace kestrel::flight {

// The odometry benchmark of KITTI (A. Geiger et al., "Are we ready for autonomous driving? The KITTI vision
// benchmark suite", CVPR 2012): sequences/NN/image_0 (grey) or image_2 (colour), a second camera image_1 or
// image_3, times.txt, calib.txt, and poses/NN.txt. Beside them in sequences/NN: depth_0 (16-bit PNG),
// flow_0 (PNG of KITTI's devkit), segmentation_0, boxes_0.csv, and of each ns imu.csv and truth.csv as
// EuRoC has them.
class KittiFormat final : public Format {
 public:
  void Check(const Sequence& sequence, Mistakes& mistakes) const override;
  std::vector<SetFile> Pictures(const Sequence& sequence, const SetFrame& frame) const override;
  std::vector<SetFile> Tables(const Sequence& sequence) const override;
};

}  // namespace kestrel::flight
