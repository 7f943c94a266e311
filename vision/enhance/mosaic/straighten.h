// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

namespace kestrel::vision {

// The turn R_VW that makes a panorama straight where nobody has said what is down: people and gimbals hold the x
// axes of a camera level, so that down is what they are all square to (Brown and Lowe 2007, section 6). The first
// camera looks towards the middle of V. None: they hardly turn, so that it cannot be told.
std::optional<Eigen::Matrix3d> Straightening(std::span<const Eigen::Matrix3d> R_WC);

}  // namespace kestrel::vision
