// SPDX-License-Identifier: Apache-2.0
#include "vision/camera/file/on_imu.h"

#include <fmt/format.h>

#include <charconv>

namespace kestrel::vision {
namespace {

std::optional<double> NumberOf(const ConfigNode& node) {
  double value = 0;
  const char* end = node.text.data() + node.text.size();
  const auto [rest, error] = std::from_chars(node.text.data(), end, value);
  return error == std::errc() && rest == end ? std::optional(value) : std::nullopt;
}

// Files round to few digits.
constexpr double kMaxDeviation = 1e-2;

}  // namespace

std::optional<Pose> PoseOnImu(Sheet& sheet) {
  if (!sheet.on_imu) return std::nullopt;
  Nodes elements = ElementsOf(*sheet.on_imu);
  const bool as_quaternion = Find(*sheet.on_imu, "qw");
  if (as_quaternion) {
    elements.clear();
    for (const char* key : {"px", "py", "pz", "qx", "qy", "qz", "qw"})
      if (const ConfigNode* found = Find(*sheet.on_imu, key)) elements.push_back(found);
  }
  std::vector<double> n;
  for (const ConfigNode* each : elements)
    if (const auto number = NumberOf(*each)) n.push_back(*number);
  const auto none = [&] {
    sheet.Wrong(sheet.on_imu->where, "the camera's place on the IMU", "is no rigid motion",
                "valid: 4 x 4 numbers, a rotation beside a translation above 0, 0, 0, 1");
    return std::nullopt;
  };
  if (n.size() != elements.size() || n.size() != (as_quaternion ? 7u : 16u)) return none();
  if (as_quaternion) {
    const Eigen::Quaterniond R(n[6], n[3], n[4], n[5]);
    if (!(std::abs(R.norm() - 1) < kMaxDeviation)) return none();
    return Pose{R.normalized(), {n[0], n[1], n[2]}};
  }
  Eigen::Matrix3d R;
  R << n[0], n[1], n[2], n[4], n[5], n[6], n[8], n[9], n[10];
  const bool last_row = n[12] == 0 && n[13] == 0 && n[14] == 0 && n[15] == 1;
  if (!last_row || !((R.transpose() * R - Eigen::Matrix3d::Identity()).norm() < kMaxDeviation) ||
      !(R.determinant() > 0))
    return none();
  const Pose X{Eigen::Quaterniond(R).normalized(), {n[3], n[7], n[11]}};
  return sheet.to_camera ? X.Inverse() : X;
}

}  // namespace kestrel::vision
