// SPDX-License-Identifier: Apache-2.0
#include "flight/ground_keys.h"

#include <fmt/format.h>

#include <Eigen/Dense>

#include "base/file/model_files.h"
#include "vision/camera/calibration_file.h"

namespace kestrel::flight {
namespace {

// Whether the lights span space, so that there is one pose for what is seen of them.
void CheckLights(const vision::AircraftLights& lights, const Place& where, Mistakes& mistakes) {
  constexpr int kFewest = 4;
  constexpr double kFlat_m = 0.02;  // RMS off the plane that fits the lights best
  const auto count = static_cast<Eigen::Index>(lights.lights.size());
  if (count < kFewest)
    return mistakes.Add(where, "ground_camera.lights.lights", fmt::format("there are {}", count),
                        fmt::format("valid: {} or more", kFewest));
  Eigen::Matrix3Xd p(3, count);
  for (Eigen::Index i = 0; i < count; ++i) p.col(i) = lights.lights[static_cast<std::size_t>(i)].position_m;
  p.colwise() -= p.rowwise().mean().eval();
  const Eigen::JacobiSVD<Eigen::Matrix3Xd> svd(p);
  const double flat_m = svd.singularValues()[2] / std::sqrt(static_cast<double>(count));
  if (flat_m < kFlat_m)
    mistakes.Add(where, "ground_camera.lights.lights",
                 fmt::format("lie within {:.1g} m of one plane, which looks the same from two sides", flat_m),
                 fmt::format("valid: lights {:g} m and more off it", kFlat_m));
}

}  // namespace

std::optional<vision::GroundSight> LoadGroundSight(const mission::MissionType& type,
                                                   std::optional<GroundCameraKeys>& keys,
                                                   const std::filesystem::path& beside, const Place& where,
                                                   Mistakes& mistakes) {
  if (!type.needs_ground_camera) {
    if (keys)
      mistakes.Add(
          where, "ground_camera",
          fmt::format("given, but the mission '{}' has no use for a camera on the ground", type.name),
          "valid: null, or a mission that has");
    return std::nullopt;
  }
  if (!keys) {
    mistakes.Add(where, "ground_camera",
                 fmt::format("none, but the mission '{}' flies by a camera on the ground", type.name),
                 "valid: its camera and place");
    return std::nullopt;
  }
  const std::size_t before = mistakes.all().size();
  CheckLights(keys->lights, where, mistakes);
  vision::GroundSight sight{.stream = nullptr, .camera = {}, .place = keys->place, .lights = keys->lights};
  if (const auto camera = ModelFile(Model::kCamera, keys->camera, beside, where, mistakes))
    sight.camera = vision::LoadCamera(*camera, mistakes, keys->camera_name);
  return mistakes.all().size() == before ? std::optional(sight) : std::nullopt;
}

}  // namespace kestrel::flight
