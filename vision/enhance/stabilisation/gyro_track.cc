// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/stabilisation/gyro_track.h"

#include <algorithm>
#include <cmath>

#include "geometry/pose.h"

namespace kestrel::vision {
namespace {

// The turn while the rate goes from one to another, to the third order in time (Magnus).
Eigen::Quaterniond Turn(const Eigen::Vector3d& from, const Eigen::Vector3d& to, double dt_s) {
  return ExpRotation(dt_s * (from + to) / 2 + dt_s * dt_s / 12 * from.cross(to));
}

}  // namespace

GyroTrack::GyroTrack(const std::vector<GyroSample>& samples, double max_gap_s) : max_gap_s_(max_gap_s) {
  for (const GyroSample& sample : samples) Add(sample);
}

void GyroTrack::Add(const GyroSample& sample) {
  if (nodes_.empty()) {
    nodes_.push_back({sample.t_s, sample.w_C, Eigen::Quaterniond::Identity()});
    return;
  }
  const Node& last = nodes_.back();
  const double dt_s = sample.t_s - last.t_s;
  if (!(dt_s > 0)) return;
  nodes_.push_back({sample.t_s, sample.w_C, (last.R_NC * Turn(last.w_C, sample.w_C, dt_s)).normalized()});
}

std::optional<Eigen::Quaterniond> GyroTrack::At(double t_s) const {
  if (nodes_.empty() || !(t_s >= begin_s() && t_s <= end_s())) return std::nullopt;
  const auto after = std::upper_bound(nodes_.begin(), nodes_.end(), t_s,
                                      [](double t, const Node& node) { return t < node.t_s; });
  const Node& from = *std::prev(after);
  if (after == nodes_.end()) return from.R_NC;
  const double gap_s = after->t_s - from.t_s, dt_s = t_s - from.t_s;
  if (gap_s > max_gap_s_ && dt_s > 0) return std::nullopt;
  const Eigen::Vector3d w_C = from.w_C + dt_s / gap_s * (after->w_C - from.w_C);
  return from.R_NC * Turn(from.w_C, w_C, dt_s);
}

std::vector<Eigen::Quaterniond> GyroTrack::Rows(double t_s, double readout_s, int times) const {
  std::vector<Eigen::Quaterniond> rows;
  if (readout_s == 0) times = 1;
  for (int i = 0; i < times; ++i) {
    const auto R_NC = At(t_s + (times > 1 ? readout_s * (static_cast<double>(i) / (times - 1) - 0.5) : 0));
    if (!R_NC) return {};
    rows.push_back(*R_NC);
  }
  return rows;
}

}  // namespace kestrel::vision
