// SPDX-License-Identifier: Apache-2.0
#include "sim/carried_path.h"

#include <fmt/format.h>

#include <algorithm>

#include "geometry/tait_bryan.h"

namespace kestrel::sim {

void CheckCarry(const CarryParameters& parameters, const Place& where, Mistakes& mistakes) {
  const std::vector<CarryPoint>& points = parameters.points;
  if (points.empty()) mistakes.Add(where, "carry.points", "names no place", "valid: one at least");
  for (std::size_t i = 0; i < points.size(); ++i) {
    const std::string key = fmt::format("carry.points[{}]", i);
    if (i > 0 && points[i].t_s <= points[i - 1].t_s)
      mistakes.Add(where, key + ".t_s",
                   fmt::format("{:g} is not after {:g}", points[i].t_s, points[i - 1].t_s),
                   "valid: a later time than that of the place before");
    if (points[i].position_m.z() <= 0)
      mistakes.Add(where, key + ".position_m",
                   fmt::format("{:g} m above the ground", points[i].position_m.z()),
                   "valid: a height over 0");
  }
  for (const vision::VibrationBand& band : parameters.tremor)
    if (band.until_hz < band.from_hz)
      mistakes.Add(where, "carry.tremor",
                   fmt::format("a band from {:g} Hz to {:g} Hz", band.from_hz, band.until_hz),
                   "valid: until_hz no less than from_hz");
}

CarriedPath::CarriedPath(const CarryParameters& parameters, std::uint64_t seed)
    : points_(parameters.points), tremor_(parameters.tremor, seed, "hand tremor") {}

Pose CarriedPath::X_NB(double t_s) const {
  const auto next =
      std::find_if(points_.begin(), points_.end(), [&](const CarryPoint& p) { return p.t_s > t_s; });
  const CarryPoint& to = next == points_.end() ? points_.back() : *next;
  const CarryPoint& from = next == points_.begin() ? to : *(next - 1);
  const double x = to.t_s > from.t_s ? (t_s - from.t_s) / (to.t_s - from.t_s) : 1;
  const double share = x * x * x * (10 - 15 * x + 6 * x * x);
  const Eigen::Vector3d p = from.position_m + share * (to.position_m - from.position_m);
  const Pose still{HeadingRotation(Radians(from.yaw_deg + share * (to.yaw_deg - from.yaw_deg))),
                   {p.x(), p.y(), -p.z()}};
  return still * tremor_.At(t_s);
}

}  // namespace kestrel::sim
