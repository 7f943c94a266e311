// SPDX-License-Identifier: Apache-2.0
#include "sim/camera/camera_faults.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "base/random.h"

namespace kestrel::sim {
namespace {

constexpr double kClock_s = 1e-9;  // times are multiples of a step, but for rounding

struct Stretch {
  double from_s, until_s;
  const CameraFault* fault;
};

// The stretches of time in which one fault is there.
void Append(const CameraFault& fault, RandomStream random, double duration_s, std::vector<Stretch>& all) {
  if (random.Uniform(0, 1) >= fault.probability) return;
  if (fault.rate_per_min <= 0) return all.push_back({fault.from_s, fault.until_s, &fault});
  constexpr double kDrawn_s = 36000;  // a flight without an end has them for so long
  const double last_s = std::min({fault.until_s, duration_s, kDrawn_s});
  for (double t = fault.from_s;;) {
    t += -std::log1p(-random.Uniform(0, 1)) * 60 / fault.rate_per_min;
    if (t >= last_s) return;
    all.push_back({t, std::min(t + fault.length_s, fault.until_s), &fault});
    t += fault.length_s;
  }
}

void Join(const CameraFault& fault, CameraCondition& c) {
  if (fault.type == "off") c.off = true;
  if (fault.type == "stuck") c.stuck = true;
  if (fault.type == "garbage") c.garbage = true;
  if (fault.type == "intermittent") c.loss = 1 - (1 - c.loss) * (1 - fault.loss);
  if (fault.type == "slow") c.period_s = std::max(c.period_s, 1 / fault.rate_hz);
  if (fault.type == "delayed") c.delay_s += fault.delay_s;
}

}  // namespace

CameraFaults::CameraFaults(const std::vector<CameraFault>& faults, std::uint64_t seed, double duration_s)
    : seed_(RandomStream(seed, "camera frame losses").Bits()), conditions_(1) {
  std::vector<Stretch> stretches;
  for (std::size_t i = 0; i < faults.size(); ++i)
    Append(faults[i], RandomStream(seed, fmt::format("camera fault {}", i)), duration_s, stretches);

  std::vector<double> changes;
  for (const Stretch& s : stretches) changes.insert(changes.end(), {s.from_s, s.until_s});
  std::sort(changes.begin(), changes.end());
  changes.erase(std::unique(changes.begin(), changes.end()), changes.end());
  std::sort(stretches.begin(), stretches.end(),
            [](const Stretch& a, const Stretch& b) { return a.from_s < b.from_s; });
  std::vector<Stretch> present;
  auto next = stretches.begin();
  for (const double t : changes) {
    for (; next != stretches.end() && next->from_s <= t; ++next) present.push_back(*next);
    std::erase_if(present, [&](const Stretch& s) { return s.until_s <= t; });
    CameraCondition c;
    std::vector<std::string> names;
    for (const Stretch& s : present) {
      Join(*s.fault, c);
      if (std::find(names.begin(), names.end(), s.fault->type) == names.end()) names.push_back(s.fault->type);
    }
    std::sort(names.begin(), names.end());
    if (!names.empty()) c.name = fmt::format("{}", fmt::join(names, " + "));
    c.from_s = t;
    conditions_.push_back(std::move(c));
  }
}

void CameraFaults::Change(const CameraFaults& later, double t_s) {
  CameraCondition now = later.At(t_s);
  now.from_s = At(t_s).from_s;
  const bool differs = now != At(t_s);
  conditions_.erase(conditions_.begin() + 1 + static_cast<std::ptrdiff_t>(ChangesUntil(t_s).size()),
                    conditions_.end());
  now.from_s = t_s;
  if (differs) conditions_.push_back(std::move(now));
  conditions_.insert(
      conditions_.end(),
      later.conditions_.begin() + 1 + static_cast<std::ptrdiff_t>(later.ChangesUntil(t_s).size()),
      later.conditions_.end());
}

const CameraCondition& CameraFaults::At(double t_s) const { return conditions_[ChangesUntil(t_s).size()]; }

std::span<const CameraCondition> CameraFaults::ChangesUntil(double t_s) const {
  const auto end = std::upper_bound(conditions_.begin() + 1, conditions_.end(), t_s + kClock_s,
                                    [](double t, const CameraCondition& c) { return t < c.from_s; });
  return {conditions_.begin() + 1, end};
}

bool CameraFaults::Loses(const CameraCondition& condition, std::int64_t tick) const {
  const std::uint64_t drawn = RandomStream::Mix(seed_ ^ RandomStream::Mix(static_cast<std::uint64_t>(tick)));
  return static_cast<double>(drawn >> 11) * 0x1p-53 < condition.loss;
}

}  // namespace kestrel::sim
