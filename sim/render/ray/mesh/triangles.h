// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <Eigen/Core>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "sim/render/ray/mesh/triangle_blocks.h"
#include "sim/render/ray/mesh/triangle_tree.h"

namespace kestrel::sim::ray {

// A mesh or a height field in its geom's frame.
class Triangles {
 public:
  static Triangles OfMesh(const mjModel* model, int mesh);
  static Triangles OfHeightField(const mjModel* model, int field);

  // Of the corners of each triangle; empty: the triangle's own normal.
  struct Corner {
    Eigen::Vector3f normal;
    Eigen::Vector2f st;
  };
  std::vector<Eigen::Vector3f> vertices;
  std::vector<Eigen::Vector3i> faces;
  std::vector<Corner> corners;                // three for each face
  std::optional<Eigen::Vector3f> one_normal;  // of all corners, as of what is drawn with its light painted in
  // Of each face: how s and t change along x, y, z.
  std::vector<Eigen::Matrix<float, 2, 3>> st_gradient;
  bool has_st = false;
  bool plain_facets = false;  // each shows one point of the texture, and all have one normal
  Eigen::Vector3f low, high;  // bounds
  // Boxes in boxes, that say where the triangles are more closely than the bounds: each is followed by those
  // within it, and `next` is the first that is not. The first holds all.
  struct Part {
    Eigen::Vector3f centre, half;
    std::size_t next;
  };
  std::vector<Part> parts;
  TriangleBlocks blocks;

  // What rays need that do not come from the viewpoint: in an Embree scene of its own, so that a moving mesh needs no new
  // one. Throws std::runtime_error as TriangleTree does.
  void MakeTree(const std::string& instruction_set);
  const TriangleTree& tree() const { return *tree_; }  // once it is made

 private:
  Triangles() = default;
  void Finish();
  void Divide(std::vector<int>::iterator begin, std::vector<int>::iterator end);
  std::optional<TriangleTree> tree_;
};

}  // namespace kestrel::sim::ray
