// SPDX-License-Identifier: Apache-2.0
#include "sim/render/ray/mesh/triangle_tree.h"

#include <fmt/format.h>

#include <stdexcept>
#include <utility>

#include "sim/render/ray/mesh/embree.h"

namespace kestrel::sim::ray {
namespace {

// Only fronts are seen: a back is as if it were not there.
void RefuseBacks(const RTCFilterFunctionNArguments* a) {
  for (unsigned i = 0; i < a->N; ++i) {
    const float along = RTCRayN_dir_x(a->ray, a->N, i) * RTCHitN_Ng_x(a->hit, a->N, i) +
                        RTCRayN_dir_y(a->ray, a->N, i) * RTCHitN_Ng_y(a->hit, a->N, i) +
                        RTCRayN_dir_z(a->ray, a->N, i) * RTCHitN_Ng_z(a->hit, a->N, i);
    if (along > 0) a->valid[i] = 0;
  }
}

// Of its ways to trace rays the one that goes with the instruction set.
std::string EmbreeConfig(const std::string& set) {
  const char* const isa = set == "avx512" ? "avx512" : set == "avx2" ? "avx2" : set == "ssse3" ? "sse2" : "";
  return *isa ? fmt::format("threads=1,isa={}", isa) : "threads=1";
}

}  // namespace

TriangleTree::TriangleTree(const std::vector<Eigen::Vector3f>& vertices,
                           const std::vector<Eigen::Vector3i>& faces, const std::string& instruction_set) {
  device_ = rtcNewDevice(EmbreeConfig(instruction_set).c_str());
  if (!device_) throw std::runtime_error("Embree, which finds the triangles of meshes, cannot be started.");
  scene_ = rtcNewScene(device_);
  rtcSetSceneFlags(scene_, RTC_SCENE_FLAG_ROBUST);
  const RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
  auto* v = static_cast<float*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 3 * sizeof(float), vertices.size()));
  for (std::size_t i = 0; i < vertices.size(); ++i)
    for (int k = 0; k < 3; ++k) v[3 * i + k] = vertices[i][k];
  auto* f = static_cast<unsigned*>(rtcSetNewGeometryBuffer(
      geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 3 * sizeof(unsigned), faces.size()));
  for (std::size_t i = 0; i < faces.size(); ++i)
    for (int k = 0; k < 3; ++k) f[3 * i + k] = static_cast<unsigned>(faces[i][k]);
  rtcSetGeometryIntersectFilterFunction(geometry, RefuseBacks);
  rtcCommitGeometry(geometry);
  rtcAttachGeometry(scene_, geometry);
  rtcReleaseGeometry(geometry);
  rtcCommitScene(scene_);
}

TriangleTree::TriangleTree(TriangleTree&& other) noexcept
    : device_(std::exchange(other.device_, nullptr)), scene_(std::exchange(other.scene_, nullptr)) {}

TriangleTree::~TriangleTree() {
  if (scene_) rtcReleaseScene(scene_);
  if (device_) rtcReleaseDevice(device_);
}

std::string EmbreeVersion() {
  const RTCDevice device = rtcNewDevice("threads=1");
  if (!device) return "none";
  const auto number = [&](RTCDeviceProperty which) { return rtcGetDeviceProperty(device, which); };
  const std::string text =
      fmt::format("{}.{}.{}", number(RTC_DEVICE_PROPERTY_VERSION_MAJOR),
                  number(RTC_DEVICE_PROPERTY_VERSION_MINOR), number(RTC_DEVICE_PROPERTY_VERSION_PATCH));
  rtcReleaseDevice(device);
  return text;
}

}  // namespace kestrel::sim::ray
