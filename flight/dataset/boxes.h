// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <string>
#include <vector>

#include "flight/dataset/format/sequence.h"

namespace kestrel::flight {

// The things that boxes are put around: the pad and the targets, by their bodies.
class BoxFinder {
 public:
  explicit BoxFinder(const mjModel* model);
  // Of what is seen of each, in the order of the bodies. geom: as in sim::Surfaces.
  std::vector<Box> Find(const cv::Mat& geom) const;

 private:
  std::vector<int> thing_of_geom_;  // -1: none
  std::vector<std::string> labels_;
};

}  // namespace kestrel::flight
