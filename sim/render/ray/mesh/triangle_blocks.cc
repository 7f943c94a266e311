// SPDX-License-Identifier: Apache-2.0
#include "sim/render/ray/mesh/triangle_blocks.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <bit>
#include <limits>
#include <numeric>

namespace kestrel::sim::ray {
namespace {

constexpr std::size_t kWidth = TriangleBlocks::kWidth;
using Box = Eigen::AlignedBox3f;

// Orders the faces so that each sixteen, and each sixteen of those, are near each other. The left half takes a power
// of two of blocks, so that no group straddles a cut.
void Order(const std::vector<Eigen::Vector3f>& middles, std::vector<int>::iterator begin,
           std::vector<int>::iterator end) {
  const auto count = static_cast<std::size_t>(end - begin);
  if (count <= kWidth) return;
  Box box;
  for (auto f = begin; f != end; ++f) box.extend(middles[static_cast<std::size_t>(*f)]);
  Eigen::Index axis;
  box.sizes().maxCoeff(&axis);
  const std::size_t blocks = (count + kWidth - 1) / kWidth;
  const auto cut = begin + static_cast<std::ptrdiff_t>(kWidth * std::bit_floor(blocks - 1));
  std::nth_element(begin, cut, end, [&](int a, int b) {
    const float at_a = middles[static_cast<std::size_t>(a)][axis],
                at_b = middles[static_cast<std::size_t>(b)][axis];
    return at_a != at_b ? at_a < at_b : a < b;
  });
  Order(middles, begin, cut);
  Order(middles, cut, end);
}

// By sixteen, somewhat larger for what rounding does.
std::vector<TriangleBlocks::Boxes> Packed(const std::vector<Box>& boxes) {
  std::vector<TriangleBlocks::Boxes> packed((boxes.size() + kWidth - 1) / kWidth);
  for (std::size_t i = 0; i < kWidth * packed.size(); ++i) {
    Eigen::Vector3f centre = Eigen::Vector3f::Zero(), half = Eigen::Vector3f::Constant(-1e30f);
    if (i < boxes.size()) {
      centre = boxes[i].center();
      half = 0.5001f * boxes[i].sizes() + Eigen::Vector3f::Constant(1e-4f);
    }
    for (int k = 0; k < 3; ++k) {
      packed[i / kWidth].centre[k][i % kWidth] = centre[k];
      packed[i / kWidth].half[k][i % kWidth] = half[k];
    }
  }
  return packed;
}

}  // namespace

TriangleBlocks MakeBlocks(const std::vector<Eigen::Vector3f>& vertices,
                          const std::vector<Eigen::Vector3i>& faces) {
  TriangleBlocks made;
  if (faces.empty()) return made;
  const auto corner = [&](int face, int k) -> const Eigen::Vector3f& {
    return vertices[static_cast<std::size_t>(faces[static_cast<std::size_t>(face)][k])];
  };
  std::vector<int> order(faces.size());
  std::iota(order.begin(), order.end(), 0);
  std::vector<Eigen::Vector3f> middles;
  for (const int f : order) middles.emplace_back((corner(f, 0) + corner(f, 1) + corner(f, 2)) / 3);
  Order(middles, order.begin(), order.end());

  made.blocks.resize((faces.size() + kWidth - 1) / kWidth, {});
  std::vector<Box> boxes(made.blocks.size());
  for (std::size_t i = 0; i < faces.size(); ++i) {
    TriangleBlocks::Block& block = made.blocks[i / kWidth];
    block.face[i % kWidth] = static_cast<std::uint32_t>(order[i]);
    for (int k = 0; k < 3; ++k) {
      const Eigen::Vector3f& at = corner(order[i], k);
      boxes[i / kWidth].extend(at);
      for (int axis = 0; axis < 3; ++axis) block.corner[k][axis][i % kWidth] = at[axis];
    }
  }
  while (true) {
    made.levels.push_back(Packed(boxes));
    if (boxes.size() <= kWidth) return made;
    std::vector<Box> wider((boxes.size() + kWidth - 1) / kWidth);
    for (std::size_t i = 0; i < boxes.size(); ++i) wider[i / kWidth].extend(boxes[i]);
    boxes = std::move(wider);
  }
}

}  // namespace kestrel::sim::ray
