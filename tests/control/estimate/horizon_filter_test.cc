// SPDX-License-Identifier: Apache-2.0
#include "control/estimate/horizon_filter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "geometry/pose.h"
#include "geometry/tait_bryan.h"

namespace kestrel::control {
namespace {

constexpr double kStep_s = 0.01;

// An aircraft that rolls, pitches and turns, its gyro with a bias, its camera late.
class Flight {
 public:
  explicit Flight(HorizonFilter& filter) : filter_(filter) {}

  void Fly(double duration_s, bool camera) {
    for (const double end = t_s + duration_s; t_s < end - 1e-9;) {
      const Eigen::Vector3d rate(0.5 * std::sin(1.3 * t_s), 0.4 * std::cos(0.9 * t_s), 0.3);
      filter_.Add({t_s, rate + bias});
      if (camera && ++count_ % 5 == 0) pending_.push_back({t_s, R_NB});
      if (!pending_.empty() && pending_.front().first <= t_s - 0.1) {
        const auto [then, R] = pending_.front();
        pending_.pop_front();
        accepted += filter_.Correct(Seen(then, R));
      }
      const Eigen::Vector3d next(0.5 * std::sin(1.3 * (t_s + kStep_s)), 0.4 * std::cos(0.9 * (t_s + kStep_s)),
                                 0.3);
      truth = R_NB;
      R_NB = (R_NB * ExpRotation((rate + next) / 2 * kStep_s)).normalized();
      t_s += kStep_s;
    }
  }
  HorizonFilter::Attitude Seen(double t, const Eigen::Quaterniond& R) {
    HorizonFilter::Attitude a;
    a.t_s = t;
    const Eigen::Vector3d down = R.conjugate() * Eigen::Vector3d::UnitZ();
    a.down_B =
        (ExpRotation(Radians(0.3) * Eigen::Vector3d(normal_(draw_), normal_(draw_), normal_(draw_))) * down);
    const double s = Radians(0.3);
    a.covariance = s * s * (Eigen::Matrix3d::Identity() - down * down.transpose());
    a.heading = YawOf(R) + Radians(0.4) * normal_(draw_);
    a.heading_variance = Radians(0.4) * Radians(0.4);
    return a;
  }
  double ErrorDeg() const { return Degrees(LogRotation(truth.conjugate() * filter_.Now()->R_NB).norm()); }

  double t_s = 0;
  int accepted = 0;
  Eigen::Vector3d bias{0.01, -0.006, 0.008};
  Eigen::Quaterniond R_NB{HeadingRotation(0.7)}, truth = R_NB;

 private:
  HorizonFilter& filter_;
  std::mt19937 draw_{9};
  std::normal_distribution<double> normal_;
  std::deque<std::pair<double, Eigen::Quaterniond>> pending_;
  int count_ = 0;
};

TEST(HorizonFilter, FindsAttitudeAndBiasFromLateAndNoisyImages) {
  HorizonFilter filter({});
  Flight flight(filter);
  EXPECT_FALSE(filter.Now());
  flight.Fly(60, true);
  const auto now = filter.Now();
  ASSERT_TRUE(now);
  EXPECT_GT(flight.accepted, 1000);
  EXPECT_LT(flight.ErrorDeg(), 0.4);
  EXPECT_LT((now->bias_B - flight.bias).norm(), Radians(0.12));
  EXPECT_LT(now->coasting_s, 0.25);
  // Its own word for its error is neither boast nor alarm.
  const double said = Degrees(std::sqrt(now->P.topLeftCorner<3, 3>().trace()));
  EXPECT_GT(said, 0.05);
  EXPECT_LT(said, 1.0);
}

TEST(HorizonFilter, CoastsOnTheGyroAndSaysForHowLong) {
  HorizonFilter filter({});
  Flight flight(filter);
  flight.Fly(40, true);
  const double before = filter.Now()->P.topLeftCorner<3, 3>().trace();
  flight.Fly(5, false);
  EXPECT_NEAR(filter.Now()->coasting_s, 5, 0.3);
  EXPECT_GT((filter.Now()->P.topLeftCorner<3, 3>().trace()), before);
  EXPECT_LT(flight.ErrorDeg(), 1.0);
}

TEST(HorizonFilter, RefusesAWrongImageButBelievesManyThatAgree) {
  HorizonFilterOptions options;
  HorizonFilter filter(options);
  Flight flight(filter);
  flight.Fly(20, true);
  HorizonFilter::Attitude wrong = flight.Seen(flight.t_s - kStep_s, flight.truth);
  wrong.down_B = ExpRotation({Radians(20), 0, 0}) * wrong.down_B;
  EXPECT_FALSE(filter.Correct(wrong));
  EXPECT_LT(flight.ErrorDeg(), 0.5);
  int refused = 1;
  while (refused < 50 && !filter.Correct(wrong)) ++refused;
  EXPECT_EQ(refused, options.refusals - 1);
  EXPECT_GT(flight.ErrorDeg(), 15);
}

TEST(HorizonFilter, AnImageFromBeforeItsMemoryIsTooLate) {
  HorizonFilter filter({});
  Flight flight(filter);
  flight.Fly(3, true);
  EXPECT_FALSE(filter.Correct(flight.Seen(0.5, flight.truth)));
}

}  // namespace
}  // namespace kestrel::control
