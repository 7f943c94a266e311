// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "vision/landmark/alignment/alignment.h"
#include "vision/landmark/alignment/light.h"
#include "vision/landmark/alignment/patch.h"
#include "vision/landmark/alignment/template_level.h"

namespace kestrel::vision {

struct ResidualWeights {
  std::vector<float> weights;  // of each pixel as the patch lies; outside its spans anything
  double sigma_grey = 0;       // of the residual, from its median absolute deviation from zero
  std::vector<float> sample;   // scratch
};

void WeighResiduals(const TemplateLevel& level, const Patch& patch, const Light& light, AlignmentLoss loss,
                    ResidualWeights& weights);

}  // namespace kestrel::vision
