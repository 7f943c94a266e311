// SPDX-License-Identifier: Apache-2.0
// In place of triangle_tree.cc where there is no Embree.
#include <stdexcept>

#include "sim/render/ray/mesh/triangle_tree.h"

namespace kestrel::sim::ray {

TriangleTree::TriangleTree(const std::vector<Eigen::Vector3f>&, const std::vector<Eigen::Vector3i>&,
                           const std::string&) {
  throw std::runtime_error(
      "The world has a mesh or a height field, and the ray renderer draws its shadow, or one that is "
      "transparent, by "
      "Embree alone; build anew with Debian's libembree-dev, or fly without shadows.");
}
TriangleTree::TriangleTree(TriangleTree&&) noexcept = default;
TriangleTree::~TriangleTree() = default;

std::string EmbreeVersion() { return "none"; }

}  // namespace kestrel::sim::ray
