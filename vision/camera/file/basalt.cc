// SPDX-License-Identifier: Apache-2.0
#include "vision/camera/file/basalt.h"

#include <algorithm>

#include "vision/camera/file/camera_forms.h"

namespace kestrel::vision {
namespace {

struct BasaltModel {
  const char *camera_type, *model;
  Keys own;  // beside fx, fy, cx, cy, by the same names here
};

const std::vector<BasaltModel>& BasaltModels() {
  static const std::vector<BasaltModel> kModels{
      {"pinhole", "pinhole", {}},
      {"ds", "double_sphere", {"xi", "alpha"}},
      {"eucm", "extended_unified", {"alpha", "beta"}},
      {"ucm", "extended_unified", {"alpha"}},
      {"kb4", "kannala_brandt", {"k1", "k2", "k3", "k4"}},
      {"fov", "fov", {"w"}},
      {"pinhole-radtan8", "rational", {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"}}};
  return kModels;
}

// Of one camera: where its type and numbers stand, and its resolution, which may be missing.
struct BasaltCamera {
  const ConfigNode *intrinsics = nullptr, *resolution = nullptr, *on_imu = nullptr;
};

std::vector<BasaltCamera> CamerasOfBasalt(const ConfigNode& root) {
  std::vector<BasaltCamera> cameras;
  const ConfigNode* value = Find(root, "value0");
  const ConfigNode* list = value ? Find(*value, "intrinsics") : nullptr;
  if (list) {
    const auto of = [&](const char* key, std::size_t i) -> const ConfigNode* {
      const ConfigNode* all = Find(*value, key);
      return all && i < all->members.size() ? &all->members[i].node : nullptr;
    };
    for (std::size_t i = 0; i < list->members.size(); ++i)
      cameras.push_back({&list->members[i].node, of("resolution", i), of("T_imu_cam", i)});
  }
  for (const auto& [key, member] : root.members) {
    if (key.starts_with("cam") && Find(member, "camera_type"))
      cameras.push_back({&member, Find(member, "resolution"), nullptr});
  }
  return cameras;
}

}  // namespace

Keys BasaltCameras(const ConfigNode& root) { return NumberedCameras(CamerasOfBasalt(root).size()); }

void FromBasalt(const ConfigNode& root, std::size_t index, Sheet& sheet) {
  const BasaltCamera camera = CamerasOfBasalt(root)[index];
  sheet.path = NumberedCameras(index + 1).back();
  sheet.node.where = camera.intrinsics->where;
  sheet.on_imu = camera.on_imu;
  const ConfigNode *type = Find(*camera.intrinsics, "camera_type"),
                   *numbers = Find(*camera.intrinsics, "intrinsics");
  if (!type || !numbers)
    return sheet.Wrong(camera.intrinsics->where, "camera_type, intrinsics", "must be given");
  if (numbers->kind == ConfigNode::Kind::kList && numbers->members.size() == 1)
    numbers = &numbers->members.front().node;
  const auto& models = BasaltModels();
  const auto model = std::find_if(models.begin(), models.end(),
                                  [&](const BasaltModel& each) { return each.camera_type == type->text; });
  if (model == models.end()) {
    Keys valid;
    for (const BasaltModel& each : models) valid.emplace_back(each.camera_type);
    return sheet.Unknown(*type, "camera_type", valid);
  }
  sheet.SetText("model", model->model, type->where);
  sheet.SetMembers(*numbers, {"fx", "fy", "cx", "cy"}, {"fx_px", "fy_px", "cx_px", "cy_px"});
  sheet.SetMembers(*numbers, model->own, model->own);
  // The unified model in Basalt's numbers is the extended one of an ellipsoid that is a sphere.
  if (type->text == "ucm") sheet.SetText("beta", "1", type->where);
  if (const ConfigNode* size = camera.resolution) {
    const Nodes elements = ElementsOf(*size);
    if (elements.size() != 2) return sheet.Wrong(size->where, "resolution", "is not width and height");
    sheet.SetAll(elements, {"width_px", "height_px"});
  }
}

}  // namespace kestrel::vision
