// SPDX-License-Identifier: Apache-2.0
#include "vision/landmark/estimation/homography_solutions.h"

#include <Eigen/Dense>
#include <cmath>
#include <vector>

#include "vision/least_squares.h"

namespace kestrel::vision {
namespace {

using Matrix3 = Eigen::Matrix3d;
using Vector2 = Eigen::Vector2d;
using Vector8 = Eigen::Matrix<double, 8, 1>;
using Vector9 = Eigen::Matrix<double, 9, 1>;

constexpr int kSteps = 50;
constexpr double kSmallStep = 1e-12;  // of H, whose norm is 1

// A similarity: the centroid to the origin, the root mean square distance to sqrt(2).
struct Scaling {
  Vector2 centre;
  double scale;

  Vector2 operator()(const Vector2& x) const { return scale * (x - centre); }
  Matrix3 Matrix() const {
    Matrix3 m;
    m << scale, 0, -scale * centre.x(), 0, scale, -scale * centre.y(), 0, 0, 1;
    return m;
  }
};

Scaling ScalingOf(std::span<const PointPair> pairs, Vector2 PointPair::*side) {
  const double n = static_cast<double>(pairs.size());
  Vector2 centre = Vector2::Zero();
  for (const PointPair& pair : pairs) centre += pair.*side / n;
  double square = 0;
  for (const PointPair& pair : pairs) square += (pair.*side - centre).squaredNorm() / n;
  return {centre, square > 0 ? std::sqrt(2 / square) : 1};
}

// The pairs in coordinates of their own, and the way back.
struct ScaledPairs {
  explicit ScaledPairs(std::span<const PointPair> given)
      : from(ScalingOf(given, &PointPair::from)), to(ScalingOf(given, &PointPair::to)) {
    for (const PointPair& pair : given) pairs.push_back({from(pair.from), to(pair.to)});
  }
  Matrix3 Scaled(const Matrix3& H) const {
    const Matrix3 scaled = to.Matrix() * H * from.Matrix().inverse();
    return scaled / scaled.norm();
  }
  std::optional<Matrix3> Original(const Matrix3& scaled) const {
    Matrix3 H = to.Matrix().inverse() * scaled * from.Matrix();
    H /= H.norm();
    if (!H.allFinite() || std::abs(H.determinant()) < 1e-15) return std::nullopt;
    return H;
  }

  Scaling from, to;
  std::vector<PointPair> pairs;
};

// Rows of H one after the other.
Matrix3 Unstacked(const Vector9& h) {
  Matrix3 H;
  H << h(0), h(1), h(2), h(3), h(4), h(5), h(6), h(7), h(8);
  return H;
}
Vector9 Stacked(const Matrix3& H) {
  Vector9 h;
  h << H.row(0).transpose(), H.row(1).transpose(), H.row(2).transpose();
  return h;
}

// Where H takes x, and its derivative by the rows of H.
Vector2 TransferWithDerivative(const Matrix3& H, const Vector2& x, Eigen::Matrix<double, 2, 9>& d_h) {
  const Eigen::Vector3d y = H * x.homogeneous();
  const Vector2 at = y.hnormalized();
  const Eigen::RowVector3d part = x.homogeneous().transpose() / y.z();
  d_h << part, Eigen::RowVector3d::Zero(), -at.x() * part, Eigen::RowVector3d::Zero(), part, -at.y() * part;
  return at;
}

// What is squared and summed for one pair, of the original unit, and its derivative by the rows of the scaled H.
struct Residual {
  Eigen::Vector4d r = Eigen::Vector4d::Zero();  // of Sampson's error the first two
  Eigen::Matrix<double, 4, 9> d_h = Eigen::Matrix<double, 4, 9>::Zero();
};

Residual SymmetricTransfer(const Matrix3& H, const PointPair& pair, double unit_from, double unit_to) {
  Residual residual;
  Eigen::Matrix<double, 2, 9> d_forward;
  residual.r.head<2>() = (TransferWithDerivative(H, pair.from, d_forward) - pair.to) * unit_to;
  residual.d_h.topRows<2>() = d_forward * unit_to;
  const Matrix3 inverse = H.inverse();
  const Eigen::Vector3d z = inverse * pair.to.homogeneous();
  const Vector2 back = z.hnormalized();
  residual.r.tail<2>() = (back - pair.from) * unit_from;
  Eigen::Matrix<double, 2, 3> d_z;
  d_z << 1, 0, -back.x(), 0, 1, -back.y();
  d_z *= unit_from / z.z();
  const Eigen::Matrix<double, 2, 3> by_row = -d_z * inverse;  // dz = -H^-1 dH z
  for (int row = 0; row < 3; ++row) residual.d_h.block<2, 3>(2, 3 * row) = by_row.col(row) * z.transpose();
  return residual;
}

// With C the two algebraic errors y.head(2) - y.z() x' of y = H x, and S what noise of deviation 1 in all four
// coordinates makes of them, the squared distance is C' S^-1 C: here r = L^-1 C with S = L L'.
Vector2 SampsonResidual(const Matrix3& H, const PointPair& pair, double unit_from, double unit_to) {
  const Eigen::Vector3d y = H * pair.from.homogeneous();
  const Vector2 C = y.head<2>() - y.z() * pair.to;
  const Eigen::Matrix2d by_from = H.topLeftCorner<2, 2>() - pair.to * H.row(2).head<2>();
  const Eigen::Matrix2d S = by_from * by_from.transpose() / (unit_from * unit_from) +
                            Eigen::Matrix2d::Identity() * y.z() * y.z() / (unit_to * unit_to);
  const Eigen::LLT<Eigen::Matrix2d> llt(S);
  return llt.matrixL().solve(C);
}

Residual Sampson(const Matrix3& H, const PointPair& pair, double unit_from, double unit_to) {
  Residual residual;
  residual.r.head<2>() = SampsonResidual(H, pair, unit_from, unit_to);
  constexpr double kStep = 1e-6;  // central differences: the error of a derivative is its square
  for (int k = 0; k < 9; ++k) {
    Matrix3 plus = H, minus = H;
    plus(k / 3, k % 3) += kStep, minus(k / 3, k % 3) -= kStep;
    residual.d_h.col(k).head<2>() =
        (SampsonResidual(plus, pair, unit_from, unit_to) - SampsonResidual(minus, pair, unit_from, unit_to)) /
        (2 * kStep);
  }
  return residual;
}

NormalEquations<double, 8> NormalAt(const Matrix3& H, const Eigen::Matrix<double, 9, 8>& tangent,
                                    const ScaledPairs& scaled, GeometricError error) {
  NormalEquations<double, 8> normal;
  const double unit_from = 1 / scaled.from.scale, unit_to = 1 / scaled.to.scale;
  for (const PointPair& pair : scaled.pairs) {
    const Residual one = error == GeometricError::kSampson ? Sampson(H, pair, unit_from, unit_to)
                                                           : SymmetricTransfer(H, pair, unit_from, unit_to);
    normal.Add<4>(one.d_h * tangent, -one.r);
  }
  return normal;
}

double SquaresAt(const Matrix3& H, const ScaledPairs& scaled, GeometricError error) {
  const double unit_from = 1 / scaled.from.scale, unit_to = 1 / scaled.to.scale;
  const Matrix3 inverse = H.inverse();
  double sum = 0;
  for (const PointPair& pair : scaled.pairs) {
    if (error == GeometricError::kSampson)
      sum += SampsonResidual(H, pair, unit_from, unit_to).squaredNorm();
    else
      sum += unit_to * unit_to * (Transfer(H, pair.from) - pair.to).squaredNorm() +
             unit_from * unit_from * (Transfer(inverse, pair.to) - pair.from).squaredNorm();
  }
  return sum;
}

}  // namespace

std::optional<Matrix3> FitInhomogeneous(std::span<const PointPair> pairs) {
  if (pairs.size() <= 4) return FitHomography(pairs);  // by elimination
  const ScaledPairs scaled(pairs);
  Eigen::Matrix<double, Eigen::Dynamic, 8> A(2 * pairs.size(), 8);
  Eigen::VectorXd b(2 * pairs.size());
  for (std::size_t i = 0; i < pairs.size(); ++i) {
    const auto& [x, y] = scaled.pairs[i];
    const auto row = static_cast<Eigen::Index>(2 * i);
    A.row(row) << x.x(), x.y(), 1, 0, 0, 0, -x.x() * y.x(), -x.y() * y.x();
    A.row(row + 1) << 0, 0, 0, x.x(), x.y(), 1, -x.x() * y.y(), -x.y() * y.y();
    b.segment<2>(row) = y;
  }
  Eigen::CompleteOrthogonalDecomposition<Eigen::Matrix<double, Eigen::Dynamic, 8>> decomposition;
  decomposition.setThreshold(1e-6);
  decomposition.compute(A);
  if (decomposition.rank() < 8) return std::nullopt;  // the points leave H open
  Vector9 h;
  h << decomposition.solve(b), 1;
  return scaled.Original(Unstacked(h));
}

std::optional<Matrix3> FitGeometric(std::span<const PointPair> pairs, GeometricError error) {
  const auto start = FitHomography(pairs);
  if (!start) return std::nullopt;
  return RefineHomography(pairs, *start, error);
}

std::optional<Matrix3> RefineHomography(std::span<const PointPair> pairs, const Matrix3& H_start,
                                        GeometricError error) {
  if (pairs.size() < 4) return std::nullopt;
  const ScaledPairs scaled(pairs);
  Matrix3 H = scaled.Scaled(H_start);
  double squares = SquaresAt(H, scaled, error), damping = 1e-4;
  if (!std::isfinite(squares)) return std::nullopt;
  for (int step = 0; step < kSteps; ++step) {
    // H has eight degrees of freedom: it moves across itself.
    const Vector9 h = Stacked(H);
    const Eigen::Matrix<double, 9, 9> basis = Eigen::HouseholderQR<Vector9>(h).householderQ();
    const Eigen::Matrix<double, 9, 8> tangent = basis.rightCols<8>();
    NormalEquations<double, 8> normal = NormalAt(H, tangent, scaled, error);
    const Vector8 diagonal = normal.H.diagonal();
    bool better = false;
    double moved = 0;
    for (; !better && damping < 1e8; damping *= better ? 0.1 : 10) {
      Eigen::Matrix<double, 8, 8> damped = normal.H;
      damped.diagonal() += damping * diagonal;
      const Vector8 d = damped.ldlt().solve(normal.g);
      const Matrix3 moved_H = Unstacked((h + tangent * d).normalized());
      const double then = SquaresAt(moved_H, scaled, error);
      moved = d.norm();
      better = then <= squares;  // written so that NaN is not
      if (better) H = moved_H, squares = then;
      if (moved < kSmallStep) break;
    }
    if (!better || moved < kSmallStep) break;
  }
  return scaled.Original(H);
}

double SumOfSquares(std::span<const PointPair> pairs, const Matrix3& H, GeometricError error) {
  double sum = 0;
  const Matrix3 inverse = H.inverse();
  for (const PointPair& pair : pairs)
    sum += error == GeometricError::kSampson ? SampsonResidual(H, pair, 1, 1).squaredNorm()
                                             : (Transfer(H, pair.from) - pair.to).squaredNorm() +
                                                   (Transfer(inverse, pair.to) - pair.from).squaredNorm();
  return sum;
}

}  // namespace kestrel::vision
