// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/mosaic/adjustment.h"

#include <Eigen/LU>
#include <Eigen/SparseCholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "geometry/pose.h"

namespace kestrel::vision {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;

// How a ray that an image's update D moves, D b, depends on the numbers of D.
template <int N>
Eigen::Matrix<double, 3, N> UpdateJacobian(const Vector3d& b) {
  Eigen::Matrix<double, 3, N> J = Eigen::Matrix<double, 3, N>::Zero();
  if constexpr (N == 3) {
    J = -Skew(b);
  } else {  // rows of D, the last element fixed
    for (int i = 0; i < 8; ++i) J(i / 3, i) = b(i % 3);
  }
  return J;
}

template <int N>
Matrix3d Updated(const Matrix3d& M, const Eigen::Matrix<double, N, 1>& d) {
  if constexpr (N == 3) {
    return (Eigen::Quaterniond(M) * ExpRotation(d)).normalized().toRotationMatrix();
  } else {
    Matrix3d D = Matrix3d::Identity();
    for (int i = 0; i < 8; ++i) D(i / 3, i % 3) += d(i);
    return M * D;
  }
}

struct Sighting {
  Vector3d ray_a, ray_b;
  Vector2d b;
};

// Sums for one iteration, of the images' blocks.
template <int N>
struct Sums {
  using Block = Eigen::Matrix<double, N, N>;
  using Vector = Eigen::Matrix<double, N, 1>;
  explicit Sums(std::size_t images) : diagonal(images, Block::Zero()), gradient(images, Vector::Zero()) {}
  std::vector<Block> diagonal;
  std::map<std::pair<int, int>, Block> below;  // row > column
  std::vector<Vector> gradient;
};

template <int N>
class Problem {
 public:
  Problem(const CameraModel& camera, const std::vector<AdjustmentEdge>& edges,
          const std::vector<AdjustmentPrior>& priors, double outlier_px)
      : camera_(camera), edges_(edges), priors_(priors), outlier_px_(outlier_px) {
    for (const AdjustmentEdge& edge : edges) {
      std::vector<Sighting>& its = sightings_.emplace_back();
      for (const PixelPair& pair : edge.pairs) {
        const auto a = Ray(camera, pair.a), b = Ray(camera, pair.b);
        if (a && b) its.push_back({*a, *b, pair.b});
      }
    }
    for (const double x : {0.2, 0.8})
      for (const double y : {0.2, 0.8})
        if (const auto ray = Ray(camera, {x * WidthPx(camera), y * HeightPx(camera)}))
          places_.push_back({*ray, *ray, {x * WidthPx(camera), y * HeightPx(camera)}});
  }

  // The cost, and the sums if asked for. rms_px: of the pairs.
  double Cost(const std::vector<Matrix3d>& M_WC, Sums<N>* sums, double* rms_px) const {
    double cost = 0, squares = 0, weights = 0;
    const double c2 = outlier_px_ * outlier_px_;
    for (std::size_t e = 0; e < edges_.size(); ++e) {
      const int a = edges_[e].a, b = edges_[e].b;
      const Matrix3d M_BA = M_WC[static_cast<std::size_t>(b)].inverse() * M_WC[static_cast<std::size_t>(a)];
      for (const Sighting& s : sightings_[e]) {
        Eigen::Matrix<double, 2, 3> d_point;
        const Vector3d r = M_BA * s.ray_a;
        const auto uv = Project(camera_, r, &d_point);
        if (!uv) continue;
        const Vector2d residual = s.b - *uv;
        const double square = residual.squaredNorm(), w = 1 / (1 + square / c2);
        cost += c2 * std::log1p(square / c2);
        squares += w * square, weights += w;
        if (!sums) continue;
        const Eigen::Matrix<double, 2, N> Ja = d_point * M_BA * UpdateJacobian<N>(s.ray_a),
                                          Jb = -d_point * UpdateJacobian<N>(r);
        Add(a, b, Ja, Jb, residual, w, *sums);
      }
    }
    for (const AdjustmentPrior& prior : priors_) {
      const Matrix3d M = prior.M_WC.inverse() * M_WC[static_cast<std::size_t>(prior.image)];
      const double w = 1 / (prior.sigma_px * prior.sigma_px);
      for (const Sighting& s : places_) {
        Eigen::Matrix<double, 2, 3> d_point;
        const auto uv = Project(camera_, M * s.ray_a, &d_point);
        if (!uv) continue;
        const Vector2d residual = s.b - *uv;
        cost += w * residual.squaredNorm();
        if (!sums) continue;
        const Eigen::Matrix<double, 2, N> J = d_point * M * UpdateJacobian<N>(s.ray_a);
        sums->diagonal[static_cast<std::size_t>(prior.image)].noalias() += w * J.transpose() * J;
        sums->gradient[static_cast<std::size_t>(prior.image)].noalias() += w * J.transpose() * residual;
      }
    }
    if (rms_px) *rms_px = weights > 0 ? std::sqrt(squares / weights) : 0;
    return cost;
  }

 private:
  using Jacobian = Eigen::Matrix<double, 2, N>;
  static void Add(int a, int b, const Jacobian& Ja, const Jacobian& Jb, const Vector2d& residual, double w,
                  Sums<N>& sums) {
    sums.diagonal[static_cast<std::size_t>(a)].noalias() += w * Ja.transpose() * Ja;
    sums.diagonal[static_cast<std::size_t>(b)].noalias() += w * Jb.transpose() * Jb;
    auto& below =
        sums.below.try_emplace({std::max(a, b), std::min(a, b)}, Sums<N>::Block::Zero()).first->second;
    if (a > b)
      below.noalias() += w * Ja.transpose() * Jb;
    else
      below.noalias() += w * Jb.transpose() * Ja;
    sums.gradient[static_cast<std::size_t>(a)].noalias() += w * Ja.transpose() * residual;
    sums.gradient[static_cast<std::size_t>(b)].noalias() += w * Jb.transpose() * residual;
  }

  const CameraModel& camera_;
  const std::vector<AdjustmentEdge>& edges_;
  const std::vector<AdjustmentPrior>& priors_;
  double outlier_px_;
  std::vector<std::vector<Sighting>> sightings_;  // of each edge
  std::vector<Sighting> places_;                  // of each image, for its prior
};

// The updates of all images. fixed: that image has none.
template <int N>
Eigen::VectorXd Solve(const Sums<N>& sums, double damping, bool fix_first) {
  const auto n = static_cast<int>(sums.diagonal.size());
  std::vector<Eigen::Triplet<double>> elements;
  Eigen::VectorXd gradient(N * n);
  for (int k = 0; k < n; ++k) {
    const auto& block = sums.diagonal[static_cast<std::size_t>(k)];
    const bool fixed = fix_first && k == 0;
    const auto& its_gradient = sums.gradient[static_cast<std::size_t>(k)];
    for (int i = 0; i < N; ++i) {
      for (int j = 0; j <= i; ++j) {
        const double damped = i == j ? block(i, i) * (1 + damping) + 1e-9 : block(i, j);
        if (!fixed) elements.emplace_back(N * k + i, N * k + j, damped);
      }
      if (fixed) elements.emplace_back(i, i, 1.0);
      gradient(N * k + i) = fixed ? 0 : its_gradient(i);
    }
  }
  for (const auto& [place, block] : sums.below) {
    if (fix_first && place.second == 0) continue;
    for (int i = 0; i < N; ++i)
      for (int j = 0; j < N; ++j)
        elements.emplace_back(N * place.first + i, N * place.second + j, block(i, j));
  }
  Eigen::SparseMatrix<double> H(N * n, N * n);
  H.setFromTriplets(elements.begin(), elements.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> solver(H);
  Eigen::VectorXd updates = solver.solve(gradient);
  return solver.info() == Eigen::Success && updates.allFinite() ? updates : Eigen::VectorXd();
}

template <int N>
AdjustmentResult Adjust(const CameraModel& camera, const std::vector<AdjustmentEdge>& edges,
                        const std::vector<AdjustmentPrior>& priors, const AdjustmentOptions& options,
                        std::vector<Matrix3d>& M_WC) {
  const Problem<N> problem(camera, edges, priors, options.outlier_px);
  AdjustmentResult result;
  double damping = 1e-6, cost = problem.Cost(M_WC, nullptr, &result.rms_px);
  constexpr double kMostDamping = 1e6, kGain = 1e-5;
  while (result.iterations < options.most_iterations && !result.converged) {
    Sums<N> sums(M_WC.size());
    problem.Cost(M_WC, &sums, nullptr);
    bool better = false;
    while (!better && damping < kMostDamping && result.iterations < options.most_iterations) {
      ++result.iterations;
      const Eigen::VectorXd updates = Solve<N>(sums, damping, priors.empty());
      std::vector<Matrix3d> tried = M_WC;
      for (std::size_t k = 0; updates.size() > 0 && k < tried.size(); ++k)
        tried[k] = Updated<N>(M_WC[k], updates.template segment<N>(N * static_cast<int>(k)));
      double rms_px = 0;
      const double tried_cost = problem.Cost(tried, nullptr, &rms_px);
      if (updates.size() > 0 && tried_cost <= cost) {
        result.converged = cost - tried_cost <= kGain * cost;
        M_WC = std::move(tried);
        cost = tried_cost;
        result.rms_px = rms_px;
        damping = std::max(damping / 10, 1e-9);
        better = true;
      } else {
        damping *= 10;
      }
    }
    if (!better && damping >= kMostDamping) result.converged = true;  // no way leads down
  }
  return result;
}

}  // namespace

AdjustmentResult AdjustMosaic(MosaicModel model, const CameraModel& camera,
                              const std::vector<AdjustmentEdge>& edges,
                              const std::vector<AdjustmentPrior>& priors, const AdjustmentOptions& options,
                              std::vector<Matrix3d>& M_WC) {
  if (M_WC.size() < 2 && priors.empty()) return {.rms_px = 0, .iterations = 0, .converged = true};
  return model == MosaicModel::kRotation ? Adjust<3>(camera, edges, priors, options, M_WC)
                                         : Adjust<8>(camera, edges, priors, options, M_WC);
}

}  // namespace kestrel::vision
