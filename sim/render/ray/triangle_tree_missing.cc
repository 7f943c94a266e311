// SPDX-License-Identifier: Apache-2.0
// In place of triangle_tree.cc where there is no Embree.
#include <stdexcept>

#include "sim/render/ray/triangle_tree.h"

namespace kestrel::sim::ray {

TriangleTree::TriangleTree(const std::vector<Eigen::Vector3f>&, const std::vector<Eigen::Vector3i>&) {
  throw std::runtime_error(
      "The world has a mesh or a height field, which the ray renderer cannot draw without Embree; build anew "
      "with "
      "Debian's libembree-dev.");
}
TriangleTree::TriangleTree(TriangleTree&&) noexcept = default;
TriangleTree::~TriangleTree() = default;

std::string EmbreeVersion() { return "none"; }

}  // namespace kestrel::sim::ray
