// SPDX-License-Identifier: Apache-2.0
#include "vision/calibration/view_adjustment.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>

namespace kestrel::vision {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;
using Matrix6d = Eigen::Matrix<double, 6, 6>;
using Vector6d = Eigen::Matrix<double, 6, 1>;

constexpr double kDone = 1e-10;  // of the cost, in a step

Vector3d PointInCamera(const Pose& X_CT, const SeenPoint& point) { return X_CT * point.p_T; }

// Over what is expected of an offset, along each axis of T.
Vector3d WeightOf(const BoardShape& board) {
  const double plane = 1 / (board.in_plane_m * board.in_plane_m);
  return {plane, plane, 1 / (board.out_of_plane_m * board.out_of_plane_m)};
}

double Huber(double norm, double limit) { return norm <= limit ? norm * norm : limit * (2 * norm - limit); }

// The normal equations: of each view its own block and that with what all views share; of the latter, which is
// the camera, then the offsets of the board's corners.
struct NormalEquations {
  struct View {
    Matrix6d pose = Matrix6d::Zero();
    Eigen::Matrix<double, 6, Eigen::Dynamic> coupling;
    Vector6d gradient = Vector6d::Zero();
  };
  std::vector<View> views;
  MatrixXd shared;
  VectorXd gradient;
};

NormalEquations Linearise(const Adjustment& a, const std::vector<int>& free, double huber) {
  const Index n = static_cast<Index>(free.size());
  const Index all = n + 3 * static_cast<Index>(a.board.offsets_m.size());
  NormalEquations e{{}, MatrixXd::Zero(all, all), VectorXd::Zero(all)};
  Eigen::Matrix2Xd d_all, d_camera(2, n);
  for (const AdjustedView& view : a.views) {
    NormalEquations::View v;
    v.coupling.setZero(6, all);
    for (const SeenPoint& point : view.points) {
      const Vector3d p_CQ = PointInCamera(view.X_CT, point);
      Eigen::Matrix<double, 2, 3> d_point;
      const auto uv = Project(a.camera, p_CQ, &d_point, &d_all);
      if (!uv) continue;
      const Vector2d error = point.whiten * (*uv - point.pixel);
      const double norm = error.norm(), weight = norm <= huber ? 1 : huber / norm;
      for (Index i = 0; i < n; ++i)
        d_camera.col(i) = point.whiten * d_all.col(free[static_cast<std::size_t>(i)]);
      Eigen::Matrix<double, 2, 6> d_pose;  // translation, then rotation, both in C
      d_pose << d_point, -d_point * Skew(p_CQ - view.X_CT.p);
      d_pose = point.whiten * d_pose;
      v.pose.noalias() += weight * d_pose.transpose() * d_pose;
      v.coupling.leftCols(n).noalias() += weight * d_pose.transpose() * d_camera;
      v.gradient.noalias() += weight * d_pose.transpose() * error;
      e.shared.topLeftCorner(n, n).noalias() += weight * d_camera.transpose() * d_camera;
      e.gradient.head(n).noalias() += weight * d_camera.transpose() * error;
      if (a.board.offsets_m.empty()) continue;
      const Index at = n + 3 * point.corner;
      const Eigen::Matrix<double, 2, 3> d_offset = point.whiten * d_point * view.X_CT.R.toRotationMatrix();
      v.coupling.middleCols<3>(at).noalias() += weight * d_pose.transpose() * d_offset;
      const Eigen::MatrixXd with_camera = weight * d_camera.transpose() * d_offset;
      e.shared.block(0, at, n, 3) += with_camera;
      e.shared.block(at, 0, 3, n) += with_camera.transpose();
      e.shared.block<3, 3>(at, at).noalias() += weight * d_offset.transpose() * d_offset;
      e.gradient.segment<3>(at).noalias() += weight * d_offset.transpose() * error;
    }
    e.views.push_back(std::move(v));
  }
  for (std::size_t i = 0; i < a.board.offsets_m.size(); ++i) {
    const Index at = n + 3 * static_cast<Index>(i);
    const Vector3d weight = WeightOf(a.board);
    e.shared.diagonal().segment<3>(at) += weight;
    e.gradient.segment<3>(at) += weight.cwiseProduct(a.board.offsets_m[i]);
  }
  return e;
}

// Keeps a model's own parameters where the model has a meaning.
VectorXd WithinRange(const CameraModel& camera, VectorXd all) {
  for (const int i : {0, 1}) all[i] = std::max(all[i], 1.0);
  if (std::holds_alternative<Unified>(camera)) all[4] = std::clamp(all[4], 0.0, 20.0);
  if (std::holds_alternative<DoubleSphere>(camera)) {
    all[4] = std::clamp(all[4], -0.99, 1.0);
    all[5] = std::clamp(all[5], 0.0, 1.0);
  }
  return all;
}

// What all views share, poses eliminated, with the equations damped. None: a pose is not determined.
struct Reduced {
  MatrixXd shared;
  VectorXd gradient;
  std::vector<Eigen::LDLT<Matrix6d>> poses;
};
std::optional<Reduced> Eliminate(const NormalEquations& e, double damping) {
  Reduced r{e.shared, e.gradient, {}};
  r.shared.diagonal() *= 1 + damping;
  for (const NormalEquations::View& view : e.views) {
    Matrix6d pose = view.pose;
    pose.diagonal() *= 1 + damping;
    r.poses.emplace_back(pose);
    if (r.poses.back().info() != Eigen::Success || !r.poses.back().isPositive()) return std::nullopt;
    const Eigen::Matrix<double, 6, Eigen::Dynamic> solved = r.poses.back().solve(view.coupling);
    r.shared.noalias() -= view.coupling.transpose() * solved;
    r.gradient.noalias() -= solved.transpose() * view.gradient;
  }
  return r;
}

// Solves with the unknowns scaled alike: a focal length is thousands, a distortion thousandths.
VectorXd SolveScaled(const MatrixXd& matrix, const VectorXd& right) {
  const VectorXd scale = matrix.diagonal().cwiseMax(1e-300).cwiseSqrt().cwiseInverse();
  const MatrixXd scaled = scale.asDiagonal() * matrix * scale.asDiagonal();
  return scale.cwiseProduct(scaled.ldlt().solve(scale.cwiseProduct(right)));
}

}  // namespace

std::optional<Vector2d> PixelError(const CameraModel& camera, const Pose& X_CT, const SeenPoint& point) {
  const auto uv = Project(camera, PointInCamera(X_CT, point));
  if (!uv) return std::nullopt;
  return *uv - point.pixel;
}

std::optional<Vector2d> WhitenedError(const CameraModel& camera, const Pose& X_CT, const SeenPoint& point) {
  const auto error = PixelError(camera, X_CT, point);
  if (!error) return std::nullopt;
  return point.whiten * *error;
}

double CostOf(const BoardShape& board) {
  double cost = 0;
  for (const Vector3d& offset : board.offsets_m) cost += WeightOf(board).dot(offset.cwiseAbs2());
  return cost;
}

double CostOf(const Adjustment& a, double huber) {
  double cost = CostOf(a.board);
  for (const AdjustedView& view : a.views) {
    for (const SeenPoint& point : view.points) {
      const auto error = WhitenedError(a.camera, view.X_CT, point);
      cost += Huber(error ? error->norm() : kLostError_px * point.whiten.norm(), huber);
    }
  }
  return cost;
}

double Adjust(Adjustment& a, const AdjustOptions& options) {
  double cost = CostOf(a, options.huber), damping = 1e-4;
  for (int step = 0; step < options.max_steps; ++step) {
    const NormalEquations equations = Linearise(a, options.free, options.huber);
    bool better = false, done = false;
    while (!better && damping < 1e12) {
      Adjustment next = a;
      const auto reduced = Eliminate(equations, damping);
      if (reduced) {
        const VectorXd d_shared = reduced->gradient.size() == 0
                                      ? VectorXd()
                                      : VectorXd(-SolveScaled(reduced->shared, reduced->gradient));
        VectorXd all = Parameters(a.camera);
        for (std::size_t i = 0; i < options.free.size(); ++i)
          all[options.free[i]] += d_shared[static_cast<Index>(i)];
        SetParameters(next.camera, WithinRange(a.camera, all));
        const auto d_offset = [&](int corner) {
          return d_shared.segment<3>(static_cast<Index>(options.free.size()) + 3 * corner);
        };
        for (std::size_t i = 0; i < a.board.offsets_m.size(); ++i)
          next.board.offsets_m[i] += d_offset(static_cast<int>(i));
        for (std::size_t i = 0; i < a.views.size(); ++i) {
          const NormalEquations::View& view = equations.views[i];
          Vector6d right = -view.gradient;
          if (d_shared.size() > 0) right -= view.coupling * d_shared;
          const Vector6d d_pose = reduced->poses[i].solve(right);
          Pose& X_CT = next.views[i].X_CT;
          X_CT.p += d_pose.head<3>();
          X_CT.R = (ExpRotation(d_pose.tail<3>()) * X_CT.R).normalized();
          if (a.board.offsets_m.empty()) continue;
          for (SeenPoint& point : next.views[i].points) point.p_T += d_offset(point.corner);
        }
        const double next_cost = CostOf(next, options.huber);
        if (std::isfinite(next_cost) && next_cost <= cost) {
          done = cost - next_cost <= kDone * cost;
          a = std::move(next);
          cost = next_cost;
          better = true;
        }
      }
      damping = better ? std::max(damping / 10, 1e-12) : damping * 10;
    }
    if (!better || done) break;
  }
  return cost;
}

namespace {

// None: not positive definite, as far as the numbers go.
std::optional<MatrixXd> InverseScaled(const MatrixXd& matrix) {
  const VectorXd diagonal = matrix.diagonal();
  if (!(diagonal.minCoeff() > 0)) return std::nullopt;
  const VectorXd scale = diagonal.cwiseSqrt().cwiseInverse();
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(scale.asDiagonal() * matrix * scale.asDiagonal());
  if (solver.info() != Eigen::Success || !(solver.eigenvalues()[0] > 1e-13)) return std::nullopt;
  const MatrixXd inverse = solver.eigenvectors() * solver.eigenvalues().cwiseInverse().asDiagonal() *
                           solver.eigenvectors().transpose();
  return MatrixXd(scale.asDiagonal() * inverse * scale.asDiagonal());
}

// The equations of the camera, what else all views share eliminated.
struct CameraEquations {
  MatrixXd camera;
  MatrixXd from_board;  // takes the gradient of the offsets to the camera's
  VectorXd GradientOf(const VectorXd& shared) const {
    VectorXd own = shared.head(camera.rows());
    if (from_board.size() > 0) own -= from_board * shared.tail(shared.size() - camera.rows());
    return own;
  }
};
CameraEquations EquationsOfCamera(const Reduced& r, Index n) {
  const Index board = r.shared.rows() - n;
  CameraEquations e{r.shared.topLeftCorner(n, n), {}};
  if (board == 0) return e;
  const auto coupling = r.shared.bottomLeftCorner(board, n);
  e.from_board = r.shared.bottomRightCorner(board, board).llt().solve(MatrixXd(coupling)).transpose();
  e.camera -= e.from_board * coupling;
  return e;
}

}  // namespace

std::optional<MatrixXd> ParameterCovariance(const Adjustment& a, const std::vector<int>& free) {
  const auto reduced = Eliminate(Linearise(a, free, std::numeric_limits<double>::infinity()), 0);
  if (!reduced) return std::nullopt;
  return InverseScaled(EquationsOfCamera(*reduced, static_cast<Index>(free.size())).camera);
}

std::optional<MatrixXd> ClusteredCovariance(const Adjustment& a, const std::vector<int>& free) {
  constexpr double kAll = std::numeric_limits<double>::infinity();
  const auto reduced = Eliminate(Linearise(a, free, kAll), 0);
  if (!reduced || a.views.size() < 2) return std::nullopt;
  const CameraEquations equations = EquationsOfCamera(*reduced, static_cast<Index>(free.size()));
  const auto inverse = InverseScaled(equations.camera);
  if (!inverse) return std::nullopt;
  MatrixXd pulls = MatrixXd::Zero(inverse->rows(), inverse->cols());
  BoardShape nothing_expected = a.board;
  nothing_expected.in_plane_m = nothing_expected.out_of_plane_m = std::numeric_limits<double>::infinity();
  for (const AdjustedView& view : a.views) {
    const auto alone = Eliminate(Linearise({a.camera, {view}, nothing_expected}, free, kAll), 0);
    if (!alone) return std::nullopt;
    const VectorXd pull = equations.GradientOf(alone->gradient);
    pulls += pull * pull.transpose();
  }
  const double views = static_cast<double>(a.views.size());
  return MatrixXd(*inverse * pulls * *inverse * (views / (views - 1)));
}

Vector2d DeterminedOffsets(const Adjustment& a, const std::vector<int>& free) {
  const auto reduced = Eliminate(Linearise(a, free, std::numeric_limits<double>::infinity()), 0);
  if (!reduced) return Vector2d::Zero();
  const Index board = 3 * static_cast<Index>(a.board.offsets_m.size());
  // With the camera free too.
  const MatrixXd inverse =
      reduced->shared.llt().solve(MatrixXd::Identity(reduced->shared.rows(), reduced->shared.cols()));
  const VectorXd left = inverse.diagonal().tail(board);
  const Vector3d weight = WeightOf(a.board);
  Vector2d determined = Vector2d::Zero();
  for (Index i = 0; i < board; ++i) determined[i % 3 == 2 ? 1 : 0] += 1 - left[i] * weight[i % 3];
  return determined;
}

}  // namespace kestrel::vision
