// SPDX-License-Identifier: Apache-2.0
#include "vision/camera/file/orb_slam.h"

#include <fmt/format.h>

#include "vision/camera/file/camera_forms.h"

namespace kestrel::vision {
namespace {

// Camera.fx, which later programs write as a map Camera with fx.
const ConfigNode* FindDotted(const ConfigNode& root, const std::string& group, const std::string& key) {
  if (const ConfigNode* found = Find(root, fmt::format("{}.{}", group, key))) return found;
  const ConfigNode* map = Find(root, group);
  return map ? Find(*map, key) : nullptr;
}

std::vector<std::string> Groups(const ConfigNode& root) {
  std::vector<std::string> groups;
  for (const char* group : {"Camera", "Camera1", "Camera2"})
    if (FindDotted(root, group, "fx")) groups.emplace_back(group);
  return groups;
}

const ConfigNode* FirstOf(const ConfigNode& root, const Keys& groups, const Keys& keys) {
  for (const std::string& group : groups)
    for (const std::string& key : keys)
      if (const ConfigNode* found = FindDotted(root, group, key)) return found;
  return nullptr;
}

}  // namespace

Keys OrbSlamCameras(const ConfigNode& root) { return NumberedCameras(Groups(root).size()); }

void FromOrbSlam(const ConfigNode& root, std::size_t index, Sheet& sheet) {
  const std::string group = Groups(root)[index];
  const auto set = [&](const Keys& theirs, const Keys& ours, bool required) {
    for (std::size_t i = 0; i < theirs.size(); ++i) {
      if (const ConfigNode* found = FindDotted(root, group, theirs[i]))
        sheet.Set(ours[i], *found);
      else if (required)
        sheet.Wrong(root.where, fmt::format("{}.{}", group, theirs[i]), "must be given");
    }
  };
  const ConfigNode* type = FirstOf(root, {"Camera", group}, {"type", "model"});
  const bool fisheye = type && (type->text == "KannalaBrandt8" || type->text == "fisheye");
  const bool rectified = type && type->text == "Rectified";
  const bool pinhole =
      !type || type->text == "PinHole" || type->text == "Pinhole" || type->text == "perspective";
  if (!fisheye && !rectified && !pinhole)
    return sheet.Unknown(*type, "Camera.type", {"PinHole", "KannalaBrandt8", "Rectified"});
  if (!type && FindDotted(root, group, "k4"))
    return sheet.Wrong(root.where, "Camera.type", "must be given, since there is k4",
                       "valid: KannalaBrandt8 for k1 to k4 of a fisheye");
  sheet.SetText("model", fisheye ? "kannala_brandt" : rectified ? "pinhole" : "brown_conrady", root.where);
  set({"fx", "fy", "cx", "cy"}, {"fx_px", "fy_px", "cx_px", "cy_px"}, true);
  if (fisheye) set({"k1", "k2", "k3", "k4"}, {"k1", "k2", "k3", "k4"}, true);
  if (!fisheye && !rectified) set({"k1", "k2", "p1", "p2", "k3"}, {"k1", "k2", "p1", "p2", "k3"}, false);
  if (index == 0) sheet.on_imu = FindAny(root, {"IMU.T_b_c1", "Tbc"});  // of the first alone
  sheet.SetSize(FirstOf(root, {"Camera", group}, {"width", "cols"}),
                FirstOf(root, {"Camera", group}, {"height", "rows"}));
}

}  // namespace kestrel::vision
