// SPDX-License-Identifier: Apache-2.0
#include "vision/camera/file/aslam.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "vision/camera/file/camera_forms.h"

namespace kestrel::vision {
namespace {

struct AslamModel {
  const char *type, *distortion, *model;
  Keys intrinsics, parameters;
};

const std::vector<AslamModel>& AslamModels() {
  static const std::vector<AslamModel> kModels = [] {
    const Keys pinhole{"fx_px", "fy_px", "cx_px", "cy_px"};
    const Keys sphere{"xi", "fx_px", "fy_px", "cx_px", "cy_px"};
    const Keys radtan{"k1", "k2", "p1", "p2"}, equi{"k1", "k2", "k3", "k4"};
    return std::vector<AslamModel>{{"pinhole", "none", "pinhole", pinhole, {}},
                                   {"pinhole", "radial-tangential", "brown_conrady", pinhole, radtan},
                                   {"pinhole", "equidistant", "kannala_brandt", pinhole, equi},
                                   {"pinhole", "fisheye", "fov", pinhole, {"w"}},
                                   {"unified-projection", "none", "unified", sphere, {}},
                                   {"unified-projection", "radial-tangential", "unified", sphere, radtan}};
  }();
  return kModels;
}

const ConfigNode* ListOfCameras(const ConfigNode& root) {
  const auto of = [](const ConfigNode& node) {
    const ConfigNode* cameras = Find(node, "cameras");
    return cameras && !cameras->members.empty() && Find(cameras->members.front().node, "camera") ? cameras
                                                                                                 : nullptr;
  };
  if (const ConfigNode* cameras = of(root)) return cameras;
  if (const ConfigNode* sensors = Find(root, "sensors")) {
    for (const auto& [index, sensor] : sensors->members)
      if (const ConfigNode* cameras = of(sensor)) return cameras;
  }
  return nullptr;
}

}  // namespace

Keys AslamCameras(const ConfigNode& root) {
  const ConfigNode* cameras = ListOfCameras(root);
  return cameras ? NumberedCameras(cameras->members.size()) : Keys();
}

void FromAslam(const ConfigNode& root, std::size_t index, Sheet& sheet) {
  sheet.path = NumberedCameras(index + 1).back();
  const ConfigNode& element = ListOfCameras(root)->members[index].node;
  const ConfigNode* camera = Find(element, "camera");
  if (!camera) return sheet.Wrong(element.where, "camera", "must be given");
  sheet.node.where = camera->where;
  sheet.on_imu = Find(element, "T_B_C");
  const ConfigNode *type = Find(*camera, "type"), *distortion = Find(*camera, "distortion");
  if (!type) return sheet.Wrong(camera->where, "type", "must be given");
  const std::string distorted = distortion ? TextOf(*distortion, "type") : "none";
  const auto& models = AslamModels();
  const auto model = std::find_if(models.begin(), models.end(), [&](const AslamModel& each) {
    return each.type == type->text && each.distortion == distorted;
  });
  if (model == models.end()) {
    Keys valid;
    for (const AslamModel& each : models) valid.push_back(fmt::format("{}, {}", each.type, each.distortion));
    return sheet.Wrong(type->where, "type",
                       fmt::format("'{}' with the distortion '{}' is not known here", type->text, distorted),
                       fmt::format("valid: {}", fmt::join(valid, "; ")));
  }
  sheet.SetText("model", model->model, type->where);
  sheet.SetList(*camera, "intrinsics", model->intrinsics);
  if (distortion && !model->parameters.empty()) sheet.SetList(*distortion, "parameters", model->parameters);
  sheet.SetSize(Find(*camera, "image_width"), Find(*camera, "image_height"));
}

}  // namespace kestrel::vision
