// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <optional>
#include <string>
#include <type_traits>
#include <vector>

#include "geometry/tait_bryan.h"
#include "tests/sim/published_layouts.h"

namespace kestrel::sim {

using ArduPilotParameterMap = std::map<std::string, double>;

// As ArduCopter comes, of the parameters that it has here (Parameters.cpp, AP_Motors, AC_AttitudeControl, AC_PosControl,
// AC_WPNav); m, s and rad where the unit is not in the name.
inline ArduPilotParameterMap StockArduCopter() {
  return {{"FRAME_CLASS", 0},       {"FRAME_TYPE", 1},         {"MOT_THST_EXPO", 0.65},
          {"MOT_SPIN_MIN", 0.15},   {"MOT_SPIN_MAX", 0.95},    {"MOT_SPIN_ARM", 0.1},
          {"MOT_THST_HOVER", 0.35}, {"MOT_BAT_VOLT_MAX", 0},   {"MOT_BAT_VOLT_MIN", 0},
          {"SIM_RATE_HZ", 1200},    {"SCHED_LOOP_RATE", 400},  {"GUID_TIMEOUT", 3},
          {"WPNAV_ACCEL", 250},     {"WPNAV_ACCEL_Z", 100},    {"WPNAV_SPEED_UP", 250},
          {"PSC_JERK_XY", 5},       {"PSC_JERK_Z", 5},         {"PSC_POSXY_P", 1},
          {"PSC_VELXY_P", 2},       {"PSC_VELXY_I", 1},        {"PSC_VELXY_D", 0.5},
          {"PSC_VELXY_FLTD", 5},    {"PSC_POSZ_P", 1},         {"PSC_VELZ_P", 5},
          {"PSC_ACCZ_P", 0.5},      {"PSC_ACCZ_I", 1},         {"ATC_ANG_RLL_P", 4.5},
          {"ATC_ANG_PIT_P", 4.5},   {"ATC_ANG_YAW_P", 4.5},    {"ATC_RAT_RLL_P", 0.135},
          {"ATC_RAT_RLL_I", 0.135}, {"ATC_RAT_RLL_D", 0.0036}, {"ATC_RAT_PIT_P", 0.135},
          {"ATC_RAT_PIT_I", 0.135}, {"ATC_RAT_PIT_D", 0.0036}, {"ATC_RAT_YAW_P", 0.18},
          {"ATC_RAT_YAW_I", 0.018}, {"ATC_INPUT_TC", 0.15},    {"INS_GYRO_FILTER", 20},
          {"INS_ACCOFFS_X", 0},     {"INS_ACCOFFS_Y", 0},      {"INS_ACCOFFS_Z", 0},
          {"COMPASS_OFS_X", 0},     {"COMPASS_OFS_Y", 0},      {"COMPASS_OFS_Z", 0}};
}

// What the JSON interface tells of the aircraft.
struct ArduCopterState {
  double t_s = 0;
  Eigen::Vector3d p_N, v_N, w_B, specific_force_B;
  Eigen::Quaterniond R_NB;
};

// ArduCopter in GUIDED, as far as it shows on the wire: its checks before it arms, its cascade of loops with the gains
// that it comes with, its motors by FRAME_CLASS and FRAME_TYPE, setpoints of velocity shaped by WPNAV_ACCEL and
// WPNAV_ACCEL_Z and given up after GUID_TIMEOUT. It knows nothing of the aircraft but its parameters. Its loop runs at
// SCHED_LOOP_RATE, position and velocity are those that it is told.
class ScriptedArduCopter {
 public:
  static constexpr double kSettled_s = 2;

  // of_file: over those that it comes with.
  explicit ScriptedArduCopter(const ArduPilotParameterMap& of_file) : p_(StockArduCopter()) {
    for (const auto& [name, value] : of_file) p_[name] = value;
    const int frame_class = static_cast<int>(p_["FRAME_CLASS"]),
              frame_type = static_cast<int>(p_["FRAME_TYPE"]);
    static const std::map<int, std::string> classes = {{1, "quad"}, {2, "hexa"}, {3, "octo"}},
                                            types = {{0, "plus"}, {1, "x"}, {3, "h"}};
    if (!classes.contains(frame_class) || !types.contains(frame_type)) return;
    motors_ = PublishedLayout(classes.at(frame_class) + "-" + types.at(frame_type), 1);
    double most_x = 0, most_y = 0;
    for (const PublishedMotor& m : motors_)
      most_x = std::max(most_x, std::abs(m.x)), most_y = std::max(most_y, std::abs(m.y));
    for (PublishedMotor& m : motors_) m.x *= 0.5 / most_x, m.y *= 0.5 / most_y;  // normalise_rpy_factors
  }

  int rate_hz() const { return static_cast<int>(p_.at("SIM_RATE_HZ")); }
  bool armed() const { return armed_; }

  // Why it does not, in its own words.
  std::vector<std::string> PreArm() const {
    std::vector<std::string> refusals;
    if (motors_.empty()) refusals.emplace_back("Motors: Check frame class and type");
    const auto zero = [&](const std::string& name) {
      return p_.at(name + "_X") == 0 && p_.at(name + "_Y") == 0 && p_.at(name + "_Z") == 0;
    };
    if (zero("INS_ACCOFFS")) refusals.emplace_back("3D Accel calibration needed");
    if (zero("COMPASS_OFS")) refusals.emplace_back("Compass not calibrated");
    if (gyro_hz_ < 1.8 * p_.at("SCHED_LOOP_RATE")) refusals.emplace_back("Gyro 0 rate < loop rate x1.8");
    if (t_s_ - began_s_ < kSettled_s) refusals.emplace_back("AHRS: waiting for home");
    return refusals;
  }
  bool Arm() {
    if (!PreArm().empty()) return false;
    armed_ = true;
    return true;
  }
  // Armed, to a height above where it stands.
  void TakeOff(double height_m) {
    height_m_ = height_m, velocity_.reset(), position_ = Eigen::Vector3d(p_N_);
  }
  // SET_POSITION_TARGET_LOCAL_NED, velocities in N.
  void SetVelocity(const Eigen::Vector3d& v_N) { velocity_ = v_N, heard_s_ = t_s_, height_m_.reset(); }

  // The motors' pulse widths for the state that came.
  std::vector<int> Step(const ArduCopterState& s) {
    if (states_ == 0) {
      began_s_ = s.t_s, next_s_ = s.t_s;
      heading_ = YawOf(s.R_NB);
    }
    const double dt_s = s.t_s - t_s_;
    t_s_ = s.t_s, p_N_ = s.p_N;
    if (++states_ > 1) gyro_hz_ = (states_ - 1) / std::max(1e-6, t_s_ - began_s_);
    if (t_s_ - began_s_ < kSettled_s / 2)
      at_rest_ += (s.specific_force_B - at_rest_) / states_, drift_ += (s.w_B - drift_) / states_;
    const double smooth = dt_s / (dt_s + 1 / (2 * std::numbers::pi * p_.at("INS_GYRO_FILTER")));
    gyro_ += smooth * (s.w_B - drift_ - gyro_);
    force_ += smooth * (s.specific_force_B - at_rest_ - force_);
    if (t_s_ < next_s_) return pwm_;
    next_s_ += 1 / p_.at("SCHED_LOOP_RATE");
    pwm_ = Loop(s, 1 / p_.at("SCHED_LOOP_RATE"));
    return pwm_;
  }

 private:
  // shape_vel_accel, of one axis or a vector.
  template <class V>
  static void Shape(const V& wanted, double accel, double jerk, double dt_s, V& velocity, V& acceleration) {
    const auto limited = [](V v, double most) {
      if constexpr (std::is_same_v<V, double>)
        return std::clamp(v, -most, most);
      else
        return v.norm() > most ? V(v * (most / v.norm())) : v;
    };
    const V target = limited(V((wanted - velocity) * (jerk / accel)), accel);
    acceleration += limited(V(target - acceleration), jerk * dt_s);
    velocity += acceleration * dt_s;
  }

  std::vector<int> Loop(const ArduCopterState& s, double dt_s) {
    if (!armed_) return std::vector<int>(motors_.size(), 1000);
    if (!position_) return Pulses(0, Eigen::Vector3d::Zero(), true);  // on the ground, idle

    // Setpoints: shaped velocities, and the place that they lead to.
    Eigen::Vector3d wanted = Eigen::Vector3d::Zero();
    if (velocity_ && t_s_ - heard_s_ < p_.at("GUID_TIMEOUT")) wanted = *velocity_;
    if (height_m_) {
      if (!ground_z_) ground_z_ = position_->z();
      wanted.z() =
          std::clamp(1.0 * (*ground_z_ - *height_m_ - position_->z()), -0.01 * p_.at("WPNAV_SPEED_UP"), 0.5);
    }
    Eigen::Vector2d v_xy = v_shaped_.head<2>(), a_xy = a_shaped_.head<2>();
    Shape<Eigen::Vector2d>(wanted.head<2>(), 0.01 * p_.at("WPNAV_ACCEL"), p_.at("PSC_JERK_XY"), dt_s, v_xy,
                           a_xy);
    v_shaped_.head<2>() = v_xy, a_shaped_.head<2>() = a_xy;
    Shape<double>(wanted.z(), 0.01 * p_.at("WPNAV_ACCEL_Z"), p_.at("PSC_JERK_Z"), dt_s, v_shaped_.z(),
                  a_shaped_.z());
    *position_ += v_shaped_ * dt_s;

    // AC_PosControl.
    const Eigen::Vector3d p_error = *position_ - s.p_N;
    const Eigen::Vector2d v_error =
        v_shaped_.head<2>() + p_.at("PSC_POSXY_P") * p_error.head<2>() - s.v_N.head<2>();
    integral_xy_ = (integral_xy_ + p_.at("PSC_VELXY_I") * v_error * dt_s).cwiseMax(-10).cwiseMin(10);
    const double derived = dt_s / (dt_s + 1 / (2 * std::numbers::pi * p_.at("PSC_VELXY_FLTD")));
    slope_xy_ += derived * ((v_error - v_error_) / dt_s - slope_xy_);
    v_error_ = v_error;
    const Eigen::Vector2d a = a_shaped_.head<2>() + p_.at("PSC_VELXY_P") * v_error + integral_xy_ +
                              p_.at("PSC_VELXY_D") * slope_xy_;
    const double climb_error = v_shaped_.z() + p_.at("PSC_POSZ_P") * p_error.z() - s.v_N.z();
    const double a_z = a_shaped_.z() + p_.at("PSC_VELZ_P") * climb_error;
    const double a_z_measured = (s.R_NB * (force_ + Eigen::Vector3d(0, 0, -kG))).z() + kG;
    const double a_error = -(a_z - a_z_measured);  // upwards, m/s2; the gains are for cm/s2 and thousandths
    integral_z_ = std::clamp(integral_z_ + 0.1 * p_.at("PSC_ACCZ_I") * a_error * dt_s, -0.8, 0.8);
    const TaitBryan now = TaitBryanFromRotation(s.R_NB.toRotationMatrix());
    const double throttle =
        std::clamp((p_.at("MOT_THST_HOVER") + 0.1 * p_.at("PSC_ACCZ_P") * a_error + integral_z_) /
                       std::max(0.5, std::cos(now.roll) * std::cos(now.pitch)),
                   0.0, 1.0);

    // AC_AttitudeControl.
    const Eigen::Vector2d a_H = (HeadingRotation(-heading_) * Eigen::Vector3d(a.x(), a.y(), 0)).head<2>();
    const Eigen::Vector3d leaned(std::clamp(std::atan(a_H.y() / kG), -0.5, 0.5),
                                 std::clamp(-std::atan(a_H.x() / kG), -0.5, 0.5), heading_);
    Eigen::Vector3d turning = (leaned - angles_) / (dt_s + p_.at("ATC_INPUT_TC"));  // fed forward
    turning.z() = 0;
    angles_ += turning * dt_s;
    angles_.z() = heading_;
    const Eigen::Vector3d error(angles_.x() - now.roll, angles_.y() - now.pitch,
                                WrapAngle(angles_.z() - now.yaw));
    Eigen::Vector3d out;
    constexpr std::array<const char*, 3> kAxes = {"RLL", "PIT", "YAW"};
    for (int axis = 0; axis < 3; ++axis) {
      const std::string name = kAxes[static_cast<std::size_t>(axis)];
      const double rate_error = turning[axis] + p_.at("ATC_ANG_" + name + "_P") * error[axis] - gyro_[axis];
      integral_rate_[axis] =
          std::clamp(integral_rate_[axis] + p_.at("ATC_RAT_" + name + "_I") * rate_error * dt_s, -0.5, 0.5);
      out[axis] = p_.at("ATC_RAT_" + name + "_P") * rate_error + integral_rate_[axis];
      if (axis < 2) out[axis] += p_.at("ATC_RAT_" + name + "_D") * (rate_error - rate_error_[axis]) / dt_s;
      rate_error_[axis] = rate_error;
    }
    return Pulses(throttle, out, false);
  }

  // AP_MotorsMatrix and the thrust's linearisation.
  std::vector<int> Pulses(double throttle, const Eigen::Vector3d& out, bool idle) const {
    std::vector<int> pwm;
    const double e = p_.at("MOT_THST_EXPO"), low = p_.at("MOT_SPIN_MIN"), high = p_.at("MOT_SPIN_MAX");
    for (const PublishedMotor& m : motors_) {
      const double thrust =
          std::clamp(throttle - m.y * out.x() + m.x * out.y() + 0.5 * m.yaw * out.z(), 0.0, 1.0);
      const double u = (e - 1 + std::sqrt((1 - e) * (1 - e) + 4 * e * thrust)) / (2 * e);
      const double signal = idle ? p_.at("MOT_SPIN_ARM") : low + (high - low) * u;
      pwm.push_back(1000 + static_cast<int>(std::lround(1000 * signal)));
    }
    return pwm;
  }

  static constexpr double kG = 9.80665;
  ArduPilotParameterMap p_;
  std::vector<PublishedMotor> motors_;  // x and y: their factors of pitch and of roll, reversed
  std::vector<int> pwm_;
  bool armed_ = false;
  int states_ = 0;
  double t_s_ = 0, began_s_ = 0, next_s_ = 0, gyro_hz_ = 0, heading_ = 0, heard_s_ = 0;
  std::optional<double> height_m_, ground_z_;
  std::optional<Eigen::Vector3d> velocity_, position_;
  Eigen::Vector3d p_N_ = Eigen::Vector3d::Zero(), gyro_ = Eigen::Vector3d::Zero(),
                  drift_ = Eigen::Vector3d::Zero(), force_ = Eigen::Vector3d::Zero(),
                  at_rest_ = Eigen::Vector3d::Zero(), v_shaped_ = Eigen::Vector3d::Zero(),
                  a_shaped_ = Eigen::Vector3d::Zero(), angles_ = Eigen::Vector3d::Zero(),
                  rate_error_ = Eigen::Vector3d::Zero(), integral_rate_ = Eigen::Vector3d::Zero();
  Eigen::Vector2d integral_xy_ = Eigen::Vector2d::Zero(), v_error_ = Eigen::Vector2d::Zero(),
                  slope_xy_ = Eigen::Vector2d::Zero();
  double integral_z_ = 0;
};

}  // namespace kestrel::sim
