// SPDX-License-Identifier: Apache-2.0
#include "vision/camera/file/kalibr.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "vision/camera/file/camera_forms.h"

namespace kestrel::vision {
namespace {

// EuRoC's word for what Kalibr calls radtan.
constexpr const char *kRadialTangential = "radial-tangential", *kRadtan = "radtan";

// Null: Kalibr has no such pair.
const KalibrForm* FormOf(const std::string& model, const std::string& distortion) {
  for (const KalibrForm& each : KalibrForms())
    if (each.camera_model == model && each.distortion_model == distortion) return &each;
  return nullptr;
}

// also: what is valid beside Kalibr's own.
void UnknownForm(const ConfigNode& camera, const std::string& model, const std::string& distortion, Keys also,
                 Sheet& sheet) {
  for (const KalibrForm& each : KalibrForms())
    also.push_back(fmt::format("{}-{}", each.camera_model, each.distortion_model));
  sheet.Wrong(Find(camera, "camera_model")->where, "camera_model",
              fmt::format("'{}' with distortion_model '{}' is not known here", model, distortion),
              fmt::format("valid: {}", fmt::join(also, ", ")));
}

}  // namespace

const std::vector<KalibrForm>& KalibrForms() {
  static const std::vector<KalibrForm> kForms = [] {
    const Keys pinhole{"fx_px", "fy_px", "cx_px", "cy_px"};
    const Keys omni{"xi", "fx_px", "fy_px", "cx_px", "cy_px"};
    const Keys spheres{"xi", "alpha", "fx_px", "fy_px", "cx_px", "cy_px"};
    const Keys extended{"alpha", "beta", "fx_px", "fy_px", "cx_px", "cy_px"};
    const Keys radtan{"k1", "k2", "p1", "p2"}, equi{"k1", "k2", "k3", "k4"};
    return std::vector<KalibrForm>{{"pinhole", "radtan", "brown_conrady", pinhole, radtan},
                                   {"pinhole", "equidistant", "kannala_brandt", pinhole, equi},
                                   {"pinhole", "equi", "kannala_brandt", pinhole, equi},
                                   {"pinhole", "fov", "fov", pinhole, {"w"}},
                                   {"pinhole", "none", "pinhole", pinhole, {}},
                                   {"omni", "radtan", "unified", omni, radtan},
                                   {"omni", "none", "unified", omni, {}},
                                   {"eucm", "none", "extended_unified", extended, {}},
                                   {"ds", "none", "double_sphere", spheres, {}}};
  }();
  return kForms;
}

Keys KalibrCameras(const ConfigNode& root) {
  Keys cameras;
  for (const auto& [key, member] : root.members) {
    if (key.starts_with("cam") && Find(member, "camera_model")) cameras.push_back(key);
  }
  std::sort(cameras.begin(), cameras.end());
  return cameras;
}

void FromKalibr(const ConfigNode& root, std::size_t index, Sheet& sheet) {
  sheet.path = KalibrCameras(root)[index];
  const ConfigNode& camera = *Find(root, sheet.path);
  sheet.node.where = camera.where;
  const std::string model = TextOf(camera, "camera_model"), distortion = TextOf(camera, "distortion_model");
  const KalibrForm* form = FormOf(model, distortion);
  if (form == nullptr) return UnknownForm(camera, model, distortion, {}, sheet);
  sheet.SetText("model", form->model, camera.where);
  sheet.SetList(camera, "intrinsics", form->intrinsics);
  sheet.SetList(camera, "distortion_coeffs", form->distortion);
  if (Find(camera, "resolution")) sheet.SetList(camera, "resolution", {"width_px", "height_px"});
  sheet.to_camera = Find(camera, "T_cam_imu");
  sheet.on_imu = FindAny(camera, {"T_cam_imu", "T_imu_cam"});
  if (const ConfigNode* field = Find(camera, "field_deg")) sheet.Set("field_deg", *field);
}

Keys EurocCameras(const ConfigNode& root) {
  const bool is =
      Find(root, "camera_model") && Find(root, "intrinsics") && Find(root, "distortion_coefficients");
  return is ? NumberedCameras(1) : Keys();
}

void FromEuroc(const ConfigNode& root, std::size_t, Sheet& sheet) {
  sheet.node.where = root.where;
  const std::string model = TextOf(root, "camera_model"), written = TextOf(root, "distortion_model");
  const std::string distortion = written == kRadialTangential ? kRadtan : written;
  const KalibrForm* form = FormOf(model, distortion);
  if (form == nullptr)
    return UnknownForm(root, model, written, {fmt::format("pinhole-{}", kRadialTangential)}, sheet);
  sheet.SetText("model", form->model, root.where);
  sheet.SetList(root, "intrinsics", form->intrinsics);
  sheet.SetList(root, "distortion_coefficients", form->distortion);
  if (Find(root, "resolution")) sheet.SetList(root, "resolution", {"width_px", "height_px"});
  sheet.on_imu = Find(root, "T_BS");
}

}  // namespace kestrel::vision
