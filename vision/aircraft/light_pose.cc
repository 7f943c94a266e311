// SPDX-License-Identifier: Apache-2.0
#include "vision/aircraft/light_pose.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "geometry/tait_bryan.h"

namespace kestrel::vision {
namespace {

constexpr int kTurns = 24;        // tried, of an aircraft whose turn is not known
constexpr double kFit_px = 1.5;   // RMS above which a pose does not explain its spots
constexpr double kInlier_px = 3;  // of a refined pose
constexpr int kIterations = 12;
constexpr double kWhole =
    0.65;  // share of a light's area that its spot must have, and no more than the inverse
constexpr double kFar = 0.35;  // of the range: from where an aircraft is expected to where it is

// Of each light its spot; negative: none.
using Matches = std::vector<int>;

struct Candidate {
  Pose X_CB;
  Matches matches;
  int count = 0;
  double error_px = std::numeric_limits<double>::infinity();  // sum of squares
};

bool Better(const Candidate& a, const Candidate& b) {
  return a.count != b.count ? a.count > b.count : a.error_px < b.error_px;
}

class Problem {
 public:
  Problem(const std::vector<LightSpot>& spots, const AircraftLights& lights, const CameraModel& camera,
          const LightPoseOptions& options)
      : spots_(spots), lights_(lights), camera_(camera), options_(options) {
    for (const LightSpot& spot : spots) {
      const auto ray = Ray(camera, spot.centre);
      rays_.push_back(ray.value_or(Eigen::Vector3d::Zero()));
    }
  }

  bool MayBe(std::size_t spot, std::size_t light) const {
    return rays_[spot].norm() > 0 && spots_[spot].colour == lights_.lights[light].colour;
  }

  // The position at which, with this attitude, two lights are on the rays of two spots: of each the part
  // across its ray is zero, in least squares.
  std::optional<Eigen::Vector3d> Position(const Eigen::Quaterniond& R_CB, std::size_t spot_a,
                                          std::size_t light_a, std::size_t spot_b,
                                          std::size_t light_b) const {
    Eigen::Matrix3d A = Eigen::Matrix3d::Zero();
    Eigen::Vector3d b = Eigen::Vector3d::Zero();
    for (const auto& [spot, light] : {std::pair{spot_a, light_a}, std::pair{spot_b, light_b}}) {
      const Eigen::Matrix3d across = Eigen::Matrix3d::Identity() - rays_[spot] * rays_[spot].transpose();
      A += across;
      b -= across * (R_CB * lights_.lights[light].position_m);
    }
    if (std::abs(A.determinant()) < 1e-12) return std::nullopt;
    const Eigen::Vector3d p = A.inverse() * b;
    if (p.dot(rays_[spot_a]) <= 0.3 || p.norm() > options_.max_range_m) return std::nullopt;
    return p;
  }

  // Each light with the nearest spot of its colour that is no nearer to another. whole: only spots as large as
  // the light is there; the centre of one that is partly hidden, or of two in one, is beside the light's.
  Candidate Match(const Pose& X_CB, double within_px, bool whole = false) const {
    Candidate c{.X_CB = X_CB, .matches = Matches(lights_.lights.size(), -1), .error_px = 0};
    std::vector<int> owner(spots_.size(), -1);
    std::vector<double> nearest(spots_.size(), within_px * within_px);
    for (std::size_t l = 0; l < lights_.lights.size(); ++l) {
      Eigen::Matrix<double, 2, 3> d_point;
      const auto uv = Project(camera_, X_CB * lights_.lights[l].position_m, &d_point);
      if (!uv) continue;
      const double diameter_px = lights_.diameter_m * d_point.norm() / std::numbers::sqrt2;
      const double area_px = std::numbers::pi / 4 * diameter_px * diameter_px;
      int best = -1;
      double least = within_px * within_px;
      for (std::size_t s = 0; s < spots_.size(); ++s) {
        const double off = (spots_[s].centre - *uv).squaredNorm();
        const bool fits =
            !whole || (spots_[s].area_px > kWhole * area_px && spots_[s].area_px < area_px / kWhole);
        if (MayBe(s, l) && fits && off < least) {
          least = off;
          best = static_cast<int>(s);
        }
      }
      if (best < 0 || least >= nearest[static_cast<std::size_t>(best)]) continue;
      int& before = owner[static_cast<std::size_t>(best)];
      if (before >= 0) c.matches[static_cast<std::size_t>(before)] = -1;
      before = static_cast<int>(l);
      nearest[static_cast<std::size_t>(best)] = least;
      c.matches[l] = best;
    }
    for (std::size_t l = 0; l < c.matches.size(); ++l)
      if (c.matches[l] >= 0) {
        ++c.count;
        c.error_px += nearest[static_cast<std::size_t>(c.matches[l])];
      }
    return c;
  }

  // Gauss and Newton over position and attitude; the attitude is held near the expected one by its weights.
  // Returns the information, of which the covariance is the inverse.
  std::optional<Eigen::Matrix<double, 6, 6>> Refine(Candidate& c, const Eigen::Quaterniond& R_CB_expected,
                                                    const Eigen::Matrix3d& attitude_information) const {
    const double weight = 1 / (options_.spot_sigma_px * options_.spot_sigma_px);
    Eigen::Matrix<double, 6, 6> H;
    for (int i = 0; i < kIterations; ++i) {
      H.setZero();
      Eigen::Matrix<double, 6, 1> g = Eigen::Matrix<double, 6, 1>::Zero();
      for (std::size_t l = 0; l < c.matches.size(); ++l) {
        if (c.matches[l] < 0) continue;
        Eigen::Matrix<double, 2, 3> d_point;
        const Eigen::Vector3d b = lights_.lights[l].position_m;
        const auto uv = Project(camera_, c.X_CB * b, &d_point);
        if (!uv) return std::nullopt;
        Eigen::Matrix<double, 2, 6> J;
        J << d_point, -d_point * (c.X_CB.R.toRotationMatrix() * Skew(b));
        const Eigen::Vector2d r = spots_[static_cast<std::size_t>(c.matches[l])].centre - *uv;
        H += weight * J.transpose() * J;
        g += weight * J.transpose() * r;
      }
      const Eigen::Vector3d off = LogRotation(c.X_CB.R.conjugate() * R_CB_expected);
      H.bottomRightCorner<3, 3>() += attitude_information;
      g.tail<3>() += attitude_information * off;
      const Eigen::LDLT<Eigen::Matrix<double, 6, 6>> solver(H);
      if (solver.info() != Eigen::Success || !solver.isPositive()) return std::nullopt;
      const Eigen::Matrix<double, 6, 1> step = solver.solve(g);
      if (!step.allFinite()) return std::nullopt;
      c.X_CB.p += step.head<3>();
      c.X_CB.R = (c.X_CB.R * ExpRotation(step.tail<3>())).normalized();
      if (step.head<3>().norm() < 1e-6 && step.tail<3>().norm() < 1e-7) break;
    }
    if (!(c.X_CB.p.norm() < options_.max_range_m)) return std::nullopt;
    return H;
  }

  const std::vector<LightSpot>& spots() const { return spots_; }
  const AircraftLights& lights() const { return lights_; }

  // How far a light may be from where a pose taken from two spots has it, px: the attitude is only expected.
  double Reach_px(const Eigen::Vector3d& p_C, double angle) const {
    double arm = 0;
    for (const AircraftLight& light : lights_.lights) arm = std::max(arm, light.position_m.norm());
    Eigen::Matrix<double, 2, 3> d_point;
    if (!Project(camera_, p_C, &d_point)) return 0;
    return 2 + d_point.norm() / std::numbers::sqrt2 * arm * angle;
  }

 private:
  const std::vector<LightSpot>& spots_;
  const AircraftLights& lights_;
  const CameraModel& camera_;
  const LightPoseOptions& options_;
  std::vector<Eigen::Vector3d> rays_;
};

Candidate BestStart(const Problem& problem, const std::vector<Eigen::Quaterniond>& attitudes, double angle,
                    const std::optional<Eigen::Vector3d>& p_C) {
  Candidate best;
  const std::size_t spots = problem.spots().size(), lights = problem.lights().lights.size();
  for (const Eigen::Quaterniond& R_CB : attitudes)
    for (std::size_t i = 0; i < spots; ++i)
      for (std::size_t j = i + 1; j < spots; ++j)
        for (std::size_t a = 0; a < lights; ++a)
          for (std::size_t b = 0; b < lights; ++b) {
            if (a == b || !problem.MayBe(i, a) || !problem.MayBe(j, b)) continue;
            const auto p = problem.Position(R_CB, i, a, j, b);
            if (!p || (p_C && (*p - *p_C).norm() > kFar * p_C->norm())) continue;
            const Candidate c = problem.Match({R_CB, *p}, problem.Reach_px(*p, angle));
            if (Better(c, best)) best = c;
          }
  return best;
}

}  // namespace

std::optional<LightPose> PoseFromLights(const std::vector<LightSpot>& spots, const AircraftLights& lights,
                                        const CameraModel& camera, const ExpectedAircraft& expected,
                                        const Eigen::Vector3d& down_C, const LightPoseOptions& options) {
  const Problem problem(spots, lights, camera, options);
  const double tilt_sigma = Radians(options.tilt_sigma_deg);
  std::vector<Eigen::Quaterniond> attitudes;
  const int turns = expected.yaw_sigma ? 1 : kTurns;
  for (int i = 0; i < turns; ++i)
    attitudes.push_back(ExpRotation(2 * std::numbers::pi * i / turns * down_C.normalized()) * expected.R_CB);
  const double turn_sigma = expected.yaw_sigma.value_or(std::numbers::pi / turns);
  Candidate c = BestStart(problem, attitudes, 2 * tilt_sigma + turn_sigma, expected.p_CB);
  const int needed = expected.p_CB && expected.yaw_sigma ? 3 : 4;
  if (c.count < needed) return std::nullopt;

  const Eigen::Quaterniond R_CB_start = c.X_CB.R;
  const Eigen::Vector3d down_B = R_CB_start.conjugate() * down_C.normalized();
  const double known_turn = expected.yaw_sigma ? 1 / (turn_sigma * turn_sigma) : 0;
  const Eigen::Matrix3d about_down = down_B * down_B.transpose();
  const Eigen::Matrix3d information =
      (Eigen::Matrix3d::Identity() - about_down) / (tilt_sigma * tilt_sigma) + known_turn * about_down;
  std::optional<Eigen::Matrix<double, 6, 6>> H = problem.Refine(c, R_CB_start, information);
  if (!H) return std::nullopt;
  // The refined pose may take in others, and leave out one that is none of them.
  c = problem.Match(c.X_CB, kInlier_px, true);
  if (c.count < needed) return std::nullopt;
  H = problem.Refine(c, R_CB_start, information);
  if (!H) return std::nullopt;
  const Candidate judged = problem.Match(c.X_CB, kInlier_px, true);
  const double rms = std::sqrt(judged.error_px / std::max(1, judged.count));
  if (judged.count < needed || rms > kFit_px) return std::nullopt;
  return LightPose{c.X_CB, H->inverse(), judged.count, rms};
}

}  // namespace kestrel::vision
