// SPDX-License-Identifier: Apache-2.0
#include "vision/horizon/circle_fit.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "base/random.h"
#include "geometry/tait_bryan.h"

namespace kestrel::vision {

namespace {

constexpr double kUneven = 0.028;           // rad
constexpr double kDistinctTilt_rad = 0.06;  // rad of tilt between two different answers
constexpr std::size_t kArcs = 16;
constexpr double kNear = 0.015;                           // rad, on the circle
constexpr double kConsensusScatter = 0.006;               // rad
constexpr double kBelow = 0.04, kBin = 0.001;             // rad
constexpr double kWrongShare = 0.04, kWrongRange = 0.35;  // wrong points: evenly over that range, rad

// Densities of a residual under the components of the mixture of CircleFitOptions, and how steeply the log of that of a raised
// point falls with its height.
struct Mixture {
  double on = 0, raised = 0, wrong = 0, pull = 0;
};
Mixture DensitiesOf(double residual, double scatter, const CircleFitOptions& o) {
  Mixture s;
  const double u = residual / scatter;
  s.on = u * u < 50
             ? (1 - o.hill_share - o.tall_share - kWrongShare) * 0.3989 / scatter * std::exp(-u * u / 2)
             : 0;
  if (residual > 0) {
    const double hill = o.hill_share / o.hill_scale * std::exp(-residual / o.hill_scale);
    const double tall = o.tall_share / o.tall_scale * std::exp(-residual / o.tall_scale);
    s.raised = hill + tall;
    s.pull = (hill / o.hill_scale + tall / o.tall_scale) / s.raised;
  }
  s.wrong = kWrongShare / kWrongRange;
  return s;
}

class Fitter {
 public:
  Fitter(const std::vector<ContourPoint>& contour, const CircleFitOptions& options)
      : contour_(contour), o_(options) {
    for (const ContourPoint& p : contour) rows_.emplace_back(std::cos(p.azimuth), std::sin(p.azimuth), 1.0);
    const Mixture wrong = DensitiesOf(-1, kConsensusScatter, o_);
    const auto negative_log = [&](double r) {
      const Mixture s = DensitiesOf(r, kConsensusScatter, o_);
      return -std::log(s.on + s.raised + s.wrong);
    };
    const double lowest = negative_log(0), range = -std::log(wrong.wrong) - lowest;
    for (std::size_t k = 0; k < negative_log_likelihood_.size(); ++k)
      negative_log_likelihood_[k] =
          (negative_log((static_cast<double>(k) + 0.5) * kBin - kBelow) - lowest) / range;
  }

  double Residual(std::size_t i, const Eigen::Vector3d& x) const {
    return contour_[i].elevation - rows_[i].dot(x);
  }

  // How badly the mixture explains the contour, 0 to 1 per point: a raised point is better than one below the
  // circle, which nothing explains.
  double Cost(const Eigen::Vector3d& x, std::size_t stride) const {
    double sum = 0;
    for (std::size_t i = 0; i < rows_.size(); i += stride)
      sum += contour_[i].weight * NegativeLogLikelihood(Residual(i, x));
    const double u = (-x.z() - o_.dip) / DipSigma(x);
    // Haze may hide the horizon by more than its sigma; hardly anything raises all of it.
    const double off = (x.head<2>() - o_.near).norm() / o_.reach;
    return sum * static_cast<double>(stride) + PriorWeight() * std::min(u * u, u > 0 ? 16.0 : 60.0) / 2 +
           o_.near_weight * static_cast<double>(rows_.size()) * off * off;
  }

  Eigen::Vector3d Consensus(double& rival) const {
    SampleSequence samples;
    const std::size_t stride = std::max<std::size_t>(1, rows_.size() / 60);
    Eigen::Vector3d best(o_.near.x(), o_.near.y(), -o_.dip);
    double best_cost = Cost(best, stride);
    std::vector<std::pair<double, Eigen::Vector3d>> trials;
    for (int trial = 0; trial < 200; ++trial) {
      Eigen::Matrix3d A;
      Eigen::Vector3d b;
      for (int k = 0; k < 3; ++k) {
        const std::size_t i = samples.Next(rows_.size());
        A.row(k) = rows_[i].transpose();
        b[k] = contour_[i].elevation;
      }
      if (std::abs(A.determinant()) < 0.2) continue;
      const Eigen::Vector3d x = A.inverse() * b;
      if (x.z() > 0.06 || x.z() < -0.12 || (x.head<2>() - o_.near).norm() > o_.reach) continue;
      const double cost = Cost(x, stride);
      trials.emplace_back(cost, x);
      if (cost < best_cost) best_cost = cost, best = x;
    }
    // By what agrees, not by what does not.
    double mass = 0;
    for (const ContourPoint& p : contour_) mass += p.weight;
    rival = 0;
    for (const auto& [cost, x] : trials)
      if ((x - best).head<2>().norm() > kDistinctTilt_rad)
        rival = std::max(rival, (mass - cost) / std::max(1e-9, mass - best_cost));
    return best;
  }

  // One step of the maximisation: who belongs where, then weighted least squares. The pull of raised points,
  // constant in their height, enters on the right.
  void Step(Eigen::Vector3d& x, double& scatter) const {
    Eigen::Matrix3d H = Prior(x);
    Eigen::Vector3d g = H * Eigen::Vector3d(0, 0, -o_.dip);
    double spread = 0, mass = 0;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const double r = Residual(i, x);
      const Mixture s = DensitiesOf(r, scatter, o_);
      const double on = contour_[i].weight * s.on / (s.on + s.raised + s.wrong);
      const double raised = contour_[i].weight * s.raised / (s.on + s.raised + s.wrong);
      const double w = on / (scatter * scatter);
      H += w * rows_[i] * rows_[i].transpose();
      g += (w * contour_[i].elevation + raised * s.pull) * rows_[i];
      spread += on * r * r;
      mass += on;
    }
    x = H.ldlt().solve(g);
    if (mass > 0) scatter = std::clamp(std::sqrt(spread / mass), o_.min_scatter, o_.max_scatter);
  }

  CircleFit Finish(const Eigen::Vector3d& x, double scatter) const {
    CircleFit fit;
    fit.state = x;
    fit.scatter = scatter;
    Eigen::Matrix3d H = Prior(x);
    std::vector<Eigen::Vector3d> gradients;
    double mass = 0, on_mass = 0, below = 0;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const double r = Residual(i, x);
      const Mixture s = DensitiesOf(r, scatter, o_);
      const double all = s.on + s.raised + s.wrong, on = s.on / all, raised = s.raised / all;
      const double w = contour_[i].weight;
      fit.belongs.push_back(on);
      H += w * on / (scatter * scatter) * rows_[i] * rows_[i].transpose();
      gradients.push_back(w * (on * r / (scatter * scatter) + raised * s.pull) * rows_[i]);
      fit.explained += w * std::max(0.0, 1 - NegativeLogLikelihood(r));
      below += w * (r < -kNear);
      mass += w, on_mass += w * (std::abs(r) < kNear);
    }
    fit.below = mass > 0 ? below / mass : 0;
    fit.strain = (-x.z() - o_.dip) / DipSigma(x);
    fit.on_circle = mass > 0 ? on_mass / mass : 0;
    // Sandwich with the correlation of neighbours (Newey, West 1987), by azimuth.
    const Eigen::Matrix3d inverse = H.inverse();
    Eigen::Matrix3d meat = PriorWeight() * Prior(x);
    const std::size_t n = rows_.size();
    for (std::size_t i = 0; i < n; ++i)
      for (std::size_t k = 0; k < n; ++k) {
        const std::size_t j = (i + k) % n;
        const double apart = contour_[j].azimuth - contour_[i].azimuth + (j < i ? 2 * M_PI : 0);
        if (apart >= o_.correlation) break;
        const double taper = 1 - apart / o_.correlation;
        const Eigen::Matrix3d product = taper * gradients[i] * gradients[j].transpose();
        meat += product;
        if (j != i) meat += product.transpose();
      }
    fit.covariance = inverse * meat * inverse;
    // What the points on the circle could tell at best, were each arc of the correlation one measurement.
    const double arc_points =
        std::max(1.0, o_.correlation / 2 * static_cast<double>(rows_.size()) / (2 * M_PI));
    fit.covariance += inverse * arc_points * 0.25;
    // Hills wider than the correlation, and what is hidden by them or out of view, by experience.
    fit.unevenness = Unevenness(x);
    const double seen = static_cast<double>(n) / o_.azimuths;
    const double relief = o_.relief_share * fit.unevenness * std::pow(std::max(seen, 0.05), -0.8);
    // What raises the whole circle beyond what is expected hardly does so evenly.
    const double raised = o_.raised_share * std::max(0.0, std::abs(x.z() + o_.dip) - o_.dip_under_sigma / 2);
    fit.covariance.diagonal().array() += o_.min_sigma * o_.min_sigma + relief * relief + raised * raised;
    if (o_.arc_relief > 0) fit.covariance += inverse * ArcRelief(fit, scatter) * inverse;
    return fit;
  }

 private:
  // The prior of the dip counts as much as a few arcs of the contour, not as one of hundreds of points.
  double PriorWeight() const { return std::max(1.0, static_cast<double>(rows_.size()) / 100); }
  double DipSigma(const Eigen::Vector3d& x) const {
    return -x.z() > o_.dip ? o_.dip_over_sigma : o_.dip_under_sigma;
  }
  Eigen::Matrix3d Prior(const Eigen::Vector3d& x) const {
    Eigen::Matrix3d p = Eigen::Matrix3d::Zero();
    p(2, 2) = PriorWeight() / (DipSigma(x) * DipSigma(x));
    p(0, 0) = p(1, 1) = 1e-3;
    return p;
  }

  // Of the right-hand side of the fit, were the contour off by a random function of the azimuth: its rows by
  // the exponential covariance of that function, by their weights.
  Eigen::Matrix3d ArcRelief(const CircleFit& fit, double scatter) const {
    Eigen::Matrix3d sum = Eigen::Matrix3d::Zero();
    const double uneven = o_.arc_unevenness_share * fit.unevenness;
    const double raised = o_.arc_raised_share * (fit.state.z() + o_.dip);
    const double relief2 = o_.arc_relief * o_.arc_relief + uneven * uneven + raised * raised;
    std::vector<Eigen::Vector3d> pulls;
    for (std::size_t i = 0; i < rows_.size(); ++i)
      pulls.push_back(contour_[i].weight * fit.belongs[i] / (scatter * scatter) * rows_[i]);
    for (std::size_t i = 0; i < pulls.size(); ++i) {
      Eigen::Vector3d column = Eigen::Vector3d::Zero();
      for (std::size_t j = 0; j < pulls.size(); ++j)
        column +=
            std::exp(-std::abs(WrapAngle(contour_[j].azimuth - contour_[i].azimuth)) / o_.arc_correlation) *
            pulls[j];
      sum += pulls[i] * column.transpose();
    }
    return relief2 * sum;
  }

  // Of the lower quartiles of arcs: trees and houses leave gaps, hills do not.
  double Unevenness(const Eigen::Vector3d& x) const {
    std::array<std::vector<double>, kArcs> arcs;
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      const double turn = contour_[i].azimuth / (2 * M_PI);
      arcs[static_cast<std::size_t>((turn - std::floor(turn)) * kArcs) % kArcs].push_back(Residual(i, x));
    }
    double sum = 0, n = 0;
    for (auto& arc : arcs) {
      if (arc.size() < 3) continue;
      const auto low = arc.begin() + static_cast<std::ptrdiff_t>(arc.size() / 4);
      std::nth_element(arc.begin(), low, arc.end());
      const auto size = static_cast<double>(arc.size());
      sum += size * std::min(*low * *low, kUneven * kUneven), n += size;
    }
    return n > 0 ? std::sqrt(sum / n) : kUneven;
  }

  double NegativeLogLikelihood(double residual) const {
    const auto k = static_cast<std::ptrdiff_t>((residual + kBelow) / kBin);
    return k < 0 ? 1
                 : negative_log_likelihood_[std::min(static_cast<std::size_t>(k),
                                                     negative_log_likelihood_.size() - 1)];
  }

  const std::vector<ContourPoint>& contour_;
  const CircleFitOptions& o_;
  std::array<double, 320> negative_log_likelihood_;  // by residual
  std::vector<Eigen::Vector3d> rows_;
};

}  // namespace

std::optional<PlaneFit> FitPlane(const std::vector<Eigen::Vector3d>& points) {
  if (points.size() < 3) return std::nullopt;
  Eigen::MatrixX3d A(points.size(), 3);
  Eigen::VectorXd b(points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    A.row(row) << points[i].x(), points[i].y(), 1;
    b[row] = points[i].z();
  }
  const Eigen::ColPivHouseholderQR<Eigen::MatrixX3d> qr(A);
  if (qr.rank() < 3) return std::nullopt;
  const Eigen::Vector3d x = qr.solve(b);
  return PlaneFit{x[0], x[1], x[2]};
}

std::optional<CircleFit> FitCircle(const std::vector<ContourPoint>& contour,
                                   const CircleFitOptions& options) {
  if (contour.size() < 8) return std::nullopt;
  const Fitter fitter(contour, options);
  double rival = 0;
  Eigen::Vector3d x = fitter.Consensus(rival);
  double scatter = options.max_scatter;
  for (int k = 0; k < 12; ++k) {
    const Eigen::Vector3d before = x;
    fitter.Step(x, scatter);
    if ((x - before).norm() < 1e-6) break;
  }
  CircleFit fit = fitter.Finish(x, scatter);
  fit.rival = rival;
  return fit;
}

}  // namespace kestrel::vision
