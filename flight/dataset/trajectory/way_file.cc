// SPDX-License-Identifier: Apache-2.0
#include "flight/dataset/trajectory/way_file.h"

#include <fmt/format.h>

#include <cmath>

#include "base/yaml/yaml_fields.h"
#include "flight/dataset/trajectory/conventions.h"
#include "geometry/tait_bryan.h"

namespace kestrel::flight {
namespace {

constexpr double kSlowest_m_s = 0.01;  // with a direction to look along
constexpr std::int64_t kProbe_ns = 10'000'000;

std::vector<Place> PlacesOf(const Config& config, std::size_t count) {
  std::vector<Place> places;
  for (const auto& member : config.root.members)
    if (member.key == "way")
      for (const auto& each : member.node.members) places.push_back(each.node.where);
  places.resize(count, config.root.where);
  return places;
}

void CheckTimes(const std::vector<WayPoint>& way, const std::vector<Place>& places, Mistakes& mistakes) {
  for (std::size_t i = 1; i < way.size(); ++i)
    if (way[i].t_s <= way[i - 1].t_s)
      mistakes.Add(places[i], fmt::format("way[{}].t_s", i),
                   fmt::format("{:g} is not after {:g}", way[i].t_s, way[i - 1].t_s),
                   "valid: a later time than that of the place before");
}

// Where it looks along the way it has to move.
void CheckMoves(const LoadedTrajectory& loaded, Mistakes& mistakes) {
  for (std::size_t i = 1; i < loaded.stamps_ns.size(); ++i) {
    for (std::int64_t t = loaded.stamps_ns[i - 1]; t <= loaded.stamps_ns[i]; t += kProbe_ns) {
      const double speed_m_s = loaded.trajectory.At(t).v_N.head<2>().norm();
      if (speed_m_s > kSlowest_m_s) continue;
      mistakes.Add(loaded.places[i], "look",
                   fmt::format("along, but at {:.2f} s the way does not move "
                               "horizontally ({:.2g} m/s)",
                               static_cast<double>(t - kBegin_ns) * 1e-9, speed_m_s),
                   "valid: given, with yaw_deg, or places farther apart");
      break;
    }
  }
}

}  // namespace

LoadedTrajectory LoadWay(const std::filesystem::path& file) {
  Mistakes mistakes;
  WayFile way;
  const Config config = LoadConfig(file, {}, mistakes);
  Read(config, way, mistakes);
  mistakes.ThrowIfAny();
  const std::vector<Place> places = PlacesOf(config, way.way.size());
  if (way.way.size() < 2)
    mistakes.Add(file.string(), "way", fmt::format("leads through {} places", way.way.size()),
                 "valid: two or more");
  CheckTimes(way.way, places, mistakes);
  mistakes.ThrowIfAny();
  std::vector<std::int64_t> stamps;
  std::vector<Eigen::Vector3d> p_N, angles;
  for (const WayPoint& p : way.way) {
    stamps.push_back(kBegin_ns + std::llround(p.t_s * 1e9));
    p_N.emplace_back(p.position_m.x(), p.position_m.y(), -p.position_m.z());
    angles.emplace_back(Radians(p.yaw_deg), Radians(p.pitch_deg), Radians(p.roll_deg));
  }
  const bool along = way.look == "along";
  LoadedTrajectory loaded{Trajectory(stamps, p_N, angles, along), stamps, places};
  if (along) CheckMoves(loaded, mistakes);
  mistakes.ThrowIfAny();
  return loaded;
}

}  // namespace kestrel::flight
