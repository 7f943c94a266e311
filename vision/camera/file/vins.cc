// SPDX-License-Identifier: Apache-2.0
#include "vision/camera/file/vins.h"

#include <algorithm>

namespace kestrel::vision {
namespace {

// The names of its parameters in each of the maps, and ours.
struct CamodocalModel {
  const char *model_type, *model;
  Keys projection, our_projection, distortion, our_distortion;
};

const std::vector<CamodocalModel>& CamodocalModels() {
  const Keys focal{"fx_px", "fy_px", "cx_px", "cy_px"};
  const Keys radtan{"k1", "k2", "p1", "p2"}, eight{"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"};
  static const std::vector<CamodocalModel> kModels{
      {"PINHOLE", "brown_conrady", {"fx", "fy", "cx", "cy"}, focal, radtan, radtan},
      {"PINHOLE_FULL", "rational", {"fx", "fy", "cx", "cy"}, focal, eight, eight},
      {"MEI", "unified", {"gamma1", "gamma2", "u0", "v0"}, focal, radtan, radtan},
      {"KANNALA_BRANDT",
       "kannala_brandt",
       {"mu", "mv", "u0", "v0", "k2", "k3", "k4", "k5"},
       {"fx_px", "fy_px", "cx_px", "cy_px", "k1", "k2", "k3", "k4"},
       {},
       {}}};
  return kModels;
}

}  // namespace

Keys VinsCameras(const ConfigNode& root) {
  return Find(root, "model_type") && Find(root, "projection_parameters") ? Keys{"cam0"} : Keys();
}

void FromVins(const ConfigNode& root, std::size_t, Sheet& sheet) {
  const ConfigNode& type = *Find(root, "model_type");
  const auto& models = CamodocalModels();
  const auto model = std::find_if(models.begin(), models.end(),
                                  [&](const CamodocalModel& each) { return each.model_type == type.text; });
  if (model == models.end()) {
    Keys valid;
    for (const CamodocalModel& each : models) valid.emplace_back(each.model_type);
    return sheet.Unknown(type, "model_type", valid);
  }
  sheet.SetText("model", model->model, type.where);
  sheet.SetMembers(*Find(root, "projection_parameters"), model->projection, model->our_projection);
  if (!model->distortion.empty()) {
    const ConfigNode* distortion = Find(root, "distortion_parameters");
    if (!distortion) return sheet.Wrong(root.where, "distortion_parameters", "must be given");
    sheet.SetMembers(*distortion, model->distortion, model->our_distortion);
  }
  if (type.text == "MEI") {
    const ConfigNode* mirror = Find(root, "mirror_parameters");
    if (!mirror) return sheet.Wrong(root.where, "mirror_parameters", "must be given");
    sheet.SetMembers(*mirror, {"xi"}, {"xi"});
  }
  sheet.SetSize(Find(root, "image_width"), Find(root, "image_height"));
}

}  // namespace kestrel::vision
