// SPDX-License-Identifier: Apache-2.0
#include "sim/aircraft/multirotor_shape.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace kestrel::sim {
namespace {

constexpr const char* kSeen = R"(group="1" contype="0" conaffinity="0")";
constexpr const char* kDark = "0.12 0.12 0.13 1";

}  // namespace

std::string MultirotorShape(const MultirotorParameters& p) {
  const RotorLayout layout = LayoutOf(p);
  double reach = 0;
  for (std::size_t i = 0; i < layout.count; ++i) reach = std::max(reach, layout.hubs_B[i].head<2>().norm());
  const double size = reach / 0.21;  // to the Pelican
  const double foot = std::max(0.15, 0.15 * size), skid = 0.14 * size, track = 0.13 * size, hub = 0.06 * size;

  std::string text = fmt::format(
      "<mujocoinclude><body name=\"vehicle\" pos=\"0 0 {:.6g}\"><freejoint name=\"vehicle\"/>\n"
      "<inertial pos=\"0 0 0\" mass=\"1\" diaginertia=\"0.01 0.01 0.02\"/>\n"
      "<site name=\"camera_mount\" pos=\"0 0 -0.05\" size=\"0.004\" group=\"4\"/>\n",
      foot + 0.01);
  for (const double side : {1.0, -1.0}) {
    const char* name = side > 0 ? "left" : "right";
    text += fmt::format(
        "<geom name=\"vehicle_skid_{}\" type=\"capsule\" fromto=\"{:.6g} {:.6g} {:.6g} {:.6g} {:.6g} "
        "{:.6g}\" "
        "size=\"0.01\" group=\"0\" friction=\"0.9 0.01 0.001\" condim=\"4\" solref=\"0.02 1.2\" "
        "solimp=\"0.9 0.95 0.005\" rgba=\"{}\"/>\n",
        name, -skid, side * track, -foot, skid, side * track, -foot, kDark);
    for (const double along : {1.0, -1.0})
      text += fmt::format(
          "<geom name=\"vehicle_leg_{}_{}\" type=\"capsule\" fromto=\"{:.6g} {:.6g} -0.02 {:.6g} {:.6g} "
          "{:.6g}\" "
          "size=\"0.005\" {} rgba=\"{}\"/>\n",
          along > 0 ? "front" : "back", name, along * 0.64 * skid, side * hub, along * 0.64 * skid,
          side * track, -foot, kSeen, kDark);
  }
  text += fmt::format(
      "<geom name=\"vehicle_hub\" type=\"box\" pos=\"0 0 -0.01\" size=\"{:.6g} {:.6g} 0.012\" {} "
      "rgba=\"0.16 0.17 0.19 1\"/>\n",
      1.25 * hub, hub, kSeen);
  double front = -reach;
  for (std::size_t i = 0; i < layout.count; ++i) front = std::max(front, layout.hubs_B[i].x());
  for (std::size_t i = 0; i < layout.count; ++i) {
    const double x = layout.hubs_B[i].x(), y = -layout.hubs_B[i].y(),
                 z = -layout.hubs_B[i].z();  // y left, z up
    if (std::hypot(x, y) > 0.02)
      text += fmt::format(
          "<geom name=\"vehicle_arm_{}\" type=\"capsule\" fromto=\"0 0 0.008 {:.6g} {:.6g} 0.008\" "
          "size=\"0.008\" {} "
          "rgba=\"0.1 0.1 0.11 1\"/>\n",
          i + 1, x, y, kSeen);
    text += fmt::format(
        "<geom name=\"vehicle_motor_{}\" type=\"cylinder\" pos=\"{:.6g} {:.6g} {:.6g}\" size=\"0.015 "
        "0.0225\" {} "
        "rgba=\"0.3 0.3 0.32 1\"/>\n"
        "<geom name=\"vehicle_rotor_{}\" type=\"cylinder\" pos=\"{:.6g} {:.6g} {:.6g}\" size=\"{:.6g} "
        "0.001\" {} "
        "rgba=\"{} 0.3\"/>\n",
        i + 1, x, y, z - 0.0275, kSeen, i + 1, x, y, z, p.rotor.radius_m, kSeen,
        x > front - 0.3 * reach ? "0.95 0.45 0.1" : "0.7 0.7 0.72");
  }
  return text + "</body></mujocoinclude>\n";
}

}  // namespace kestrel::sim
