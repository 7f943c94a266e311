// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <span>

#include "vision/landmark/alignment/patch.h"
#include "vision/landmark/alignment/template_level.h"

namespace kestrel::vision {

// The sums over pixels that thesis (3.4) and (3.5) are made of.
struct NormalSums {
  DesignMatrix hessian = DesignMatrix::Zero();  // sum w d d^T
  DesignVector slope = DesignVector::Zero();    // sum w d I
  double squares = 0, weight = 0;               // sum w I^2, sum w
};

// Over the spans of the rows. weights: of each pixel as the patch lies; none: 1. known_hessian: it is not
// summed, but taken, as in the inverse compositional algorithm.
NormalSums SumNormal(const Design& design, const Patch& patch, std::span<const Patch::Span> spans,
                     const float* weights, const DesignMatrix* known_hessian);

}  // namespace kestrel::vision
