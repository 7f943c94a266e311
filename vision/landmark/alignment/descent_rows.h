// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "vision/landmark/alignment/patch.h"
#include "vision/landmark/alignment/template_level.h"
#include "vision/landmark/alignment/warp.h"

namespace kestrel::vision {

// The rows of a design that depend on the image, for the pixels in the spans of the patch's gradient. Those of
// the inverse compositional algorithm are the template's own.

// Of ESM: half of the sum of both gradients, the patch's in the light of the template.
void FillSecondOrderRows(const TemplateLevel& level, const PatchGradient& slope, double gain, Design& design);

// Of thesis (3.3): the image's gradient where the warp with the parameters p takes a pixel, times the
// derivative of the warp. The patch's own gradient is the same times the derivative of the place, which is
// taken away again. With the sign turned, since the step of a design is one of the template.
void FillForwardAdditiveRows(const TemplateLevel& level, const PatchGradient& slope, double gain,
                             WarpModel warp, const WarpParameters& p, Design& design);

}  // namespace kestrel::vision
