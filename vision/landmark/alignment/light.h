// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/landmark/alignment/patch.h"
#include "vision/landmark/alignment/template_level.h"

namespace kestrel::vision {

// Grey of the patch = gain * (grey of the template less its mean) + offset.
struct Light {
  double gain = 1, offset = 0;
  double contrast = 1;  // deviation of the patch over that of the template: the gain where they look alike
  double correlation = 0, rms_grey = 0;
  double weight = 0;  // sum
};

// By regression over the spans of the patch. weights: of each pixel as the patch lies; none: 1.
Light FitLight(const TemplateLevel& level, const Patch& patch, const float* weights);
// What a light that is known leaves: of gain 1, and the offset that changes nothing.
Light SameLight(const TemplateLevel& level, const Patch& patch, const float* weights);

}  // namespace kestrel::vision
