// SPDX-License-Identifier: Apache-2.0
#include "vision/calibration/contradiction.h"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <boost/math/distributions/fisher_f.hpp>
#include <cmath>
#include <utility>

#include "vision/calibration/board_shape.h"

namespace kestrel::vision {
namespace {

constexpr Eigen::Index kPose = 6, kOwn = 3;  // numbers of a pose, of what a view may have of its own
constexpr double kMinExplained = 0.5, kMaxChance = 1e-5;
constexpr double kMostLeftOut = 1.0 / 3;  // of the views
constexpr double kPlausible = 0.2;  // change of a focal length; of a view that barely knows it, more is none

std::string ReasonOf(const OwnCamera& own) {
  std::string change;
  if (std::abs(own.focal_change) < kPlausible) {
    change = fmt::format(", {:.1f} % {},", 100 * std::abs(own.focal_change),
                         own.focal_change > 0 ? "longer" : "shorter");
  }
  return fmt::format(
      "it contradicts the others: a focal length{} and a centre of its own would explain {:.0f} % "
      "of its errors",
      change, 100 * own.explained);
}

// What is left of errors by some more numbers, and these. What the pose cannot do is left of their columns; of a
// board that is seen straight on, little.
std::pair<double, Eigen::VectorXd> LeftBy(const Eigen::MatrixXd& columns, const Eigen::MatrixXd& pose,
                                          const Eigen::ColPivHouseholderQR<Eigen::MatrixXd>& by_pose,
                                          const Eigen::VectorXd& errors) {
  const Eigen::VectorXd unit = columns.colwise().norm().cwiseMax(1e-300).cwiseInverse();
  const Eigen::MatrixXd beyond_pose = (columns - pose * by_pose.solve(columns)) * unit.asDiagonal();
  Eigen::ColPivHouseholderQR<Eigen::MatrixXd> solver(beyond_pose);
  solver.setThreshold(1e-6);
  const Eigen::VectorXd change = solver.solve(-errors);
  return {(errors + beyond_pose * change).squaredNorm(), unit.cwiseProduct(change)};
}

}  // namespace

std::vector<OwnCamera> OwnCameras(const Adjustment& a) {
  const Eigen::VectorXd parameters = Parameters(a.camera);
  std::vector<OwnCamera> all;
  for (const AdjustedView& view : a.views) {
    const Eigen::Index rows = 2 * static_cast<Eigen::Index>(view.points.size());
    Eigen::MatrixXd pose = Eigen::MatrixXd::Zero(rows, kPose), own = Eigen::MatrixXd::Zero(rows, kOwn),
                    bend = Eigen::MatrixXd::Zero(rows, kOwn);
    Eigen::VectorXd error = Eigen::VectorXd::Zero(rows);
    Eigen::Index row = -2;
    for (const SeenPoint& point : view.points) {
      row += 2;
      const Eigen::Vector3d p_CQ = view.X_CT * point.p_T;
      Eigen::Matrix<double, 2, 3> d_point;
      Eigen::Matrix2Xd d_all;
      const auto uv = Project(a.camera, p_CQ, &d_point, &d_all);
      if (!uv) continue;
      pose.middleRows<2>(row) << point.whiten * d_point, -point.whiten * d_point * Skew(p_CQ - view.X_CT.p);
      own.middleRows<2>(row) << point.whiten * (d_all.col(0) * parameters[0] + d_all.col(1) * parameters[1]),
          point.whiten * d_all.middleCols<2>(2);
      const double x = point.p_T.x(), y = point.p_T.y();
      bend.middleRows<2>(row) = point.whiten * d_point * (view.X_CT.R * Eigen::Vector3d::UnitZ()) *
                                Eigen::RowVector3d(x * x, x * y, y * y);
      error.segment<2>(row) = point.whiten * (*uv - point.pixel);
    }
    const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> by_pose(pose);
    const Eigen::VectorXd left = error - pose * by_pose.solve(error);
    const auto [rest, change] = LeftBy(own, pose, by_pose, left);
    const double cost = left.squaredNorm(), freedom = static_cast<double>(rows - kPose - kOwn);
    OwnCamera camera;
    if (rest > 0 && rest < cost && freedom > 0) {
      camera.explained = 1 - rest / cost;
      camera.by_bend = 1 - LeftBy(bend, pose, by_pose, left).first / cost;
      camera.focal_change = change[0];
      const boost::math::fisher_f noise(kOwn, freedom);
      camera.chance = boost::math::cdf(complement(noise, (cost - rest) / kOwn / (rest / freedom)));
    }
    all.push_back(camera);
  }
  return all;
}

bool Contradicts(const OwnCamera& own) {
  return own.explained > kMinExplained && own.explained > own.by_bend && own.chance < kMaxChance;
}

std::size_t LeaveOutContradicting(Agreeing& agreeing, const std::vector<int>& free,
                                  std::vector<std::string>& left_out) {
  const Agreeing all = agreeing;
  const std::vector<std::string> before = left_out;
  std::size_t most_at_once = 0;
  while (true) {
    const std::vector<OwnCamera> own = OwnCameras(agreeing.adjustment);
    most_at_once = std::max<std::size_t>(most_at_once, std::count_if(own.begin(), own.end(), Contradicts));
    const auto worst = std::max_element(own.begin(), own.end(), [](const auto& a, const auto& b) {
      return (Contradicts(a) ? a.explained : 0) < (Contradicts(b) ? b.explained : 0);
    });
    if (worst == own.end() || !Contradicts(*worst)) return all.numbers.size() - agreeing.numbers.size();
    const auto at = worst - own.begin();
    left_out[agreeing.numbers[static_cast<std::size_t>(at)]] = ReasonOf(*worst);
    agreeing.adjustment.views.erase(agreeing.adjustment.views.begin() + at);
    agreeing.numbers.erase(agreeing.numbers.begin() + at);
    agreeing.corners.erase(agreeing.corners.begin() + at);
    const std::size_t gone = all.numbers.size() - agreeing.numbers.size();
    if (static_cast<double>(gone) > kMostLeftOut * static_cast<double>(all.numbers.size())) {
      agreeing = all;
      left_out = before;
      return std::max(gone, most_at_once);
    }
    if (agreeing.adjustment.board.offsets_m.empty())
      Adjust(agreeing.adjustment, {.free = free});
    else
      AdjustBoardShape(agreeing, free);
  }
}

}  // namespace kestrel::vision
