// SPDX-License-Identifier: Apache-2.0
#include "flight/dataset/trajectory/check_trajectory.h"

#include <fmt/format.h>

#include <cmath>
#include <limits>
#include <string>

namespace kestrel::flight {
namespace {

constexpr int kProbes = 20;  // of each piece
constexpr std::size_t kMostBeyond = 20;

struct World {
  double north_m = std::numeric_limits<double>::infinity(),
         west_m = north_m;  // to each side
};

World WorldOf(const sim::SimulatorParameters& simulator) {
  World world;
  const sim::ModelPtr model = sim::MakeModel(simulator.scene, false);
  const int ground = mj_name2id(model.get(), mjOBJ_GEOM, "ground");
  const mjtNum* size = model->geom_size + 3 * ground;  // 0: endless
  if (size[0] > 0) world.north_m = size[0];
  if (size[1] > 0) world.west_m = size[1];
  return world;
}

struct Wrong {
  std::string what, remedy;
};

Wrong Below(const Eigen::Vector3d& p_N) {
  if (p_N.z() < 0) return {};
  return {fmt::format("is {:.3g} m below the ground", p_N.z()), "valid: a height over 0 all along"};
}

Wrong Beyond(const Eigen::Vector3d& p_N, const World& world) {
  if (std::abs(p_N.x()) <= world.north_m && std::abs(p_N.y()) <= world.west_m) return {};
  return {fmt::format("is beyond the world's edge, {:.6g} m north and {:.6g} m east", p_N.x(), p_N.y()),
          fmt::format("valid: within {:g} m to north and south, {:g} m to east and west", world.north_m,
                      world.west_m)};
}

}  // namespace

void CheckTrajectory(const LoadedTrajectory& loaded, const sim::SimulatorParameters& simulator,
                     Mistakes& mistakes) {
  const World world = WorldOf(simulator);
  const auto& stamps = loaded.stamps_ns;
  std::size_t found = 0;
  for (std::size_t i = 0; i < stamps.size() && found < kMostBeyond; ++i) {
    const std::int64_t from = i == 0 ? stamps[0] : stamps[i - 1];
    // Of each kind the first place that is wrong.
    const auto probe = [&](const auto& wrong_at) {
      for (int k = 1; k <= kProbes; ++k) {
        const std::int64_t t = stamps[i] - (stamps[i] - from) / kProbes * (kProbes - k);
        const Wrong wrong = wrong_at(loaded.trajectory.At(t).X_NB.p);
        if (wrong.what.empty()) continue;
        const double since_s = static_cast<double>(t - stamps[0]) * 1e-9;
        mistakes.Add(loaded.places[i], "",
                     fmt::format("the aircraft, {:.3f} s after the first place, {}", since_s, wrong.what),
                     wrong.remedy);
        ++found;
        return;
      }
    };
    probe(Below);
    probe([&](const Eigen::Vector3d& p_N) { return Beyond(p_N, world); });
  }
  const auto refuse = [&](const char* key, const char* what, const char* remedy) {
    mistakes.Add("--in", key, fmt::format("{}, but along a trajectory each frame is drawn by itself", what),
                 remedy);
  };
  if (simulator.image.auto_exposure.target_grey > 0)
    refuse("image.auto_exposure.target_grey", "it follows the frames before", "valid: 0");
  if (!simulator.image.faults.empty()) refuse("image.faults", "faults come and go in a flight", "valid: []");
  if (simulator.scene.deck) refuse("deck", "it moves", "valid: null");
  for (const sim::TargetParameters& target : simulator.targets)
    if (target.velocity_m_s.norm() > 0 || target.roam_m_s > 0)
      return refuse("targets", "one of them moves", "valid: targets at rest");
}

}  // namespace kestrel::flight
