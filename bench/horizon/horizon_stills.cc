// SPDX-License-Identifier: Apache-2.0
#include "bench/horizon/horizon_stills.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "base/random.h"
#include "sim/world/frames.h"

namespace kestrel::bench {
namespace {

constexpr double kReach_m = 250;  // of the places; level ground ends at 300 m
constexpr double kTurn = 2 * std::numbers::pi;

// Halton 1960: the digits of the index to a prime base, mirrored at the point.
double Halton(std::uint64_t index, std::uint64_t base) {
  double value = 0, digit = 1;
  for (; index > 0; index /= base) {
    digit /= static_cast<double>(base);
    value += digit * static_cast<double>(index % base);
  }
  return value;
}

// A point of the unit cube for each index, all of them shifted alike by the seed.
class Points {
 public:
  Points(std::uint64_t seed, const char* name) {
    RandomStream random(seed, name);
    for (double& shift : shift_) shift = random.Uniform(0, 1);
  }
  double At(std::uint64_t index, std::size_t axis) const {
    static constexpr std::uint64_t kPrimes[kAxes] = {2, 3, 5, 7, 11, 13};
    const double value = Halton(index + 1, kPrimes[axis]) + shift_[axis];
    return value - std::floor(value);
  }

 private:
  static constexpr std::size_t kAxes = 6;
  double shift_[kAxes];
};

double Between(double low, double high, double u) { return low + (high - low) * u; }
double BetweenLog(double low, double high, double u) { return low * std::pow(high / low, u); }

}  // namespace

StillSweep DrawSweep(const std::vector<StillLandscape>& worlds, int landscapes_each, int stills_each,
                     std::uint64_t seed) {
  constexpr double kWithoutRidge = 0.3;
  StillSweep sweep;
  const Points of_landscape(seed, "still landscapes"), of_still(seed, "stills");
  RandomStream random(seed, "still landscapes, what is even anyway"), expected(seed, "stills, expected");
  for (const StillLandscape& world : worlds) {
    for (int k = 0; k < landscapes_each; ++k) {
      const auto u = [&](std::size_t axis) { return of_landscape.At(sweep.landscapes.size(), axis); };
      StillLandscape l = world;
      sim::LandscapeParameters& p = l.parameters;
      p.seed = 1 + random.Bits() / 2;
      p.haze_m *= BetweenLog(0.3, 1.5, u(0));
      p.ridge.height_deg = std::max(0.0, 10 * (u(1) - kWithoutRidge) / (1 - kWithoutRidge));
      p.ridge.width_deg = Between(40, 150, u(2));
      p.ridge.distance_m = BetweenLog(2000, 15000, u(3));
      p.ridge.azimuth_deg = random.Uniform(-180, 180);
      p.sun_elevation_deg *= Between(0.4, 1.4, u(4));
      p.sun_azimuth_deg = random.Uniform(-180, 180);
      p.light *= Between(0.5, 1, u(5));
      sweep.landscapes.push_back(l);
    }
  }
  for (int l = 0; l < static_cast<int>(sweep.landscapes.size()); ++l) {
    for (int k = 0; k < stills_each; ++k) {
      const auto u = [&](std::size_t axis) { return of_still.At(sweep.stills.size(), axis); };
      Still s;
      s.landscape = l;
      s.attitude.roll = Radians(Between(-45, 45, u(0)));
      s.attitude.pitch = Radians(Between(-45, 45, u(1)));
      s.height_m = BetweenLog(2, 500, u(2));
      s.attitude.yaw = WrapAngle(kTurn * u(3));
      const double away = kReach_m * std::sqrt(u(4)), towards = kTurn * u(5);
      s.place_m = away * Eigen::Vector2d(std::cos(towards), std::sin(towards));
      for (double& e : s.expected) e = kExpectedDownSigma * expected.Normal();
      s.expected_height_m = std::max(0.0, s.height_m + kExpectedHeightSigma_m * expected.Normal());
      sweep.stills.push_back(s);
    }
  }
  return sweep;
}

Eigen::Vector3d ExpectedDown(const Eigen::Vector3d& down_C, const Still& still) {
  const Eigen::Vector3d u = down_C.unitOrthogonal(), v = down_C.cross(u);
  return (down_C + std::tan(still.expected.x()) * u + std::tan(still.expected.y()) * v).normalized();
}

StillRenderer::StillRenderer(const StillLandscape& landscape, sim::SceneParameters scene,
                             const vision::CameraModel& camera, const Pose& X_BC)
    : model_([&] {
        scene.landscape = landscape.parameters;
        return sim::MakeModel(scene);
      }()),
      data_(sim::MakeData(model_.get())),
      X_BC_(X_BC),
      renderer_(model_.get(), camera, {}) {}

Pose StillRenderer::PoseOf(const Still& still, std::uint64_t seed) {
  const auto at = [&](const Eigen::Vector2d& place_m) {
    return Pose{Eigen::Quaterniond(RotationFromTaitBryan(still.attitude)),
                {place_m.x(), place_m.y(), -still.height_m}};
  };
  if (Free(still.place_m, still.height_m)) return at(still.place_m);
  // The heading tells apart what the seed and the height alone may not.
  RandomStream random(seed ^ RandomStream::Mix(std::bit_cast<std::uint64_t>(still.attitude.yaw)),
                      "stills, free place");
  for (;;) {
    const double away = kReach_m * std::sqrt(random.Uniform(0, 1)), towards = random.Uniform(0, kTurn);
    const Eigen::Vector2d place = away * Eigen::Vector2d(std::cos(towards), std::sin(towards));
    if (Free(place, still.height_m)) return at(place);
  }
}

bool StillRenderer::Free(const Eigen::Vector2d& place_m, double height_m) {
  constexpr double kTallest_m = 40, kAround_m = 1.5, kOut_m = 5000;
  if (height_m > kTallest_m) return true;
  PutAircraft({Eigen::Quaterniond::Identity(), {0, 0, -kOut_m}});
  for (const Eigen::Vector2d& side :
       {Eigen::Vector2d(0, 0), Eigen::Vector2d(1, 0), {-1, 0}, {0, 1}, {0, -1}}) {
    const Eigen::Vector2d p = place_m + kAround_m * side;
    const mjtNum from[3] = {p.x(), -p.y(), 2 * kTallest_m}, down[3] = {0, 0, -1};
    int geom = -1;
    const double top_m =
        2 * kTallest_m - mj_ray(model_.get(), data_.get(), from, down, nullptr, 1, -1, &geom);
    if (geom >= 0 && top_m > std::max(0.5, height_m - kAround_m)) return false;
  }
  return true;
}

void StillRenderer::PutAircraft(const Pose& X_NB) {
  const int joint = model_->body_jntadr[mj_name2id(model_.get(), mjOBJ_BODY, "vehicle")];
  sim::PoseToMujoco(X_NB, data_->qpos + model_->jnt_qposadr[joint]);
  mj_forward(model_.get(), data_.get());
}

cv::Mat StillRenderer::Draw(const Pose& X_NB) {
  PutAircraft(X_NB);
  return renderer_.Render(data_.get(), X_NB * X_BC_);
}

}  // namespace kestrel::bench
