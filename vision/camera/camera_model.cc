// SPDX-License-Identifier: Apache-2.0
#include "vision/camera/camera_model.h"

#include <concepts>
#include <stdexcept>

#include "vision/camera/extended_unified.h"
#include "vision/camera/fov.h"
#include "vision/camera/rational.h"

namespace kestrel::vision {
namespace {

// Those of cameras that are calibrated elsewhere and read here are added as a plug-in's are: they are rarely
// met, and the variant stays small.
std::vector<AddedModel>& Added() {
  static std::vector<AddedModel> models{AddedModel(Fov{}), AddedModel(ExtendedUnified{}),
                                        AddedModel(Rational{})};
  return models;
}

template <class Model>
void AddOwn(std::vector<CameraModel>& models) {
  if constexpr (std::default_initializable<Model>) models.emplace_back(Model{});
}

template <class... Each>
std::vector<CameraModel> OwnModels(const std::variant<Each...>*) {
  std::vector<CameraModel> models;
  (AddOwn<Each>(models), ...);
  return models;
}

}  // namespace

void AddCameraModel(AddedModel defaults) {
  for (const CameraModel& other : CameraModels())
    if (std::string(NameOf(other)) == defaults.name())
      throw std::logic_error("two camera models are called '" + std::string(defaults.name()) + "'");
  Added().push_back(std::move(defaults));
}

std::vector<CameraModel> CameraModels() {
  std::vector<CameraModel> models = OwnModels(static_cast<const CameraModel*>(nullptr));
  models.insert(models.end(), Added().begin(), Added().end());
  return models;
}

double ShareCovered(const CameraModel& camera) {
  // From the centre of the first pixel to that of the last, corners included: those stand for less.
  constexpr int kSteps = 64;
  const auto weight = [](int i) { return i == 0 || i == kSteps ? 0.5 : 1.0; };
  double seen = 0;
  for (int i = 0; i <= kSteps; ++i) {
    for (int j = 0; j <= kSteps; ++j) {
      const Eigen::Vector2d uv((WidthPx(camera) - 1.0) * i / kSteps, (HeightPx(camera) - 1.0) * j / kSteps);
      if (Ray(camera, uv)) seen += weight(i) * weight(j);
    }
  }
  return seen / (kSteps * kSteps);
}

}  // namespace kestrel::vision
