// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>

namespace kestrel::vision {

// How much each of evenly spaced places of a path counts in the smooth path at one of them, which has `before` places
// before it and `after` behind it. The smooth path p is that which makes sum |p - c|^2 + lambda sum |D^order p|^2
// least (Whittaker 1923; the fixed-lag Kalman smoother of a model whose derivative of that order is white noise). A
// path that is a polynomial of lower order comes out as it is, also at the ends. With many places on both sides the
// gain is 1 / (1 + (f / cutoff)^(2 order)) for slow motions. cutoff: cycles a place, below 0.5. order: 1 to 3.
// Returns the before + after + 1 weights, whose sum is 1.
Eigen::VectorXd PathWeights(int before, int after, double cutoff, int order);

}  // namespace kestrel::vision
