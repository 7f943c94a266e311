// SPDX-License-Identifier: Apache-2.0
#include "vision/camera/file/euroc.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "vision/camera/file/camera_forms.h"
#include "vision/camera/file/kalibr.h"

namespace kestrel::vision {
namespace {

// Its word for what Kalibr calls radtan.
constexpr const char *kRadialTangential = "radial-tangential", *kRadtan = "radtan";

}  // namespace

Keys EurocCameras(const ConfigNode& root) {
  const bool is =
      Find(root, "camera_model") && Find(root, "intrinsics") && Find(root, "distortion_coefficients");
  return is ? NumberedCameras(1) : Keys();
}

void FromEuroc(const ConfigNode& root, std::size_t, Sheet& sheet) {
  sheet.node.where = root.where;
  const std::string model = TextOf(root, "camera_model"), written = TextOf(root, "distortion_model");
  const std::string distortion = written == kRadialTangential ? kRadtan : written;
  const auto& forms = KalibrForms();
  const auto form = std::find_if(forms.begin(), forms.end(), [&](const KalibrForm& each) {
    return each.camera_model == model && each.distortion_model == distortion;
  });
  if (form == forms.end()) {
    Keys valid{fmt::format("pinhole with {}", kRadialTangential)};
    for (const auto& each : forms)
      valid.push_back(fmt::format("{} with {}", each.camera_model, each.distortion_model));
    return sheet.Wrong(Find(root, "camera_model")->where, "camera_model",
                       fmt::format("'{}' with distortion_model '{}' is not known here", model, written),
                       fmt::format("valid: {}", fmt::join(valid, ", ")));
  }
  sheet.SetText("model", form->model, root.where);
  sheet.SetList(root, "intrinsics", form->intrinsics);
  sheet.SetList(root, "distortion_coefficients", form->distortion);
  if (Find(root, "resolution")) sheet.SetList(root, "resolution", {"width_px", "height_px"});
  sheet.on_imu = Find(root, "T_BS");
}

}  // namespace kestrel::vision
