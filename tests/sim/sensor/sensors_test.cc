// SPDX-License-Identifier: Apache-2.0
#include "sim/sensor/sensors.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "geometry/tait_bryan.h"
#include "tests/sim/perfect_sensors.h"

namespace kestrel::sim {
namespace {

using Eigen::Vector3d;

constexpr double kGravity = 9.80665;
const Vector3d kZero = Vector3d::Zero();
const Vector3d kAtRest(0, 0, -kGravity);

SensorReadings ReadAtRest(Sensors& sensors, double dt_s) {
  return sensors.Read(dt_s, {}, kZero, kZero, kAtRest);
}

double Deviation(const std::vector<double>& x) {  // about zero, which is the mean of every error
  double sum = 0;
  for (const double v : x) sum += v * v;
  return std::sqrt(sum / static_cast<double>(x.size()));
}

double Correlation(const std::vector<double>& x, std::size_t lag) {
  double sum = 0;
  for (std::size_t i = lag; i < x.size(); ++i) sum += x[i] * x[i - lag];
  const double deviation = Deviation(x);
  return sum / static_cast<double>(x.size() - lag) / (deviation * deviation);
}

// A first-order Gauss-Markov process: its deviation, and a correlation of exp(-lag / T). samples one period
// apart.
void ExpectWander(const std::vector<double>& x, double deviation, double time_s, double period_s) {
  ASSERT_GT(static_cast<double>(x.size()) * period_s,
            2000 * time_s);  // 2000 T: three deviations of the estimate are 7 %
  EXPECT_NEAR(Deviation(x) / deviation, 1, 0.07);
  for (const double lags : {0.5, 1.0, 2.0}) {
    const auto lag = static_cast<std::size_t>(std::lround(lags * time_s / period_s));
    EXPECT_NEAR(Correlation(x, lag), std::exp(-lags), 0.09) << lags;
  }
}

TEST(Sensors, AtRestAndLevelTheImuReadsMinusGOnZAndNoRate) {
  Sensors sensors(PerfectSensors(), 1);
  for (int i = 0; i < 10; ++i) {
    const SensorReadings r = ReadAtRest(sensors, 0.002);
    EXPECT_EQ(r.imu.w_B, kZero);
    EXPECT_EQ(r.imu.specific_force_B, Vector3d(0, 0, -kGravity));
  }
}

TEST(Sensors, WithoutErrorsTheySayTheTruth) {
  Sensors sensors(PerfectSensors(), 1);
  const Pose X_NB{HeadingRotation(0.7), {12, -3, -7}};
  const Vector3d v_N(1, -2, 0.5), w_B(0.1, -0.2, 0.3), f_B(0.4, -0.5, -9.9);
  int fixes = 0, heights = 0;
  for (int i = 0; i < 500; ++i) {
    const SensorReadings r = sensors.Read(0.002, X_NB, v_N, w_B, f_B);
    EXPECT_EQ(r.imu.w_B, w_B);
    EXPECT_EQ(r.imu.specific_force_B, f_B);
    if (r.gps) {
      ++fixes;
      EXPECT_EQ(r.gps->p_N, X_NB.p);
      EXPECT_EQ(r.gps->v_N, v_N);
    }
    if (r.height_m) {
      ++heights;
      EXPECT_EQ(*r.height_m, 7);
    }
  }
  EXPECT_EQ(fixes, 5);
  EXPECT_EQ(heights, 25);
}

TEST(Sensors, EachSpeaksAtItsRateWhateverTheStep) {
  for (const double dt : {0.002, 0.001, 0.003, 0.0125}) {
    SensorParameters p;
    p.gps_rate_hz = 4, p.barometer_rate_hz = 30, p.magnetometer_rate_hz = 50;
    Sensors sensors(p, 3);
    int gps = 0, barometer = 0, magnetometer = 0;
    double last_gps_s = 0;
    const int steps = static_cast<int>(std::lround(60 / dt));
    for (int i = 1; i <= steps; ++i) {
      const SensorReadings r = ReadAtRest(sensors, dt);
      if (r.gps) {
        EXPECT_NEAR(i * dt - last_gps_s, 0.25, dt + 1e-9);
        last_gps_s = i * dt;
      }
      gps += r.gps.has_value(), barometer += r.height_m.has_value(), magnetometer += r.field_B.has_value();
    }
    EXPECT_EQ(gps, 240) << dt;
    EXPECT_EQ(barometer, 1800) << dt;
    EXPECT_EQ(magnetometer, 3000) << dt;
  }
}

TEST(Sensors, WhiteImuNoiseOfADensityGrowsWithTheRootOfTheRate) {
  SensorParameters p = PerfectSensors();
  p.gyro_noise_rad_s_rthz = 3e-4;
  p.accelerometer_noise_m_s2_rthz = 4e-3;
  for (const double dt : {0.002, 0.008}) {
    Sensors sensors(p, 5);
    std::vector<double> gyro[3], accelerometer[3];
    for (int i = 0; i < 40000; ++i) {
      const SensorReadings r = ReadAtRest(sensors, dt);
      for (int k = 0; k < 3; ++k) {
        gyro[k].push_back(r.imu.w_B(k));
        accelerometer[k].push_back(r.imu.specific_force_B(k) - kAtRest(k));
      }
    }
    for (int k = 0; k < 3; ++k) {
      EXPECT_NEAR(Deviation(gyro[k]) * std::sqrt(dt) / 3e-4, 1, 0.02);  // five deviations of the estimate
      EXPECT_NEAR(Deviation(accelerometer[k]) * std::sqrt(dt) / 4e-3, 1, 0.02);
      EXPECT_NEAR(Correlation(gyro[k], 1), 0, 0.025);
      EXPECT_NEAR(Correlation(accelerometer[k], 1), 0, 0.025);
    }
  }
}

TEST(Sensors, ImuBiasesWalkWithTheirDensityAndArePulledBackInTheirTime) {
  SensorParameters p = PerfectSensors();
  p.gyro_walk_rad_s2_rthz = 2e-4, p.gyro_walk_time_s = 0.5;
  p.accelerometer_walk_m_s3_rthz = 3e-2, p.accelerometer_walk_time_s = 1;
  constexpr double kDt = 0.01;
  Sensors sensors(p, 6);
  std::vector<double> gyro, accelerometer, gyro_steps;
  for (int i = 0; i < 300000; ++i) {
    const SensorReadings r = ReadAtRest(sensors, kDt);
    if (!gyro.empty()) gyro_steps.push_back(r.imu.w_B.y() - gyro.back());
    gyro.push_back(r.imu.w_B.y());
    accelerometer.push_back(r.imu.specific_force_B.z() + kGravity);
  }
  ExpectWander(gyro, 2e-4 * std::sqrt(0.5 / 2), 0.5, kDt);
  ExpectWander(accelerometer, 3e-2 * std::sqrt(1.0 / 2), 1, kDt);
  // over a time that is short against T it is a random walk: density times the root of that time
  EXPECT_NEAR(Deviation(gyro_steps) / (2e-4 * std::sqrt(kDt)), 1, 0.02);
}

TEST(Sensors, TurnOnBiasesStayInARunAndScatterOverSeeds) {
  SensorParameters p = PerfectSensors();
  p.gyro_turn_on_rad_s = 0.0087, p.accelerometer_turn_on_m_s2 = 0.196, p.magnetometer_turn_on_t = 400e-9;
  std::vector<double> gyro, accelerometer, magnetometer;
  for (std::uint64_t seed = 0; seed < 1500; ++seed) {
    Sensors sensors(p, seed);
    const SensorReadings first = ReadAtRest(sensors, 0.04), second = ReadAtRest(sensors, 0.04);
    EXPECT_EQ(first.imu.w_B, second.imu.w_B);
    EXPECT_EQ(first.imu.specific_force_B, second.imu.specific_force_B);
    EXPECT_EQ(*first.field_B, *second.field_B);
    for (int k = 0; k < 3; ++k) {
      gyro.push_back(first.imu.w_B(k));
      accelerometer.push_back(first.imu.specific_force_B(k) - kAtRest(k));
      magnetometer.push_back((*first.field_B - EarthField_N())(k));
    }
  }
  EXPECT_NEAR(Deviation(gyro) / 0.0087, 1, 0.05);  // 4500 numbers: 5 deviations of the estimate
  EXPECT_NEAR(Deviation(accelerometer) / 0.196, 1, 0.05);
  EXPECT_NEAR(Deviation(magnetometer) / 400e-9, 1, 0.05);
}

TEST(Sensors, GpsAndBarometerWanderSlowlyFromZero) {
  SensorParameters p = PerfectSensors();
  p.gps_rate_hz = 5, p.barometer_rate_hz = 5;
  p.gps_horizontal_m = {0, 2.1, 4};
  p.gps_vertical_m = {0, 3.5, 6};
  p.gps_velocity_m_s = {0, 0.3, 2};
  p.barometer_m = {0, 0.5, 5};
  Sensors sensors(p, 8);
  constexpr double kPeriod = 0.2;
  std::vector<double> north, east, down, speed, height;
  for (int i = 0; i < 80000; ++i) {
    const SensorReadings r = ReadAtRest(sensors, kPeriod);
    ASSERT_TRUE(r.gps && r.height_m);
    north.push_back(r.gps->p_N.x());
    east.push_back(r.gps->p_N.y());
    down.push_back(r.gps->p_N.z());
    speed.push_back(r.gps->v_N.y());
    height.push_back(*r.height_m);
  }
  // the first sample is one period away from zero
  EXPECT_LT(std::abs(north[0]), 4 * 2.1 * std::sqrt(2 * kPeriod / 4));
  EXPECT_LT(std::abs(height[0]), 4 * 0.5 * std::sqrt(2 * kPeriod / 5));
  ExpectWander(north, 2.1, 4, kPeriod);
  ExpectWander(east, 2.1, 4, kPeriod);
  ExpectWander(down, 3.5, 6, kPeriod);
  ExpectWander(speed, 0.3, 2, kPeriod);
  ExpectWander(height, 0.5, 5, kPeriod);
  double product = 0;
  for (std::size_t i = 0; i < north.size(); ++i) product += north[i] * east[i];
  EXPECT_LT(std::abs(product / static_cast<double>(north.size())),
            0.1 * 2.1 * 2.1);  // north and east on their own
}

TEST(Sensors, WhiteErrorsOfTheSlowSensorsHaveTheirDeviation) {
  SensorParameters p = PerfectSensors();
  p.gps_horizontal_m.white = 0.05, p.gps_vertical_m.white = 0.1, p.gps_velocity_m_s.white = 0.2;
  p.barometer_m.white = 0.3, p.magnetometer_white_t = 80e-9;
  Sensors sensors(p, 9);
  std::vector<double> east, down, speed, height, field;
  for (int i = 0; i < 20000; ++i) {
    const SensorReadings r = ReadAtRest(sensors, 0.2);
    east.push_back(r.gps->p_N.y());
    down.push_back(r.gps->p_N.z());
    speed.push_back(r.gps->v_N.z());
    height.push_back(*r.height_m);
    field.push_back(r.field_B->x() - EarthField_N().x());
  }
  const auto expect = [](const std::vector<double>& x, double deviation) {
    EXPECT_NEAR(Deviation(x) / deviation, 1, 0.025);
    EXPECT_NEAR(Correlation(x, 1), 0, 0.035);
  };
  expect(east, 0.05);
  expect(down, 0.1);
  expect(speed, 0.2);
  expect(height, 0.3);
  expect(field, 80e-9);
}

TEST(Sensors, TheFieldOfTheEarthDipsNorthwards) {
  EXPECT_NEAR(EarthField_N().norm(), 44.5e-6, 1e-12);
  EXPECT_EQ(EarthField_N().y(), 0);
  EXPECT_NEAR(std::atan2(EarthField_N().z(), EarthField_N().x()), 55 * std::numbers::pi / 180, 1e-12);
}

TEST(Sensors, TheMagnetometerTurnsAgainstTheAircraft) {
  const double level = EarthField_N().x(), down = EarthField_N().z();
  const auto field = [](const TaitBryan& angles) {
    Sensors sensors(PerfectSensors(), 1);
    const Pose X_NB{Eigen::Quaterniond(RotationFromTaitBryan(angles)), {5, 6, 7}};
    return *sensors.Read(0.04, X_NB, kZero, kZero, kAtRest).field_B;
  };
  const double a = 0.5, c = std::cos(a), s = std::sin(a);
  // heading north-east, north is ahead to the left
  EXPECT_LT((field({a, 0, 0}) - Vector3d(level * c, -level * s, down)).norm(), 1e-15);
  // nose up, what points down lies behind
  EXPECT_LT((field({0, a, 0}) - Vector3d(level * c - down * s, 0, level * s + down * c)).norm(), 1e-15);
  // right wing down, what points down lies to the right
  EXPECT_LT((field({0, 0, a}) - Vector3d(level, down * s, down * c)).norm(), 1e-15);
}

bool Same(const SensorReadings& a, const SensorReadings& b) {
  return a.imu.w_B == b.imu.w_B && a.imu.specific_force_B == b.imu.specific_force_B &&
         a.gps.has_value() == b.gps.has_value() &&
         (!a.gps || (a.gps->p_N == b.gps->p_N && a.gps->v_N == b.gps->v_N)) && a.height_m == b.height_m &&
         a.field_B == b.field_B;
}

TEST(Sensors, TheSameSeedGivesTheSameBitsAndAnotherOthers) {
  Sensors a({}, 11), b({}, 11), c({}, 12);
  int different = 0;
  for (int i = 0; i < 1000; ++i) {
    const SensorReadings r = ReadAtRest(a, 0.002);
    ASSERT_TRUE(Same(r, ReadAtRest(b, 0.002)));
    different += !Same(r, ReadAtRest(c, 0.002));
  }
  EXPECT_EQ(different, 1000);
}

TEST(Sensors, WhatOneSensorIsLikeDoesNotShiftTheNumbersOfAnother) {
  SensorParameters changed;
  changed.gps_rate_hz = 10;
  changed.gps_vertical_m = {1, 2, 3};
  changed.gyro_noise_rad_s_rthz = 0;
  changed.gyro_turn_on_rad_s = 0.1;
  changed.magnetometer_rate_hz = 50;
  Sensors usual({}, 13), other(changed, 13);
  int heights = 0, seen_gps = 0, seen_gyro = 0;
  for (int i = 0; i < 1000; ++i) {
    const SensorReadings a = ReadAtRest(usual, 0.002), b = ReadAtRest(other, 0.002);
    EXPECT_EQ(a.imu.specific_force_B, b.imu.specific_force_B);
    EXPECT_EQ(a.height_m, b.height_m);
    heights += a.height_m.has_value();
    seen_gyro += a.imu.w_B != b.imu.w_B;
    seen_gps += b.gps.has_value() && (!a.gps || a.gps->p_N != b.gps->p_N);
  }
  EXPECT_EQ(heights, 50);
  EXPECT_EQ(seen_gyro, 1000);
  EXPECT_EQ(seen_gps, 20);
}

}  // namespace
}  // namespace kestrel::sim
