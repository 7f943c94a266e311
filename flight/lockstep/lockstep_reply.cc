// SPDX-License-Identifier: Apache-2.0
#include "flight/lockstep/lockstep_reply.h"

#include <cmath>
#include <nlohmann/json.hpp>

#include "base/overloaded.h"

namespace kestrel::flight {
namespace {

using Json = nlohmann::ordered_json;

Json Of(const Eigen::Vector3d& v) { return {v.x(), v.y(), v.z()}; }
Json Of(const Eigen::Quaterniond& q) { return {q.w(), q.x(), q.y(), q.z()}; }

template <class Each, class Of>
Json ListOf(const std::vector<Each>& all, Of of) {
  Json list = Json::array();
  for (const Each& each : all) list.push_back(of(each));
  return list;
}

Json Of(const control::Setpoint& setpoint) {
  return std::visit(
      Overloaded{[](const control::VelocitySetpoint& s) -> Json {
                   return {{"kind", "velocity"}, {"v_H_m_s", Of(s.v_H)}, {"yaw_rate_rad_s", s.yaw_rate}};
                 },
                 [](const control::PositionSetpoint& s) -> Json {
                   return {{"kind", "position"}, {"p_N_m", Of(s.p_N)}, {"yaw_rad", s.yaw}};
                 },
                 [](const control::AttitudeSetpoint& s) -> Json {
                   return {{"kind", "attitude"},
                           {"roll_rad", s.roll},
                           {"pitch_rad", s.pitch},
                           {"yaw_rate_rad_s", s.yaw_rate},
                           {"thrust", s.thrust}};
                 },
                 [](const control::RateSetpoint& s) -> Json {
                   return {{"kind", "rates"}, {"w_B_rad_s", Of(s.w_B)}, {"thrust", s.thrust}};
                 }},
      setpoint);
}

}  // namespace

Json LockstepJson(const control::VehicleState& s) {
  return {{"t_s", s.t_s},       {"p_NB_m", Of(s.p_NB)},     {"v_N_m_s", Of(s.v_N)},
          {"q_NB", Of(s.R_NB)}, {"w_B_rad_s", Of(s.w_B)},   {"mode", control::NameOf(s.mode)},
          {"landed", s.landed}, {"saturated", s.saturated}, {"aided", s.aided}};
}

Json LockstepJson(const Truth& t) {
  Json targets = Json::array();
  for (const TargetTruth& target : t.targets)
    targets.push_back({{"diameter_m", target.diameter_m},
                       {"p_N_m", Of(target.p_N)},
                       {"v_N_m_s", Of(target.v_N)},
                       {"in_view", target.in_view}});
  return {{"t_s", t.t_s},           {"p_NB_m", Of(t.X_NB.p)},     {"q_NB", Of(t.X_NB.R)},
          {"v_N_m_s", Of(t.v_N)},   {"w_B_rad_s", Of(t.w_B)},     {"p_NC_m", Of(t.X_NC.p)},
          {"q_NC", Of(t.X_NC.R)},   {"wind_N_m_s", Of(t.wind_N)}, {"p_NT_m", Of(t.X_NT.p)},
          {"q_NT", Of(t.X_NT.R)},   {"v_NT_m_s", Of(t.v_NT)},     {"w_NT_rad_s", Of(t.w_NT)},
          {"touching", t.touching}, {"targets", targets}};
}

Json LockstepJson(const std::vector<sim::TruthSample>& samples) {
  return ListOf(samples, [](const sim::TruthSample& s) -> Json {
    return {{"t_ns", s.t_ns},
            {"p_NB_m", Of(s.X_NB.p)},
            {"q_NB", Of(s.X_NB.R)},
            {"v_N_m_s", Of(s.v_N)},
            {"w_B_rad_s", Of(s.w_B)},
            {"gyroscope_bias_I_rad_s", Of(s.gyroscope_bias_I)},
            {"accelerometer_bias_I_m_s2", Of(s.accelerometer_bias_I)}};
  });
}

Json LockstepJson(const sim::Readings& r) {
  Json json = Json::object();
  const auto add = [&](const char* name, const auto& readings, auto of) {
    if (!readings.empty()) json[name] = ListOf(readings, of);
  };
  add("imu", r.imu, [](const sim::ImuReading& i) -> Json {
    return {{"t_ns", i.t_ns}, {"w_I_rad_s", Of(i.w_I)}, {"specific_force_I_m_s2", Of(i.specific_force_I)}};
  });
  add("gps", r.gps, [](const sim::GpsReading& g) -> Json {
    return {{"t_ns", g.t_ns}, {"p_N_m", Of(g.p_N)}, {"v_N_m_s", Of(g.v_N)}};
  });
  add("barometer", r.barometer, [](const sim::BarometerReading& b) -> Json {
    return {{"t_ns", b.t_ns}, {"height_m", b.height_m}, {"pressure_pa", b.pressure_pa}};
  });
  add("magnetometer", r.magnetometer, [](const sim::MagnetometerReading& m) -> Json {
    return {{"t_ns", m.t_ns}, {"field_B_t", Of(m.field_B)}};
  });
  // JSON has no infinity.
  add("rangefinder", r.rangefinder, [](const sim::RangeReading& f) -> Json {
    Json reading = {{"t_ns", f.t_ns}, {"range_m", f.range_m}, {"nearer", f.range_m < 0}};
    if (!std::isfinite(f.range_m)) reading["range_m"] = nullptr;
    return reading;
  });
  return json;
}

Json LockstepJson(const mission::Decision& d) {
  Json json = {{"setpoint", nullptr}, {"aid", nullptr}, {"phase", d.phase}, {"outcome", d.outcome}};
  if (d.setpoint) json["setpoint"] = Of(*d.setpoint);
  if (d.aid) json["aid"] = {{"q_NB", Of(d.aid->R_NB)}, {"sigma_rad", d.aid->sigma}};
  return json;
}

}  // namespace kestrel::flight
