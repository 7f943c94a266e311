// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

struct RTCDeviceTy;
struct RTCSceneTy;

namespace kestrel::sim::ray {

// Embree's tree of triangles, by which a ray finds the nearest one whose front it meets. Throws
// std::runtime_error where Embree cannot be started, or Kestrel was built without it.
class TriangleTree {
 public:
  // instruction_set: a name of sim/render/ray/instruction_set.h.
  TriangleTree(const std::vector<Eigen::Vector3f>& vertices, const std::vector<Eigen::Vector3i>& faces,
               const std::string& instruction_set);
  TriangleTree(TriangleTree&&) noexcept;
  TriangleTree& operator=(TriangleTree&&) = delete;
  ~TriangleTree();

  RTCSceneTy* scene() const { return scene_; }

 private:
  RTCDeviceTy* device_ = nullptr;
  RTCSceneTy* scene_ = nullptr;
};

std::string EmbreeVersion();  // "none": it cannot be started, or there is none

}  // namespace kestrel::sim::ray
