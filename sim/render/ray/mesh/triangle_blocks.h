// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

namespace kestrel::sim::ray {

// The triangles of a mesh by sixteen, as a vector holds them, those of a block near each other; and boxes in boxes that
// say where the blocks are, by sixteen as well. In the mesh's frame.
struct TriangleBlocks {
  static constexpr int kWidth = 16;

  // Where there are fewer, the others are points.
  struct Block {
    alignas(64) float corner[3][3][kWidth];  // of each triangle: first, second, third; x, y, z
    std::uint32_t face[kWidth];
  };
  // Where there are fewer, the others hold nothing.
  struct Boxes {
    alignas(64) float centre[3][kWidth], half[3][kWidth];
  };

  std::vector<Block> blocks;
  // The box i of levels[0] is that of blocks[i], the box i of levels[k] holds the boxes 16 i to 16 i + 15 of the level
  // below; box i is in element i / 16. The last level has one element.
  std::vector<std::vector<Boxes>> levels;
};

TriangleBlocks MakeBlocks(const std::vector<Eigen::Vector3f>& vertices,
                          const std::vector<Eigen::Vector3i>& faces);

}  // namespace kestrel::sim::ray
