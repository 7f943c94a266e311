// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "flight/dataset/format/format.h"

namespace kestrel::flight {

// The format of the TUM RGB-D benchmark (J. Sturm et al., "A benchmark for the evaluation of RGB-D SLAM
// systems", IROS 2012), of one camera: rgb/, depth/ and their lists, groundtruth.txt, accelerometer.txt.
// Beside them gyroscope.txt, flow/ (.flo), segmentation/ and boxes.csv.
class TumFormat final : public Format {
 public:
  void Check(const Sequence& sequence, Mistakes& mistakes) const override;
  std::vector<SetFile> Pictures(const Sequence& sequence, const SetFrame& frame) const override;
  std::vector<SetFile> Tables(const Sequence& sequence) const override;
};

}  // namespace kestrel::flight
