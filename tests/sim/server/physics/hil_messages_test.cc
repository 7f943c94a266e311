// SPDX-License-Identifier: Apache-2.0
#include "sim/server/physics/hil_messages.h"

#include <gtest/gtest.h>

#include <cmath>

#include "geometry/tait_bryan.h"

namespace kestrel::sim {
namespace {

using Eigen::Vector3d;

// Earth-centred, of WGS 84.
Vector3d Cartesian(const GeodeticPosition& g) {
  const double a = 6378137, f = 1 / 298.257223563, e2 = f * (2 - f);
  const double lat = Radians(g.latitude_deg), lon = Radians(g.longitude_deg);
  const double n = a / std::sqrt(1 - e2 * std::sin(lat) * std::sin(lat));
  return {(n + g.altitude_m) * std::cos(lat) * std::cos(lon),
          (n + g.altitude_m) * std::cos(lat) * std::sin(lon), (n * (1 - e2) + g.altitude_m) * std::sin(lat)};
}

TEST(HilMessages, PlacesAreWhereTheEllipsoidHasThem) {
  for (const GeodeticOrigin& origin : {GeodeticOrigin{}, GeodeticOrigin{-33.9, 151.2, 20}}) {
    const double lat = Radians(origin.latitude_deg), lon = Radians(origin.longitude_deg);
    Eigen::Matrix3d R_NE;
    R_NE << -std::sin(lat) * std::cos(lon), -std::sin(lat) * std::sin(lon), std::cos(lat),  //
        -std::sin(lon), std::cos(lon), 0,                                                   //
        -std::cos(lat) * std::cos(lon), -std::cos(lat) * std::sin(lon), -std::sin(lat);
    for (const auto& [scale, tolerance] : {std::pair{1.0, 2e-3}, std::pair{10.0, 0.2}}) {
      const Vector3d p_N = scale * Vector3d(70, -71, -12);
      const Vector3d found =
          R_NE * (Cartesian(GeodeticOf(origin, p_N)) - Cartesian(GeodeticOf(origin, Vector3d::Zero())));
      EXPECT_LT((found - p_N).head<2>().norm(), tolerance);
      EXPECT_NEAR(GeodeticOf(origin, p_N).altitude_m, origin.altitude_m - p_N.z(), 1e-9);
    }
  }
}

TEST(HilMessages, TheAtmosphereIsTheStandardOne) {
  // ISO 2533, table 5
  EXPECT_NEAR(StandardPressure_hpa(0), 1013.25, 1e-9);
  EXPECT_NEAR(StandardPressure_hpa(1000), 898.746, 0.01);
  EXPECT_NEAR(StandardPressure_hpa(5000), 540.199, 0.02);
  EXPECT_NEAR(StandardTemperature_c(0), 15, 1e-9);
  EXPECT_NEAR(StandardTemperature_c(5000), -17.5, 1e-9);
}

SensorReadings Readings(const Vector3d& w_B, const Vector3d& force_B) {
  SensorReadings r;
  r.imu = {w_B, force_B};
  return r;
}

TEST(HilMessages, SensorsComeInTheUnitsOfTheWire) {
  GatheredReadings gathered;
  SensorReadings first = Readings({0.1, 0.2, 0.3}, {1, 2, -9});
  first.field_B = Vector3d(20e-6, 5e-6, 40e-6);
  gathered.Add(first);
  gathered.Add(Readings({0.3, 0.4, 0.5}, {3, 4, -11}));
  SlowSensors slow;
  GeodeticOrigin origin;
  origin.altitude_m = 900;
  auto m = ToHilSensor(123456, gathered, slow, origin);
  EXPECT_EQ(m.time_usec, 123456U);
  EXPECT_EQ(m.fields_updated, 0x1FFU);  // accelerometers, gyros, magnetometer
  EXPECT_FLOAT_EQ(m.xgyro, 0.2F);
  EXPECT_FLOAT_EQ(m.ygyro, 0.3F);
  EXPECT_FLOAT_EQ(m.zgyro, 0.4F);
  EXPECT_FLOAT_EQ(m.xacc, 2);
  EXPECT_FLOAT_EQ(m.yacc, 3);
  EXPECT_FLOAT_EQ(m.zacc, -10);
  EXPECT_FLOAT_EQ(m.xmag, 0.2F);
  EXPECT_FLOAT_EQ(m.ymag, 0.05F);
  EXPECT_FLOAT_EQ(m.zmag, 0.4F);
  EXPECT_EQ(m.id, 0);

  gathered = {};
  SensorReadings second = Readings(Vector3d::Zero(), {0, 0, -9.8});
  second.height_m = 100;
  gathered.Add(second);
  m = ToHilSensor(127456, gathered, slow, origin);
  EXPECT_EQ(m.fields_updated, 0x3FU | 0x1A00U);  // barometer: pressure, altitude, temperature
  EXPECT_NEAR(m.abs_pressure, 898.746, 0.01);    // at 1000 m
  EXPECT_FLOAT_EQ(m.pressure_alt, 1000);
  EXPECT_FLOAT_EQ(m.temperature, 8.5F);
  EXPECT_FLOAT_EQ(m.xmag, 0.2F);  // as it was, and not said to be new
}

TEST(HilMessages, FixesAndTruthAreInTheUnitsOfTheWire) {
  GeodeticOrigin origin;
  origin.latitude_deg = 0, origin.longitude_deg = 10, origin.altitude_m = 0;
  const auto gps =
      ToHilGps(5, {{0, 111.3195, -2}, {0.3, -0.4, 1.25}}, origin);  // 0.001 degrees of the equator
  EXPECT_EQ(gps.lat, 0);
  EXPECT_NEAR(gps.lon, 100010000, 2);
  EXPECT_EQ(gps.alt, 2000);
  EXPECT_EQ(gps.vel, 50);
  EXPECT_EQ(gps.vn, 30);
  EXPECT_EQ(gps.ve, -40);
  EXPECT_EQ(gps.vd, 125);
  EXPECT_EQ(gps.cog, 30687);  // 306.87 degrees
  EXPECT_EQ(gps.fix_type, 3);
  EXPECT_EQ(ToHilGps(0, {{0, 0, 0}, {1, -1e-9, 0}}, origin).cog, 0);  // not 360 degrees
  EXPECT_EQ(ToHilGps(0, {{0, 0, 0}, {900, 0, 0}}, origin).vn, 32767);

  Truth truth;
  truth.X_NB.p = {0, 0, -7};
  truth.X_NB.R = HeadingRotation(Radians(30));
  truth.v_N = {1, 2, -3};
  truth.wind_N = {1, 0, -3};
  truth.w_B = {0.1, 0, 0};
  const auto state = ToHilState(9, truth, {0, 9.80665, -9.80665}, origin);
  EXPECT_EQ(state.alt, 7000);
  EXPECT_EQ(state.vx, 100);
  EXPECT_EQ(state.vy, 200);
  EXPECT_EQ(state.vz, -300);
  EXPECT_EQ(state.true_airspeed, 200);
  EXPECT_EQ(state.xacc, 0);
  EXPECT_EQ(state.yacc, 1000);
  EXPECT_EQ(state.zacc, -1000);
  EXPECT_NEAR(state.rollspeed, 0.1, 1e-6);
  EXPECT_NEAR(state.attitude_quaternion[0], std::cos(Radians(15)), 1e-6);  // heading 30 degrees
  EXPECT_NEAR(state.attitude_quaternion[3], std::sin(Radians(15)), 1e-6);
}

}  // namespace
}  // namespace kestrel::sim
