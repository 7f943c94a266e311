// SPDX-License-Identifier: Apache-2.0
#include "vision/camera/file/okvis.h"

#include "vision/camera/file/camera_forms.h"
#include "vision/camera/file/opencv.h"

namespace kestrel::vision {

Keys OkvisCameras(const ConfigNode& root) {
  const ConfigNode* cameras = Find(root, "cameras");
  const bool is = cameras && !cameras->members.empty() && Find(cameras->members.front().node, "focal_length");
  return is ? NumberedCameras(cameras->members.size()) : Keys();
}

void FromOkvis(const ConfigNode& root, std::size_t index, Sheet& sheet) {
  const ConfigNode& camera = Find(root, "cameras")->members[index].node;
  sheet.path = NumberedCameras(index + 1).back();
  sheet.node.where = camera.where;
  sheet.on_imu = Find(camera, "T_SC");
  sheet.SetList(camera, "focal_length", {"fx_px", "fy_px"});
  sheet.SetList(camera, "principal_point", {"cx_px", "cy_px"});
  if (Find(camera, "image_dimension")) sheet.SetList(camera, "image_dimension", {"width_px", "height_px"});

  const ConfigNode *type = Find(camera, "distortion_type"), *list = Find(camera, "distortion_coefficients");
  if (!type) return sheet.Wrong(camera.where, "distortion_type", "must be given");
  if (type->text == "equidistant") {
    sheet.SetText("model", "kannala_brandt", type->where);
    sheet.SetList(camera, "distortion_coefficients", {"k1", "k2", "k3", "k4"});
  } else if (type->text == "radialtangential" || type->text == "radialtangential8") {
    if (!list) return sheet.Wrong(camera.where, "distortion_coefficients", "must be given");
    SetOpenCvDistortion(*list, "distortion_coefficients", sheet);
  } else if (type->text != "none") {  // a pinhole
    sheet.Unknown(*type, "distortion_type", {"none", "radialtangential", "radialtangential8", "equidistant"});
  }
}

}  // namespace kestrel::vision
