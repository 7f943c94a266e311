// SPDX-License-Identifier: Apache-2.0
#include "sim/instrument/kalibr_imu.h"

#include <algorithm>
#include <array>
#include <string_view>

#include "base/yaml/yaml_fields.h"

namespace kestrel::sim {
namespace {

constexpr std::array<std::string_view, 5> kKeys = {"accelerometer_noise_density", "accelerometer_random_walk",
                                                   "gyroscope_noise_density", "gyroscope_random_walk",
                                                   "update_rate"};

struct KalibrImu {
  ImuParameters& imu;
};

void Fields(FieldVisitor& v, KalibrImu& k) {
  v(Required("accelerometer_noise_density"), k.imu.accelerometer_noise_density, 0.0, 1.0);
  v(Required("accelerometer_random_walk"), k.imu.accelerometer_random_walk, 0.0, 1.0);
  v(Required("gyroscope_noise_density"), k.imu.gyroscope_noise_density, 0.0, 0.1);
  v(Required("gyroscope_random_walk"), k.imu.gyroscope_random_walk, 0.0, 0.1);
  v(Required("update_rate"), k.imu.rate_hz, 1.0, 1000.0);
}

}  // namespace

void ReadKalibrImu(const Config& file, ImuParameters& into, Mistakes& mistakes) {
  Config imu = file;
  // Results are below the name of the IMU.
  if (file.root.members.size() == 1 && file.root.members.front().node.kind == ConfigNode::Kind::kMap)
    imu.root = file.root.members.front().node;
  std::erase_if(imu.root.members, [](const auto& member) {
    return std::find(kKeys.begin(), kKeys.end(), member.key) == kKeys.end();
  });
  KalibrImu kalibr{into};
  Read(imu, kalibr, mistakes);
}

}  // namespace kestrel::sim
