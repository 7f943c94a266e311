// SPDX-License-Identifier: Apache-2.0
#include "records/mcap/camera_info.h"

#include <map>
#include <string_view>

namespace kestrel::records {

ros::CameraInfo CameraInfoOf(const vision::CameraModel& camera) {
  static const std::map<std::string_view, const char*> kNames = {{"pinhole", "plumb_bob"},
                                                                 {"brown_conrady", "plumb_bob"},
                                                                 {"kannala_brandt", "equidistant"},
                                                                 {"rational", "rational_polynomial"}};
  ros::CameraInfo info;
  info.width = static_cast<std::uint32_t>(vision::WidthPx(camera));
  info.height = static_cast<std::uint32_t>(vision::HeightPx(camera));
  const auto known = kNames.find(vision::NameOf(camera));
  info.distortion_model = known == kNames.end() ? vision::NameOf(camera) : known->second;
  const Eigen::VectorXd all = vision::Parameters(camera);
  info.d.assign(all.data() + 4, all.data() + all.size());
  if (info.distortion_model == "plumb_bob") info.d.resize(5, 0);
  info.k = {all[0], 0, all[2], 0, all[1], all[3], 0, 0, 1};
  info.r = {1, 0, 0, 0, 1, 0, 0, 0, 1};
  info.p = {all[0], 0, all[2], 0, 0, all[1], all[3], 0, 0, 0, 1, 0};
  return info;
}

}  // namespace kestrel::records
