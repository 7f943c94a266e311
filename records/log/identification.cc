// SPDX-License-Identifier: Apache-2.0
#include "records/log/identification.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <utility>

namespace kestrel::records {
namespace {

constexpr double kGrid_s = 0.02, kLongestGap_s = 1, kLeast_s = 8, kLongestDelay_s = 1.5;
constexpr int kParts = 6;
constexpr double kLeastExplained = 0.5, kLeastGain = 0.4, kMaxGainSd = 0.3, kLongestLag_s = 2.5;
constexpr double kDegree = std::numbers::pi / 180;

// At even times; not a number in a gap.
struct EvenSeries {
  std::vector<double> wanted, flown;
};

EvenSeries Even(const Asked& a) {
  EvenSeries even;
  if (a.wanted_s.empty() || a.flown_s.size() < 2) return even;
  const double begin = std::max(a.wanted_s.front(), a.flown_s.front()),
               end = std::min(a.wanted_s.back(), a.flown_s.back());
  constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
  std::size_t w = 0, f = 0;
  for (double t = begin; t < end && even.wanted.size() < 500000; t += kGrid_s) {
    while (w + 1 < a.wanted_s.size() && a.wanted_s[w + 1] <= t) ++w;
    while (f + 2 < a.flown_s.size() && a.flown_s[f + 1] <= t) ++f;
    const double between = a.flown_s[f + 1] - a.flown_s[f];
    const bool gap = t - a.wanted_s[w] > kLongestGap_s || between > kLongestGap_s || between <= 0;
    even.wanted.push_back(gap ? kNone : a.wanted[w]);
    even.flown.push_back(gap ? kNone
                             : a.flown[f] + (a.flown[f + 1] - a.flown[f]) * (t - a.flown_s[f]) / between);
  }
  return even;
}

struct Fitted {
  double delay = 0, lag = 0, gain = 0, error = std::numeric_limits<double>::infinity(), variance = 0;
  int samples = 0;
};

// left_out: a part of kParts, or none.
Fitted FitOne(const EvenSeries& e, double delay_s, double lag_s, int left_out) {
  const auto late = static_cast<std::size_t>(std::lround(delay_s / kGrid_s));
  const double keep = lag_s > 0 ? std::exp(-kGrid_s / lag_s) : 0;
  const auto settle = static_cast<int>(3 * lag_s / kGrid_s);
  double x = 0, sx = 0, sy = 0, sxx = 0, sxy = 0, syy = 0;
  int since = -1, n = 0;
  for (std::size_t i = late; i < e.flown.size(); ++i) {
    const double u = e.wanted[i - late], y = e.flown[i];
    if (!std::isfinite(u)) {
      since = -1;
      continue;
    }
    x = since < 0 ? u : keep * x + (1 - keep) * u;
    ++since;
    if (since < settle || !std::isfinite(y)) continue;
    if (static_cast<int>(i * kParts / e.flown.size()) == left_out) continue;
    sx += x, sy += y, sxx += x * x, sxy += x * y, syy += y * y, ++n;
  }
  Fitted fit{.delay = delay_s, .lag = lag_s, .samples = n};
  if (n < 10) return fit;
  const double vx = sxx / n - sx / n * (sx / n), vxy = sxy / n - sx / n * (sy / n);
  fit.variance = syy / n - sy / n * (sy / n);
  if (vx < 1e-12) return fit;
  fit.gain = vxy / vx;
  fit.error = fit.variance - vxy * vxy / vx;
  return fit;
}

Fitted Best(const EvenSeries& e, int left_out) {
  Fitted best;
  const auto consider = [&](double delay, double lag) {
    if (delay < 0 || delay > kLongestDelay_s || lag < 0) return;
    const Fitted fit = FitOne(e, std::round(delay / kGrid_s) * kGrid_s, lag, left_out);
    if (fit.error < best.error) best = fit;
  };
  for (double delay = 0; delay <= kLongestDelay_s; delay += 0.1)
    for (double lag = 0.02; lag < 3; lag *= 1.5) consider(delay, lag);
  for (const double factor : {1.2, 1.08, 1.03, 1.01}) {
    const Fitted from = best;
    for (int i = -4; i <= 4; ++i)
      for (int j = -3; j <= 3; ++j) consider(from.delay + i * kGrid_s, from.lag * std::pow(factor, j));
  }
  return best;
}

Estimate Jackknifed(double value, const std::vector<double>& without) {
  double mean = 0, sum = 0;
  for (const double each : without) mean += each / static_cast<double>(without.size());
  for (const double each : without) sum += (each - mean) * (each - mean);
  return {value,
          std::sqrt(sum * (static_cast<double>(without.size()) - 1) / static_cast<double>(without.size()))};
}

const std::vector<double>* Column(const LogTables& tables, std::string_view table, std::string_view column) {
  const auto found = tables.find(table);
  if (found == tables.end()) return nullptr;
  const auto values = found->second.find(column);
  const auto times = found->second.find("t_s");
  if (values == found->second.end() || times == found->second.end() ||
      times->second.size() != values->second.size())
    return nullptr;
  return &values->second;
}

void AddResponse(std::vector<Identified>& all, const std::string& of, const Asked& asked, double least) {
  std::string why;
  const Response r = FitResponse(asked, least, why);
  all.push_back({of + ", late by", "s", r.late_s, why});
  if (!why.empty()) return;
  all.push_back({of + ", of that dead time", "s", r.delay_s, ""});
  all.push_back({of + ", of that lag", "s", r.lag_s, ""});
  all.push_back({of + ", gain", "", r.gain, ""});
}

// Of messages that hold both.
void AddColumns(std::vector<Identified>& all, const std::string& of, const LogTables& tables,
                std::string_view wanted_in, std::string_view wanted, std::string_view flown_in,
                std::string_view flown, double least) {
  const auto* w = Column(tables, wanted_in, wanted);
  const auto* f = Column(tables, flown_in, flown);
  if (!w || !f) {
    all.push_back({of + ", late by",
                   "s",
                   {},
                   w ? fmt::format("the log holds no {}.{}", flown_in, flown)
                     : fmt::format("the log holds no {}.{}", wanted_in, wanted)});
    return;
  }
  AddResponse(all, of, {*Column(tables, wanted_in, "t_s"), *w, *Column(tables, flown_in, "t_s"), *f}, least);
}

// Throttle where it neither climbs nor sinks: its mean over each part, weighed alike.
void AddHoverThrust(std::vector<Identified>& all, const std::vector<double>& thrust_s,
                    const std::vector<double>& thrust, const std::vector<double>& climb_s,
                    const std::vector<double>& climb) {
  Identified found{"hover thrust", "of full", {}, ""};
  std::vector<double> level;
  std::size_t c = 0;
  for (std::size_t i = 0; i < thrust.size() && !climb.empty(); ++i) {
    while (c + 1 < climb_s.size() && climb_s[c + 1] <= thrust_s[i]) ++c;
    if (std::abs(climb[c]) < 0.15 && thrust[i] > 0.05 && std::abs(climb_s[c] - thrust_s[i]) < kLongestGap_s)
      level.push_back(thrust[i]);
  }
  if (level.size() < 50) {
    found.missing = "the log holds too little of thrust while it neither climbs nor sinks";
  } else {
    double sum = 0;
    std::vector<double> parts(kParts, 0), counts(kParts, 0), without;
    for (std::size_t i = 0; i < level.size(); ++i) {
      sum += level[i];
      parts[i * kParts / level.size()] += level[i], ++counts[i * kParts / level.size()];
    }
    const auto n = static_cast<double>(level.size());
    for (std::size_t part = 0; part < kParts; ++part)
      without.push_back((sum - parts[part]) / (n - counts[part]));
    found.value = Jackknifed(sum / n, without);
  }
  all.push_back(found);
}

// Roll and pitch, rad, of quaternions w, x, y, z.
std::vector<double> RollOf(const std::vector<double>* q[4]) {
  std::vector<double> angle;
  for (std::size_t i = 0; i < q[0]->size(); ++i) {
    const double w = (*q[0])[i], x = (*q[1])[i], y = (*q[2])[i], z = (*q[3])[i];
    angle.push_back(std::atan2(2 * (w * x + y * z), 1 - 2 * (x * x + y * y)));
  }
  return angle;
}
std::vector<double> PitchOf(const std::vector<double>* q[4]) {
  std::vector<double> angle;
  for (std::size_t i = 0; i < q[0]->size(); ++i)
    angle.push_back(
        std::asin(std::clamp(2 * ((*q[0])[i] * (*q[2])[i] - (*q[3])[i] * (*q[1])[i]), -1.0, 1.0)));
  return angle;
}

}  // namespace

Response FitResponse(const Asked& asked, double least_movement, std::string& why) {
  const EvenSeries even = Even(asked);
  double sum = 0, squares = 0;
  int n = 0;
  for (const double each : even.wanted)
    if (std::isfinite(each)) sum += each, squares += each * each, ++n;
  Response r;
  if (n * kGrid_s < kLeast_s) {
    why = fmt::format("the log holds {:.1f} s of it, and {:g} s are needed", n * kGrid_s, kLeast_s);
    return r;
  }
  const double moved = std::sqrt(std::max(0.0, squares / n - sum / n * (sum / n)));
  if (moved < least_movement) {
    why =
        fmt::format("what was asked for hardly moved: {:.3g} rms, and {:g} is needed", moved, least_movement);
    return r;
  }
  const Fitted best = Best(even, -1);
  r.explained = best.variance > 0 ? 1 - best.error / best.variance : 0;
  if (!(r.explained >= kLeastExplained)) {
    why = fmt::format("a lag explains {:.0f} % of what was flown, and {:.0f} % are needed: gusts, or a limit",
                      100 * std::max(0.0, r.explained), 100 * kLeastExplained);
    return r;
  }
  std::vector<double> delays, lags, lates, gains;
  for (int part = 0; part < kParts; ++part) {
    const Fitted fit = Best(even, part);
    delays.push_back(fit.delay), lags.push_back(fit.lag), gains.push_back(fit.gain);
    lates.push_back(fit.delay + fit.lag);
  }
  r.delay_s = Jackknifed(best.delay, delays);
  r.lag_s = Jackknifed(best.lag, lags);
  r.late_s = Jackknifed(best.delay + best.lag, lates);
  r.gain = Jackknifed(best.gain, gains);
  if (best.gain < kLeastGain || best.gain > 1 / kLeastGain || r.gain.sd > kMaxGainSd ||
      best.lag > kLongestLag_s || best.delay > kLongestDelay_s - kGrid_s) {
    why =
        fmt::format("what was flown does not follow what was asked for: gain {:.2g} +- {:.2g}, {:.2g} s late",
                    best.gain, r.gain.sd, best.delay + best.lag);
    return r;
  }
  // the times are searched on a grid
  const double least = kGrid_s / std::sqrt(12.0);
  for (Estimate* each : {&r.delay_s, &r.lag_s, &r.late_s}) each->sd = std::hypot(each->sd, least);
  return r;
}

std::vector<Identified> IdentifyUlog(const LogTables& t) {
  std::vector<Identified> all;
  for (const auto& [of, column] :
       {std::pair{"velocity north", "vx"}, {"velocity east", "vy"}, {"velocity down", "vz"}})
    AddColumns(all, of, t, "vehicle_local_position_setpoint", column, "vehicle_local_position", column, 0.1);
  const std::vector<double>*q[4], *wanted[4];
  bool has = true;
  for (int i = 0; i < 4; ++i) {
    q[i] = Column(t, "vehicle_attitude", fmt::format("q[{}]", i));
    wanted[i] = Column(t, "vehicle_attitude_setpoint", fmt::format("q_d[{}]", i));
    has = has && q[i] && wanted[i];
  }
  if (has) {
    const auto &ws = *Column(t, "vehicle_attitude_setpoint", "t_s"),
               &fs = *Column(t, "vehicle_attitude", "t_s");
    AddResponse(all, "roll", {ws, RollOf(wanted), fs, RollOf(q)}, 0.5 * kDegree);
    AddResponse(all, "pitch", {ws, PitchOf(wanted), fs, PitchOf(q)}, 0.5 * kDegree);
  } else {
    for (const char* of : {"roll", "pitch"})
      all.push_back({fmt::format("{}, late by", of),
                     "s",
                     {},
                     "the log holds no vehicle_attitude.q or vehicle_attitude_setpoint.q_d"});
  }
  const auto* thrust = Column(t, "vehicle_attitude_setpoint", "thrust_body[2]");
  const auto* climb = Column(t, "vehicle_local_position", "vz");
  if (thrust && climb) {
    std::vector<double> up;
    for (const double each : *thrust) up.push_back(-each);
    AddHoverThrust(all, *Column(t, "vehicle_attitude_setpoint", "t_s"), up,
                   *Column(t, "vehicle_local_position", "t_s"), *climb);
  } else {
    all.push_back({"hover thrust", "of full", {}, "the log holds no vehicle_attitude_setpoint.thrust_body"});
  }
  return all;
}

std::vector<Identified> IdentifyDataFlash(const LogTables& t) {
  std::vector<Identified> all;
  AddColumns(all, "velocity north", t, "PSCN", "TVN", "PSCN", "VN", 0.1);
  AddColumns(all, "velocity east", t, "PSCE", "TVE", "PSCE", "VE", 0.1);
  AddColumns(all, "velocity down", t, "PSCD", "TVD", "PSCD", "VD", 0.1);
  AddColumns(all, "roll", t, "ATT", "DesRoll", "ATT", "Roll", 0.5);
  AddColumns(all, "pitch", t, "ATT", "DesPitch", "ATT", "Pitch", 0.5);
  const auto *thrust = Column(t, "CTUN", "ThO"), *climb = Column(t, "PSCD", "VD");
  if (thrust && climb)
    AddHoverThrust(all, *Column(t, "CTUN", "t_s"), *thrust, *Column(t, "PSCD", "t_s"), *climb);
  else
    all.push_back({"hover thrust", "of full", {}, "the log holds no CTUN.ThO or no PSCD.VD"});
  return all;
}

std::vector<Identified> IdentifyTelemetry(const LogTable& table) {
  std::vector<Identified> all;
  const auto column = [&](const char* name) {
    const auto found = table.find(name);
    return found == table.end() ? std::vector<double>() : found->second;
  };
  const auto t = column("t_s"), yaw = column("estimate_yaw_deg"), vx = column("estimate_vx_m_s"),
             vy = column("estimate_vy_m_s"), vz = column("estimate_vz_m_s");
  std::vector<double> forward, right;
  if (!yaw.empty() && vx.size() == yaw.size() && vy.size() == yaw.size())
    for (std::size_t i = 0; i < yaw.size(); ++i) {
      const double c = std::cos(yaw[i] * kDegree), s = std::sin(yaw[i] * kDegree);
      forward.push_back(c * vx[i] + s * vy[i]), right.push_back(c * vy[i] - s * vx[i]);
    }
  const auto add = [&](const std::string& of, const char* wanted_column, const std::vector<double>& flown,
                       double least) {
    Asked asked;
    const auto wanted = column(wanted_column);
    for (std::size_t i = 0; i < t.size() && i < wanted.size() && i < flown.size(); ++i) {
      if (std::isfinite(wanted[i])) asked.wanted_s.push_back(t[i]), asked.wanted.push_back(wanted[i]);
      if (std::isfinite(flown[i])) asked.flown_s.push_back(t[i]), asked.flown.push_back(flown[i]);
    }
    AddResponse(all, of, asked, least);
  };
  add("velocity forward", "setpoint_vx_m_s", forward, 0.1);
  add("velocity right", "setpoint_vy_m_s", right, 0.1);
  add("velocity down", "setpoint_vz_m_s", vz, 0.1);
  add("roll", "setpoint_roll_deg", column("estimate_roll_deg"), 0.5);
  add("pitch", "setpoint_pitch_deg", column("estimate_pitch_deg"), 0.5);
  std::vector<double> thrust_s, thrust, all_thrust = column("setpoint_thrust");
  for (std::size_t i = 0; i < all_thrust.size(); ++i)
    if (std::isfinite(all_thrust[i])) thrust_s.push_back(t[i]), thrust.push_back(all_thrust[i]);
  AddHoverThrust(all, thrust_s, thrust, t, vz);
  return all;
}

}  // namespace kestrel::records
