// SPDX-License-Identifier: Apache-2.0
#include "sim/world/wind.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

#include "geometry/tait_bryan.h"

namespace kestrel::sim {
namespace {

using Eigen::Vector3d;

const Vector3d kHovering = Vector3d::Zero();

// Along the mean wind, to the right of it, down.
Vector3d InWindAxes(const Vector3d& v_N, double from_deg) {
  const double to = Radians(from_deg) + std::numbers::pi;
  return {std::cos(to) * v_N.x() + std::sin(to) * v_N.y(), -std::sin(to) * v_N.x() + std::cos(to) * v_N.y(),
          v_N.z()};
}

Vector3d Sigmas(const DrydenScales& s) { return {s.sigma_u, s.sigma_v, s.sigma_w}; }
Vector3d Lengths(const DrydenScales& s) { return {s.length_u_m, s.length_v_m, s.length_w_m}; }

TEST(Wind, MeanBlowsFromItsDirection) {
  EXPECT_LT((Wind({.mean_m_s = 5, .from_deg = 0}, 1).Velocity() - Vector3d(-5, 0, 0)).norm(), 1e-14);
  EXPECT_LT((Wind({.mean_m_s = 5, .from_deg = 90}, 1).Velocity() - Vector3d(0, -5, 0)).norm(), 1e-14);
  EXPECT_LT(
      (Wind({.mean_m_s = 5, .from_deg = 225}, 1).Velocity() - 5 * Vector3d(1, 1, 0).normalized()).norm(),
      1e-14);
}

TEST(Wind, SteadyWindStaysAsItIs) {
  Wind wind({.mean_m_s = 5, .from_deg = 90}, 1);
  for (int i = 0; i < 100; ++i) wind.Step(0.1, 10, {1, 2, 3});
  EXPECT_LT((wind.Velocity() - Vector3d(0, -5, 0)).norm(), 1e-14);
}

TEST(Wind, NoWindIsExactlyZero) {
  Wind wind({.mean_m_s = 0, .turbulence = true, .gusts = {.rate_per_min = 60, .amplitude_m_s = 0}}, 1);
  for (int i = 0; i < 1000; ++i) {
    wind.Step(0.02, 3, kHovering);
    ASSERT_EQ(wind.Velocity(), Vector3d::Zero());
  }
}

TEST(Dryden, ScalesMeetTheIsotropicOnesAtAThousandFeet) {
  // where the low altitude form hands over: L_u = L_v = L_w = 1000 ft, all sigma equal
  const DrydenScales s = DrydenLowAltitude(304.8, 10);
  EXPECT_LT((Lengths(s) - Vector3d::Constant(304.8)).norm(), 1e-9);
  EXPECT_LT((Sigmas(s) - Vector3d::Constant(1.0)).norm(), 1e-12);
}

TEST(Dryden, ScalesAtAHundredFeetAreThoseComputedByHand) {
  // f = 0.177 + 0.0823 = 0.2593; 100 / f^1.2 = 505.30 ft = 154.02 m; 1 / f^0.4 = 1.71609
  const DrydenScales s = DrydenLowAltitude(30.48, 10);
  EXPECT_NEAR(s.length_w_m, 30.48, 1e-9);
  EXPECT_NEAR(s.length_u_m, 154.02, 0.05);
  EXPECT_EQ(s.length_v_m, s.length_u_m);
  EXPECT_NEAR(s.sigma_w, 1.0, 1e-12);
  EXPECT_NEAR(s.sigma_u, 1.7161, 1e-3);
  EXPECT_EQ(s.sigma_v, s.sigma_u);
}

TEST(Dryden, ScalesStayAsTheyAreBelowTenFeet) {
  for (const double height_m : {-1.0, 0.0, 1.0, 3.0}) {
    EXPECT_EQ(Lengths(DrydenLowAltitude(height_m, 5)), Lengths(DrydenLowAltitude(3.048, 5))) << height_m;
    EXPECT_EQ(Sigmas(DrydenLowAltitude(height_m, 5)), Sigmas(DrydenLowAltitude(3.048, 5))) << height_m;
  }
  EXPECT_GT(DrydenLowAltitude(4, 5).length_w_m, DrydenLowAltitude(3, 5).length_w_m);
}

TEST(Turbulence, StartsStationaryAndStaysSoWhateverTimeStepSpeedAndHeightDo) {
  const WindParameters parameters{.mean_m_s = 6, .from_deg = 300, .turbulence = true};
  constexpr int kRuns = 4000;
  Vector3d first = Vector3d::Zero(), last = Vector3d::Zero(), mean = Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (int run = 0; run < kRuns; ++run) {
    Wind wind(parameters, run);
    const auto scaled = [&](double height_m) -> Vector3d {
      return InWindAxes(wind.Velocity(), 300).cwiseQuotient(Sigmas(DrydenLowAltitude(height_m, 6))) -
             Vector3d(6 / DrydenLowAltitude(height_m, 6).sigma_u, 0, 0);
    };
    wind.Step(1e-9, 20, kHovering);
    first += scaled(20).cwiseAbs2();
    for (int i = 0; i < 12; ++i) wind.Step(i % 3 == 0 ? 1.0 : 0.01 * (i + 1), 3 + 4 * i, {3.0 * i, 0, 0});
    const Vector3d x = scaled(3 + 4 * 11);
    last += x.cwiseAbs2();
    mean += x;
    covariance += x * x.transpose();
  }
  // the variance of so many has a deviation of sqrt(2 / n) = 2.2 percent, a mean or a covariance of 1.6
  EXPECT_LT((first / kRuns - Vector3d::Ones()).cwiseAbs().maxCoeff(), 0.09);
  EXPECT_LT((last / kRuns - Vector3d::Ones()).cwiseAbs().maxCoeff(), 0.09);
  EXPECT_LT((mean / kRuns).cwiseAbs().maxCoeff(), 0.07);
  covariance /= kRuns;
  for (const double c : {covariance(0, 1), covariance(0, 2), covariance(1, 2)}) EXPECT_LT(std::abs(c), 0.07);
}

TEST(Turbulence, StepSizeDoesNotChangeTheVariance) {
  const WindParameters parameters{.mean_m_s = 10, .turbulence = true};
  const double height_m = 4;
  const DrydenScales scales = DrydenLowAltitude(height_m, 10);
  for (const double dt_s : {0.02, 0.3, 3.0, 100.0}) {
    Wind wind(parameters, 5);
    constexpr int kSteps = 60000;
    Vector3d sum = Vector3d::Zero();
    for (int i = 0; i < kSteps; ++i) {
      wind.Step(dt_s, height_m, kHovering);
      sum += (wind.Velocity() + Vector3d(10, 0, 0)).cwiseAbs2();
    }
    const Vector3d variance = (sum / kSteps).cwiseQuotient(Sigmas(scales).cwiseAbs2());
    for (int axis = 0; axis < 3; ++axis) {
      const double independent = kSteps * std::min(1.0, dt_s * 10 / Lengths(scales)[axis]);
      EXPECT_NEAR(variance[axis], 1, 4.5 * std::sqrt(2 / independent)) << "axis " << axis << " dt " << dt_s;
    }
  }
}

// Autocorrelation from the definition: the cosine transform of the one-sided spectrum over its integral, with
// x = L w / V and s = V tau / L.
double DrydenCorrelation(bool longitudinal, double s) {
  double sum = 0, total = 0;
  const double dx = 0.005;
  for (double x = dx / 2; x < 400; x += dx) {
    const double d = 1 + x * x;
    const double spectrum = longitudinal ? 2 / d : (1 + 3 * x * x) / (d * d);
    sum += spectrum * std::cos(s * x) * dx;
    total += spectrum * dx;
  }
  return sum / (total + (longitudinal ? 2 : 3) / 400.0);  // with the tail, ~ 2 / x^2 and 3 / x^2
}

TEST(Turbulence, CorrelatesInTimeAsTheSpectraSay) {
  const double height_m = 20, mean = 8, dt_s = 1.2;
  const DrydenScales scales = DrydenLowAltitude(height_m, mean);
  struct Case {
    Vector3d v_N;
    double V;
  };
  // carried past by the wind; flying across it so that the speed through the air is 20 m/s; flying with it
  for (const auto& [v_N, V] :
       {Case{kHovering, 8}, Case{{0, std::sqrt(400.0 - 64), 0}, 20}, Case{{-8, 0, 0}, 8}}) {
    Wind wind({.mean_m_s = mean, .turbulence = true}, 11);
    std::vector<Vector3d> x(120000);
    for (Vector3d& sample : x) {
      wind.Step(dt_s, height_m, v_N);
      sample = (InWindAxes(wind.Velocity(), 0) - Vector3d(mean, 0, 0)).cwiseQuotient(Sigmas(scales));
    }
    for (const std::size_t lag : {1, 2, 4, 6}) {
      Vector3d correlation = Vector3d::Zero();
      for (std::size_t i = lag; i < x.size(); ++i) correlation += x[i].cwiseProduct(x[i - lag]);
      correlation /= static_cast<double>(x.size() - lag);
      for (int axis = 0; axis < 3; ++axis) {
        const double s = V * lag * dt_s / Lengths(scales)[axis];
        EXPECT_NEAR(correlation[axis], DrydenCorrelation(axis == 0, s), 0.035)
            << "axis " << axis << " lag " << lag;
      }
    }
  }
}

TEST(Wind, SameSeedGivesTheSameBitsAnotherSeedOthers) {
  const WindParameters parameters{
      .mean_m_s = 6, .from_deg = 40, .turbulence = true, .gusts = {.rate_per_min = 30, .amplitude_m_s = 3}};
  Wind a(parameters, 9), b(parameters, 9), c(parameters, 10);
  for (int i = 0; i < 500; ++i) {
    for (Wind* wind : {&a, &b, &c}) wind->Step(0.02, 5 + 0.01 * i, {0.1 * i, 0, 0});
    ASSERT_EQ(a.Velocity(), b.Velocity());
    ASSERT_NE(a.Velocity(), c.Velocity());
  }
}

TEST(Wind, GustsLeaveTheTurbulenceAsItIs) {
  WindParameters parameters{.mean_m_s = 6, .turbulence = true, .gusts = {.amplitude_m_s = 0}};
  Wind without(parameters, 9);
  parameters.gusts.rate_per_min = 60;
  Wind with(parameters, 9);
  for (int i = 0; i < 500; ++i) {
    without.Step(0.02, 5, kHovering);
    with.Step(0.02, 5, kHovering);
    ASSERT_EQ(without.Velocity(), with.Velocity());
  }
}

TEST(Gust, RisesAndFallsAsOneMinusCosine) {
  const double length_s = 2, dt_s = 1e-3;
  Wind wind({.mean_m_s = 4,
             .from_deg = 180,
             .gusts = {.rate_per_min = 0.5, .amplitude_m_s = 3, .length_s = length_s}},
            4);
  std::vector<Vector3d> gust;  // the samples of the first
  for (int i = 0; i < 2000000 && (gust.empty() || !gust.back().isZero()); ++i) {
    wind.Step(dt_s, 10, kHovering);
    const Vector3d v = wind.Velocity() - Vector3d(4, 0, 0);
    if (!gust.empty() || v.norm() > 1e-9) gust.push_back(v);
  }
  ASSERT_NEAR(gust.size() * dt_s, length_s,
              0.04);  // the faintest samples at its start fall below the threshold

  const auto largest = std::ranges::max_element(gust, {}, [](const Vector3d& v) { return v.norm(); });
  const Vector3d amplitude = *largest;
  EXPECT_GE(amplitude.norm(), 1.5);
  EXPECT_LE(amplitude.norm(), 3.0);
  EXPECT_LE(std::abs(std::atan2(amplitude.y(), amplitude.x())), std::numbers::pi / 4);
  for (std::size_t i = 0; i < gust.size(); ++i) {
    const double since_peak = (static_cast<double>(i) - (largest - gust.begin())) * dt_s;
    const double shape = 0.5 * (1 + std::cos(2 * std::numbers::pi * since_peak / length_s));
    // the peak itself is known to a time step
    ASSERT_LT((gust[i] - shape * amplitude).norm(), amplitude.norm() * std::numbers::pi / length_s * dt_s)
        << i;
  }
}

TEST(Gust, ArrivalsAreAPoissonProcessAndAmplitudesUniform) {
  const double dt_s = 0.02;
  Wind wind({.from_deg = 0, .gusts = {.rate_per_min = 6, .amplitude_m_s = 2, .length_s = 0.2}}, 4);
  std::vector<double> starts, peaks;
  bool blowing = false;
  for (int i = 0; i < 1000000; ++i) {
    wind.Step(dt_s, 10, kHovering);
    const double strength = wind.Velocity().norm();
    if (strength > 0 && !blowing) starts.push_back(i * dt_s), peaks.push_back(0);
    blowing = strength > 0;
    if (blowing) peaks.back() = std::max(peaks.back(), strength);
  }
  ASSERT_GT(starts.size(), 1700u);  // 2000 in the mean, of which one in fifty runs into the one before
  double mean = 0, square = 0;
  for (std::size_t i = 1; i < starts.size(); ++i) {
    const double gap = starts[i] - starts[i - 1];
    mean += gap, square += gap * gap;
  }
  mean /= starts.size() - 1, square /= starts.size() - 1;
  EXPECT_NEAR(mean, 10.2, 0.9);
  EXPECT_NEAR(std::sqrt(square - mean * mean) / mean, 1, 0.1);  // of an exponential distribution
  std::ranges::sort(peaks);
  EXPECT_NEAR(peaks[peaks.size() / 4], 1.25, 0.06);
  EXPECT_NEAR(peaks[peaks.size() * 3 / 4], 1.75, 0.06);
}

TEST(Gust, ComesAtTheSameTimeAtEveryStepSize) {
  const WindParameters parameters{.gusts = {.rate_per_min = 30, .amplitude_m_s = 2}};
  Wind fine(parameters, 4), coarse(parameters, 4);
  for (int i = 0; i < 200; ++i) {
    for (int k = 0; k < 4; ++k) fine.Step(0.125, 10, kHovering);
    coarse.Step(0.5, 10, kHovering);
    ASSERT_EQ(fine.Velocity(), coarse.Velocity());  // binary fractions: the times agree exactly
  }
}

}  // namespace
}  // namespace kestrel::sim
