// SPDX-License-Identifier: Apache-2.0
#include "control/estimate/horizon_filter.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "geometry/pose.h"
#include "geometry/tait_bryan.h"

namespace kestrel::control {

namespace {

using Vector6 = Eigen::Matrix<double, 6, 1>;
using Matrix6 = Eigen::Matrix<double, 6, 6>;

// The two directions across "down" in which it is measured: rows.
Eigen::Matrix<double, 2, 3> Across(const Eigen::Vector3d& down) {
  Eigen::Matrix<double, 2, 3> E;
  E.row(0) = down.unitOrthogonal().transpose();
  E.row(1) = down.cross(E.row(0).transpose()).transpose();
  return E;
}

struct Tilt {
  Eigen::Vector2d innovation;
  Eigen::Matrix<double, 2, 6> H;
  Eigen::Matrix2d R;
};
Tilt TiltOf(const HorizonFilter::Estimate& e, const HorizonFilter::Attitude& a) {
  const Eigen::Vector3d down = e.R_NB.conjugate() * Eigen::Vector3d::UnitZ();
  const auto E = Across(down);
  Tilt tilt;
  tilt.innovation = E * (a.down_B - down);
  tilt.H.setZero();
  tilt.H.leftCols<3>() = E * Skew(down);  // Exp(-error) down = down + down x error
  tilt.R = E * a.covariance * E.transpose() + 1e-10 * Eigen::Matrix2d::Identity();
  return tilt;
}

void Apply(HorizonFilter::Estimate& e, const Vector6& x) {
  e.R_NB = (e.R_NB * ExpRotation(x.head<3>())).normalized();
  e.bias_B += x.tail<3>();
}

}  // namespace

HorizonFilter::Estimate HorizonFilter::Predicted(const Estimate& from, const Gyro& last,
                                                 const Gyro& next) const {
  Estimate to = from;
  const double dt = next.t_s - last.t_s;
  to.t_s = next.t_s;
  if (dt <= 0) return to;
  const Eigen::Vector3d turn = ((last.rate_B + next.rate_B) / 2 - from.bias_B) * dt;
  const Eigen::Quaterniond step = ExpRotation(turn);
  to.R_NB = (from.R_NB * step).normalized();
  Matrix6 F = Matrix6::Identity();
  F.topLeftCorner<3, 3>() = step.conjugate().toRotationMatrix();
  F.topRightCorner<3, 3>() = -dt * Eigen::Matrix3d::Identity();
  to.P = F * from.P * F.transpose();
  const double noise = Radians(options_.gyro_noise_deg_per_root_s);
  const double walk = Radians(options_.bias_walk_deg_per_s_root_s);
  to.P.diagonal().head<3>().array() += noise * noise * dt;
  to.P.diagonal().tail<3>().array() += walk * walk * dt;
  return to;
}

bool HorizonFilter::Plausible(const Estimate& e, const Attitude& a) const {
  const Tilt tilt = TiltOf(e, a);
  const Eigen::Matrix2d S = tilt.H * e.P * tilt.H.transpose() + tilt.R;
  return a.down_B.dot(e.R_NB.conjugate() * Eigen::Vector3d::UnitZ()) > 0 &&
         tilt.innovation.dot(S.ldlt().solve(tilt.innovation)) < options_.gate * options_.gate;
}

HorizonFilter::Estimate HorizonFilter::Corrected(Estimate e, const Attitude& a) const {
  // Errors of the skyline, such as hills on one side, stay alike from image to image: images that follow
  // each other within the time of correlation count as one.
  const double since = a.t_s - last_attitude_s_;
  const double inflate = std::max(1.0, options_.correlation_s / std::max(since, 1e-3));
  Tilt tilt = TiltOf(e, a);
  tilt.R *= inflate;
  const Eigen::Matrix2d S = tilt.H * e.P * tilt.H.transpose() + tilt.R;
  const Eigen::Matrix<double, 6, 2> K = e.P * tilt.H.transpose() * S.inverse();
  const Matrix6 rest = Matrix6::Identity() - K * tilt.H;
  Apply(e, K * tilt.innovation);
  e.P = rest * e.P * rest.transpose() + K * tilt.R * K.transpose();
  if (a.heading) {
    // A turn about the vertical: the yaw grows by the part of the error along "down".
    const Eigen::Vector3d down = e.R_NB.conjugate() * Eigen::Vector3d::UnitZ();
    Eigen::Matrix<double, 1, 6> H = Eigen::Matrix<double, 1, 6>::Zero();
    H.leftCols<3>() = down.transpose();
    const double off = WrapAngle(*a.heading - YawOf(e.R_NB)), R = a.heading_variance * inflate + 1e-10;
    const double S1 = (H * e.P * H.transpose())(0) + R;
    if (off * off < options_.gate * options_.gate * S1) {
      const Vector6 k = e.P * H.transpose() / S1;
      const Matrix6 left = Matrix6::Identity() - k * H;
      Apply(e, k * off);
      e.P = left * e.P * left.transpose() + k * R * k.transpose();
    }
  }
  e.coasting_s = 0;
  return e;
}

HorizonFilter::Estimate HorizonFilter::Started(const Attitude& a) const {
  Estimate e;
  e.t_s = a.t_s;
  const Eigen::Quaterniond level =
      Eigen::Quaterniond::FromTwoVectors(a.down_B.normalized(), Eigen::Vector3d::UnitZ());
  const double yaw = a.heading.value_or(0) - YawOf(level);
  e.R_NB = (HeadingRotation(yaw) * level).normalized();
  const double bias = Radians(options_.initial_bias_deg_per_s);
  const double heading = Radians(options_.initial_heading_deg);
  const double heading_variance = a.heading ? a.heading_variance : heading * heading;
  // The error across "down" as measured (turned by a quarter), along it as the heading is known.
  const Eigen::Vector3d d = a.down_B.normalized();
  const Eigen::Matrix3d quarter = Skew(d);
  e.P.topLeftCorner<3, 3>() =
      quarter * a.covariance * quarter.transpose() + heading_variance * d * d.transpose();
  e.P.topLeftCorner<3, 3>().diagonal().array() += 1e-9;
  e.P.bottomRightCorner<3, 3>().diagonal().setConstant(bias * bias);
  return e;
}

void HorizonFilter::Add(const Gyro& gyro) {
  Node node{gyro, {}};
  if (!nodes_.empty()) node.estimate = Predicted(nodes_.back().estimate, nodes_.back().gyro, gyro);
  node.estimate.t_s = gyro.t_s;
  nodes_.push_back(node);
  while (nodes_.size() > 2 && nodes_[1].gyro.t_s < gyro.t_s - options_.memory_s) nodes_.pop_front();
}

bool HorizonFilter::Correct(const Attitude& a) {
  if (nodes_.empty() || a.t_s < nodes_.front().gyro.t_s) return false;
  std::size_t at = nodes_.size() - 1;
  while (at > 0 && nodes_[at].gyro.t_s > a.t_s) --at;
  // A node of its own at the time of the image, with the rate between its neighbours.
  Node here = nodes_[at];
  if (at + 1 < nodes_.size()) {
    const Gyro& next = nodes_[at + 1].gyro;
    const double share = (a.t_s - here.gyro.t_s) / std::max(1e-9, next.t_s - here.gyro.t_s);
    here.gyro.rate_B += share * (next.rate_B - here.gyro.rate_B);
  }
  here.gyro.t_s = a.t_s;
  here.estimate = Predicted(nodes_[at].estimate, nodes_[at].gyro, here.gyro);
  if (!started_ || refused_ + 1 >= options_.refusals) {
    const bool again = started_ && !Plausible(here.estimate, a);
    if (!started_ || again) {
      Attitude first = a;
      if (again && !a.heading) {  // the gyros still know the heading
        first.heading = YawOf(here.estimate.R_NB);
        const Eigen::Vector3d d = a.down_B.normalized();
        first.heading_variance = d.dot(here.estimate.P.topLeftCorner<3, 3>() * d);
      }
      here.estimate = Started(first);
    } else {
      here.estimate = Corrected(here.estimate, a);
    }
    started_ = true;
  } else if (!Plausible(here.estimate, a)) {
    ++refused_;
    return false;
  } else {
    here.estimate = Corrected(here.estimate, a);
  }
  refused_ = 0;
  last_attitude_s_ = a.t_s;
  const bool replaces = nodes_[at].gyro.t_s == a.t_s;
  if (replaces)
    nodes_[at] = here;
  else
    nodes_.insert(nodes_.begin() + static_cast<std::ptrdiff_t>(++at), here);
  for (std::size_t k = at + 1; k < nodes_.size(); ++k)
    nodes_[k].estimate = Predicted(nodes_[k - 1].estimate, nodes_[k - 1].gyro, nodes_[k].gyro);
  return true;
}

std::optional<HorizonFilter::Estimate> HorizonFilter::Now() const {
  if (!started_) return std::nullopt;
  Estimate e = nodes_.back().estimate;
  e.coasting_s = std::max(0.0, e.t_s - last_attitude_s_);
  return e;
}

}  // namespace kestrel::control
