// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <variant>

#include "vision/pinhole.h"

namespace kestrel {

// Every central camera there is: chosen by data, so a variant. A new model is one file and its name here.
using CameraModel = std::variant<Pinhole>;

// What all models have, for code that does not care which. Pixels: the centre of the first pixel is (0, 0);
// points and rays are in C (x right, y down, z forward).
inline int WidthPx(const CameraModel& camera) {
  return std::visit([](const auto& c) { return c.width_px; }, camera);
}
inline int HeightPx(const CameraModel& camera) {
  return std::visit([](const auto& c) { return c.height_px; }, camera);
}
// The pixel of a point, which may lie off the image; none outside the valid domain of the model.
inline std::optional<Eigen::Vector2d> Project(const CameraModel& camera, const Eigen::Vector3d& p_CQ) {
  return std::visit([&](const auto& c) { return c.Project(p_CQ); }, camera);
}
// The unit vector through a pixel, or through any place between pixels; none where the lens shows nothing.
inline std::optional<Eigen::Vector3d> Ray(const CameraModel& camera, const Eigen::Vector2d& uv) {
  return std::visit([&](const auto& c) -> std::optional<Eigen::Vector3d> { return c.Ray(uv); }, camera);
}

}  // namespace kestrel
