// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <vector>

#include "vision/calibration/view_adjustment.h"
#include "vision/camera/camera_model.h"

// How a calibration begins: without any idea of the lens.
namespace kestrel::vision {

// The least corners of a view that give a pose to be trusted.
inline constexpr std::size_t kMinCorners = 8;

// The pixel in the middle of the image.
inline Eigen::Vector2d MiddleOf(const CameraModel& camera) {
  return {(WidthPx(camera) - 1) / 2.0, (HeightPx(camera) - 1) / 2.0};
}

// Each view's pose under a camera, where it has one.
struct PlacedViews {
  Adjustment adjustment;
  std::vector<std::size_t> numbers;  // of its views, among all
};
PlacedViews PlaceViews(const CameraModel& camera, const std::vector<std::vector<SeenPoint>>& views);

// The deviation of whitened errors along one axis, whatever up to half of them are: from their median.
double RobustScale(const Adjustment& adjustment);

struct CalibrationStart {
  CameraModel camera;
  // One elsewhere that fits as well within three deviations, if there is any: the double sphere has such.
  std::optional<CameraModel> rival;
};

// From lenses of several shapes and many focal lengths, about the middle of the image, the camera that fits
// best after some adjustment of the free parameters; the others stay 0. None: no such lens sees enough.
std::optional<CalibrationStart> StartCalibration(const CameraModel& like, const std::vector<int>& free,
                                                 const std::vector<std::vector<SeenPoint>>& views);

}  // namespace kestrel::vision
