// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "vision/camera/added_model.h"
#include "vision/camera/brown_conrady.h"
#include "vision/camera/double_sphere.h"
#include "vision/camera/kannala_brandt.h"
#include "vision/camera/pinhole.h"
#include "vision/camera/unified.h"

namespace kestrel::vision {

// Every central camera there is: chosen by data, so a variant. A new model is one file and its name here; one
// from outside is added by AddCameraModel.
using CameraModel = std::variant<Pinhole, BrownConrady, Unified, KannalaBrandt, DoubleSphere, AddedModel>;

// What all models have, for code that does not care which. Pixels: the centre of the first pixel is (0, 0);
// points and rays are in C (x right, y down, z forward).
inline const char* NameOf(const CameraModel& camera) {
  return std::visit(
      [](const auto& c) {
        if constexpr (requires { c.kName; })
          return c.kName;
        else
          return c.name();
      },
      camera);
}
inline int WidthPx(const CameraModel& camera) {
  return std::visit([](const auto& c) { return c.width_px; }, camera);
}
inline int HeightPx(const CameraModel& camera) {
  return std::visit([](const auto& c) { return c.height_px; }, camera);
}
// The pixel of a point, which may lie off the image; none outside the valid domain of the model. With its
// derivatives by the point and by the parameters, in the order of Parameters().
inline std::optional<Eigen::Vector2d> Project(const CameraModel& camera, const Eigen::Vector3d& p_CQ,
                                              Eigen::Matrix<double, 2, 3>* d_point = nullptr,
                                              Eigen::Matrix2Xd* d_parameters = nullptr) {
  return std::visit([&](const auto& c) { return c.Project(p_CQ, d_point, d_parameters); }, camera);
}
// The unit vector through a pixel, or through any place between pixels; none where the lens shows nothing.
inline std::optional<Eigen::Vector3d> Ray(const CameraModel& camera, const Eigen::Vector2d& uv,
                                          Eigen::Matrix<double, 3, 2>* d_pixel = nullptr) {
  return std::visit([&](const auto& c) { return c.Ray(uv, d_pixel); }, camera);
}
// How far from the optical axis the valid domain goes, rad: the lens's own limit or the model's.
inline double MaxAngle(const CameraModel& camera) {
  return std::visit([](const auto& c) { return c.MaxAngle(); }, camera);
}
// The parameters that a calibration finds: fx, fy, cx, cy, then the model's own.
inline std::vector<std::string> ParameterNames(const CameraModel& camera) {
  return std::visit([](const auto& c) { return c.ParameterNames(); }, camera);
}
inline Eigen::VectorXd Parameters(const CameraModel& camera) {
  return std::visit([](const auto& c) { return c.Parameters(); }, camera);
}
inline void SetParameters(CameraModel& camera, const Eigen::VectorXd& all) {
  std::visit([&](auto& c) { c.SetParameters(all); }, camera);
}

// Every model by its defaults: those of the variant, then those that were added.
std::vector<CameraModel> CameraModels();

// How much of the image the lens fills, by a grid of rays; 1: it all, corners included.
double ShareCovered(const CameraModel& camera);

}  // namespace kestrel::vision
