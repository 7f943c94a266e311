// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "flight/dataset/format/format.h"

namespace kestrel::flight {

// The ASL format of the EuRoC MAV data set (M. Burri et al., "The EuRoC micro aerial vehicle datasets",
// Int. J. Robotics Research 35(10), 2016): mav0/cam0, imu0 and state_groundtruth_estimate0. Beside them, in
// folders of the same form: depth0 (TIFF, m along the ray), flow0 (.flo), segmentation0 and boxes0, of each
// camera.
class EurocFormat final : public Format {
 public:
  void Check(const Sequence& sequence, Mistakes& mistakes) const override;
  std::vector<SetFile> Pictures(const Sequence& sequence, const SetFrame& frame) const override;
  std::vector<SetFile> Tables(const Sequence& sequence) const override;
};

}  // namespace kestrel::flight
