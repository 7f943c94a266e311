// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <array>

namespace kestrel::vision {

// The smoothest path that goes on from two places and stays within bounds: of all d with lower <= d <= upper, that which
// makes sum d^2 + lambda sum (d[i] - 2 d[i-1] + d[i-2])^2 least, where d[-1] and d[-2] are last[1] and last[0]. Where
// a lower bound is above the upper one, both are taken to be their mean. cutoff: as of PathWeights. By a primal-dual
// interior-point method (Nocedal and Wright 2006, section 16.6), to 1e-6 of the bounds' unit.
Eigen::VectorXd BoundedPath(const Eigen::VectorXd& lower, const Eigen::VectorXd& upper,
                            const std::array<double, 2>& last, double cutoff);

}  // namespace kestrel::vision
