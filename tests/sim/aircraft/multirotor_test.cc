// SPDX-License-Identifier: Apache-2.0
#include "sim/aircraft/multirotor.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <limits>
#include <memory>
#include <random>
#include <stdexcept>
#include <string>
#include <utility>

#include "base/yaml/fields.h"
#include "geometry/tait_bryan.h"
#include "sim/world/frames.h"
#include "sim/world/wind.h"
#include "tests/sim/downward_view.h"

namespace kestrel::sim {
namespace {

using Eigen::Quaterniond;
using Eigen::Vector3d;

constexpr double kFar = std::numeric_limits<double>::infinity();
constexpr RotorSpeeds kHigh = {kFar, kFar, kFar, kFar};
constexpr double kNoGround = -1e6;  // the height of a surface far below
const Vector3d kZero = Vector3d::Zero();

// The body's own inertia and the model's statistics differ from what a measurement of the model would give.
constexpr char kWorld[] =
    R"(<mujoco><option timestep="0.001"/><statistic extent="77" center="1 2 3"/><worldbody>
    <body name="fixed"><geom size="0.1"/></body>
    <body name="vehicle" pos="0 0 100"><freejoint/>
    <inertial pos="0.1 0.2 0.3" mass="7" fullinertia="3 4 5 0.1 0.2 0.3"/></body></worldbody></mujoco>)";

std::string PelicanWorld() {
  const std::filesystem::path root = KESTREL_SOURCE_DIR;
  return R"(<mujoco><option timestep="0.002"/><worldbody><geom type="plane" size="10 10 1"/><include file=")" +
         (root / "models/vehicles/pelican/pelican.xml").string() + R"("/></worldbody></mujoco>)";
}

class MultirotorTest : public ::testing::Test {
 protected:
  void SetUp() override {
    mju_user_warning = [](const char* message) { ADD_FAILURE() << message; };
    Load(kWorld);
  }
  void TearDown() override { mju_user_warning = nullptr; }

  void Load(const std::string& xml) {
    mjVFS vfs;
    mj_defaultVFS(&vfs);
    mj_makeEmptyFileVFS(&vfs, "world.xml", static_cast<int>(xml.size()) + 1);
    std::memcpy(vfs.filedata[0], xml.c_str(), xml.size() + 1);
    std::array<char, 500> error{};
    model_.reset(mj_loadXML("world.xml", &vfs, error.data(), error.size()));
    mj_deleteVFS(&vfs);
    ASSERT_TRUE(model_) << error.data();
    data_.reset(mj_makeData(model_.get()));
  }
  // Speeds reached, not only asked for.
  void Settle(Multirotor& vehicle, const RotorSpeeds& speeds) {
    vehicle.Command(speeds);
    vehicle.Apply(data_.get(), 100, kZero, kNoGround);
  }
  void Step(Multirotor& vehicle, const Vector3d& wind_N, double surface_m = kNoGround) {
    vehicle.Apply(data_.get(), model_->opt.timestep, wind_N, surface_m);
    mj_step(model_.get(), data_.get());
  }
  // Acceleration of the free joint: linear in N, angular in B.
  Eigen::Matrix<double, 6, 1> Acceleration() {
    mj_forward(model_.get(), data_.get());
    Eigen::Matrix<double, 6, 1> a;
    a << VectorFromMujoco(data_->qacc), VectorFromMujoco(data_->qacc + 3);
    return a;
  }

  std::unique_ptr<mjModel, decltype(&mj_deleteModel)> model_{nullptr, mj_deleteModel};
  std::unique_ptr<mjData, decltype(&mj_deleteData)> data_{nullptr, mj_deleteData};
};

// Visits the fields of parameters and requires each to lie in its range.
struct RangeCheck final : FieldVisitor {
  int count = 0;
  void Visit(const FieldKey& key, const FieldValue& field) override {
    const auto lies = [&](double value, double low, double high) {
      ++count;
      EXPECT_TRUE(value >= low && value <= high) << key.name;
    };
    if (const auto* number = std::get_if<NumberField>(&field))
      lies(*number->value, number->low, number->high);
    if (const auto* vector = std::get_if<NumbersField>(&field))
      for (int i = 0; i < vector->size; ++i) lies(vector->values[i], vector->low, vector->high);
    if (std::holds_alternative<FlagField>(field)) ++count;
    if (const auto* nested = std::get_if<StructField>(&field)) nested->Visit(*this);
  }
};

TEST(Parameters, DefaultsLieInTheirRanges) {
  RangeCheck check;
  MultirotorParameters vehicle;
  Fields(check, vehicle);
  EXPECT_EQ(check.count, 9 + 10);
  WindParameters wind;
  Fields(check, wind);
  EXPECT_EQ(check.count, 9 + 10 + 7);
}

RotorSpeeds Same(double speed) { return {speed, speed, speed, speed}; }

double MaxThrust(const MultirotorParameters& p) {
  return p.rotor.thrust_coefficient_n_s2 * p.rotor.max_speed_rad_s * p.rotor.max_speed_rad_s;
}

// What rotors at these speeds give in still air: thrust and torque.
std::pair<double, Vector3d> StillAir(const MultirotorParameters& p, const RotorSpeeds& speeds) {
  const Wrench w = AerodynamicWrench(p, speeds, kZero, kZero, kHigh);
  return {-w.force.z(), w.torque};
}

TEST(Allocation, EachRotorTurnsTheAircraftItsWay) {
  const MultirotorParameters p;
  const double T = p.rotor.thrust_coefficient_n_s2 * 400 * 400, l = p.arm_m, k = p.rotor.moment_coefficient_m;
  // the lift of each tips the aircraft away from its side; the reaction turns it against the spin
  EXPECT_LT((StillAir(p, {400, 0, 0, 0}).second - Vector3d(0, l * T, -k * T)).norm(), 1e-14);
  EXPECT_LT((StillAir(p, {0, 400, 0, 0}).second - Vector3d(-l * T, 0, k * T)).norm(), 1e-14);
  EXPECT_LT((StillAir(p, {0, 0, 400, 0}).second - Vector3d(0, -l * T, -k * T)).norm(), 1e-14);
  EXPECT_LT((StillAir(p, {0, 0, 0, 400}).second - Vector3d(l * T, 0, k * T)).norm(), 1e-14);
}

TEST(Allocation, RotorsGiveBackWhatWasAsked) {
  const MultirotorParameters p;
  std::mt19937 rng{7};
  std::uniform_real_distribution<double> unit(-1, 1);
  for (int i = 0; i < 200; ++i) {
    const double thrust = 12 + 3 * unit(rng);
    const Vector3d torque_B(0.5 * unit(rng), 0.5 * unit(rng), 0.05 * unit(rng));
    const auto [given, torque] = StillAir(p, Allocate(p, thrust, torque_B));
    EXPECT_NEAR(given, thrust, 1e-12);
    EXPECT_LT((torque - torque_B).norm(), 1e-13);
  }
}

TEST(Allocation, KeepsRollAndPitchThenThrustThenYaw) {
  const MultirotorParameters p;
  const double most = MaxThrust(p);
  int limited_thrust = 0, limited_yaw = 0, cases = 0;
  for (int i = 0; i < 15; ++i) {
    for (int j = -4; j <= 4; ++j) {
      for (int k = -4; k <= 4; ++k) {
        for (int n = -3; n <= 3; ++n, ++cases) {
          const double thrust = -5 + 3.1 * i, roll = 0.35 * j, pitch = 0.35 * k, yaw = 0.2 * n;
          const auto [given, torque] = StillAir(p, Allocate(p, thrust, {roll, pitch, yaw}));
          ASSERT_NEAR(torque.x(), roll, 1e-12);  // 1.4 N m are within reach: 7 N on an arm of 0.21 m
          ASSERT_NEAR(torque.y(), pitch, 1e-12);

          // the pair of an axis holds the mean of its two rotors between these
          const double swing = std::max(std::abs(roll), std::abs(pitch)) / (2 * p.arm_m);
          const double wanted = std::clamp(thrust, 4 * swing, 4 * (most - swing));
          ASSERT_NEAR(given, wanted, 1e-10);
          limited_thrust += wanted != thrust;

          // the greatest yaw toward the one asked for that leaves all four in their range, by search
          double reached = 0;
          for (double share = 1; share >= 0; share -= 1e-3) {
            const double y = share * yaw / (4 * p.rotor.moment_coefficient_m),
                         a = std::abs(pitch) / (2 * p.arm_m), b = std::abs(roll) / (2 * p.arm_m),
                         m = wanted / 4;
            if (m - y - a >= -1e-9 && m - y + a <= most + 1e-9 && m + y - b >= -1e-9 &&
                m + y + b <= most + 1e-9) {
              reached = share * yaw;
              break;
            }
          }
          limited_yaw += reached != yaw;
          ASSERT_NEAR(torque.z(), reached, 1.1e-3 * std::abs(yaw) + 1e-10);
        }
      }
    }
  }
  EXPECT_EQ(cases, 15 * 9 * 9 * 7);
  EXPECT_GT(limited_thrust, 1000);
  EXPECT_GT(limited_yaw, 1000);
}

TEST(Allocation, TorqueOutOfReachKeepsItsDirection) {
  const MultirotorParameters p;
  const auto [thrust, torque] = StillAir(p, Allocate(p, 12, {3, -6, 0.1}));
  EXPECT_NEAR(torque.y(), -p.arm_m * MaxThrust(p), 1e-12);
  EXPECT_NEAR(torque.x(), 0.5 * p.arm_m * MaxThrust(p), 1e-12);
  EXPECT_NEAR(thrust, 2 * MaxThrust(p), 1e-12);
}

TEST_F(MultirotorTest, ModelTakesOnMassAndInertia) {
  const double others = mj_getTotalmass(model_.get()) - 7;
  const MultirotorParameters p;
  const Multirotor vehicle(p, model_.get());
  EXPECT_NEAR(mj_getTotalmass(model_.get()), others + p.mass_kg, 1e-12);
  const int body = mj_name2id(model_.get(), mjOBJ_BODY, "vehicle");
  EXPECT_NEAR(model_->body_subtreemass[body], p.mass_kg, 1e-12);
  EXPECT_NEAR(model_->body_invweight0[2 * body], 1 / p.mass_kg, 1e-9);
  EXPECT_NEAR(model_->body_invweight0[2 * body + 1], (1 / 0.0125 + 1 / 0.0125 + 1 / 0.025) / 3, 1e-9);

  // inertia as felt: an acceleration per torque about each axis, the aircraft turned any way
  PoseToMujoco({Quaterniond(RotationFromTaitBryan({.yaw = 1, .pitch = 0.4, .roll = -0.3})), {0, 0, -100}},
               data_->qpos);
  const Quaterniond R_NB = PoseFromMujoco(data_->qpos).R;
  for (int axis = 0; axis < 3; ++axis) {
    VectorToMujoco(R_NB * Vector3d::Unit(axis), data_->xfrc_applied + 6 * body + 3);
    const auto a = Acceleration();
    EXPECT_LT((a.tail<3>() - Vector3d::Unit(axis) / p.inertia_kg_m2[axis]).norm(), 1e-9);
    EXPECT_LT((a.head<3>() - Vector3d(0, 0, 9.81)).norm(),
              1e-9);  // no coupling: the origin is the centre of mass
  }
}

TEST_F(MultirotorTest, ModelKeepsTheExtentThatCamerasAreClippedBy) {
  const Multirotor vehicle({}, model_.get());
  EXPECT_EQ(model_->stat.extent, 77);
  EXPECT_EQ(Vector3d(model_->stat.center), Vector3d(1, 2, 3));
}

TEST_F(MultirotorTest, RefusesAModelWithoutAFreeBodyOfThatName) {
  EXPECT_THROW(Multirotor({}, model_.get(), "aircraft"), std::invalid_argument);
  EXPECT_THROW(Multirotor({}, model_.get(), "fixed"), std::invalid_argument);
}

TEST_F(MultirotorTest, HoverSpeedCarriesTheWeight) {
  Multirotor vehicle({}, model_.get());
  Settle(vehicle, Same(vehicle.HoverSpeed()));
  EXPECT_LT(Acceleration().norm(), 1e-9);
  for (int i = 0; i < 1000; ++i) Step(vehicle, kZero);
  EXPECT_LT(VectorFromMujoco(data_->qvel).norm(), 1e-9);
  EXPECT_FALSE(vehicle.saturated());
}

TEST_F(MultirotorTest, FallsFreelyWithMotorsStopped) {
  MultirotorParameters p;
  p.drag_area_m2 = kZero;
  Multirotor vehicle(p, model_.get());
  for (int i = 0; i < 500; ++i) Step(vehicle, {3, 2, 1});
  EXPECT_LT((VectorFromMujoco(data_->qvel) - Vector3d(0, 0, 9.81 * 0.5)).norm(), 1e-9);
}

TEST_F(MultirotorTest, FallEndsAtTheSpeedWhereDragCarriesTheWeight) {
  MultirotorParameters p;
  p.drag_area_m2 = {0.01, 0.01, 0.2};
  Multirotor vehicle(p, model_.get());
  for (int i = 0; i < 15000; ++i) Step(vehicle, kZero);
  EXPECT_NEAR(VectorFromMujoco(data_->qvel).z(), std::sqrt(2 * p.mass_kg * 9.81 / (1.225 * 0.2)), 1e-6);
}

TEST_F(MultirotorTest, ForceOfWindOnAHeldAircraftHasItsClosedForm) {
  const MultirotorParameters p;
  Multirotor vehicle(p, model_.get());
  const double w = 500;
  for (const TaitBryan& attitude :
       {TaitBryan{}, TaitBryan{.yaw = 2}, TaitBryan{.yaw = -1, .pitch = 0.3, .roll = 0.2}}) {
    const Quaterniond R_NB(RotationFromTaitBryan(attitude));
    PoseToMujoco({R_NB, {0, 0, -100}}, data_->qpos);
    vehicle.Command(Same(w));
    const Vector3d wind_N(4, -3, 1);
    vehicle.Apply(data_.get(), 100, wind_N, kNoGround);

    const Vector3d flow_B = R_NB.conjugate() * wind_N;  // of the air past the aircraft
    Vector3d force_B = 0.5 * 1.225 * flow_B.norm() * p.drag_area_m2.cwiseProduct(flow_B);
    force_B += 4 * w * p.rotor.drag_coefficient_kg * Vector3d(flow_B.x(), flow_B.y(), 0);
    // wind from below carries, as sinking does
    force_B.z() -= 4 * (p.rotor.thrust_coefficient_n_s2 * w * w - ClimbCoefficient(p.rotor) * w * flow_B.z());
    const Vector3d acceleration = force_B / p.mass_kg;
    EXPECT_LT((Acceleration().head<3>() - (R_NB * acceleration + Vector3d(0, 0, 9.81))).norm(), 1e-9);

    // the drag of the rotors acts above the centre of mass
    const Vector3d f = 4 * w * p.rotor.drag_coefficient_kg * flow_B;
    const Vector3d rolling = 4 * w * p.rotor.rolling_coefficient_kg_m * flow_B;
    const Vector3d torque_B(f.y() * p.rotor_height_m + rolling.x(), -f.x() * p.rotor_height_m + rolling.y(),
                            0);
    EXPECT_LT((Acceleration().tail<3>() - torque_B.cwiseQuotient(p.inertia_kg_m2)).norm(), 1e-9);
  }
}

TEST_F(MultirotorTest, LevelAircraftDriftsWithTheWindAsTheEquationOfMotionSays) {
  MultirotorParameters p;
  p.rotor_height_m = 0;  // so that the wind does not tilt it
  p.rotor.rolling_coefficient_kg_m = 0;
  Multirotor vehicle(p, model_.get());
  Settle(vehicle, Same(vehicle.HoverSpeed()));
  const Vector3d wind_N(3, -4, 0);

  const double rotors = 4 * vehicle.HoverSpeed() * p.rotor.drag_coefficient_kg;
  const auto acceleration = [&](double lag) {  // of the speed through the air
    return -(rotors * lag + 0.5 * 1.225 * p.drag_area_m2.x() * lag * lag) / p.mass_kg;
  };
  double lag = wind_N.norm();
  for (int second = 1; second <= 30; ++second) {
    for (int i = 0; i < 1000; ++i) Step(vehicle, wind_N);
    for (int i = 0; i < 100; ++i) {  // Runge and Kutta's second order, a step of 10 ms
      const double half = lag + 0.005 * acceleration(lag);
      lag += 0.01 * acceleration(half);
    }
    const Vector3d drift = (1 - lag / wind_N.norm()) * wind_N;
    ASSERT_LT((VectorFromMujoco(data_->qvel) - drift).norm(), 1e-3) << second;
  }
  EXPECT_LT((VectorFromMujoco(data_->qvel) - wind_N).norm(), 0.2);
}

TEST_F(MultirotorTest, TurningIsDampedByTheRotors) {
  const MultirotorParameters p;
  const double h = 1e-4;
  for (int axis = 0; axis < 3; ++axis) {
    const Vector3d rate_B = h * Vector3d::Unit(axis);
    const double torque = AerodynamicWrench(p, Same(505), kZero, rate_B, kHigh).torque[axis];
    EXPECT_LT(torque, 0) << axis;
  }
  // roll: right and left rotors move along their shafts at l w
  MultirotorParameters bare = p;
  bare.rotor.drag_coefficient_kg = bare.rotor.rolling_coefficient_kg_m = 0;
  EXPECT_NEAR(AerodynamicWrench(bare, Same(505), kZero, {h, 0, 0}, kHigh).torque.x(),
              -2 * p.arm_m * p.arm_m * ClimbCoefficient(p.rotor) * 505 * h, 1e-12);
}

TEST_F(MultirotorTest, GroundEffectRaisesTheLiftByItsFactor) {
  const MultirotorParameters p;
  Multirotor vehicle(p, model_.get());
  Settle(vehicle, Same(vehicle.HoverSpeed()));
  const double surface_m = 2;
  for (const double height_m : {0.01, 0.05, 0.1, 0.3, 1.0}) {  // of the centre of mass
    PoseToMujoco({Quaterniond::Identity(), {5, 5, -surface_m - height_m}}, data_->qpos);
    vehicle.Apply(data_.get(), 0.002, kZero, surface_m);
    const double z = std::max(height_m + p.rotor_height_m, 0.5 * p.rotor.radius_m);
    const double factor = 1 / (1 - std::pow(p.rotor.radius_m / (4 * z), 2));
    EXPECT_NEAR(Acceleration()[2], 9.81 * (1 - factor), 1e-9) << height_m;
  }
}

TEST_F(MultirotorTest, LowerRotorOfATiltedAircraftFeelsMoreOfTheGround) {
  const MultirotorParameters p;
  Multirotor vehicle(p, model_.get());
  Settle(vehicle, Same(vehicle.HoverSpeed()));
  PoseToMujoco({Quaterniond(RotationFromTaitBryan({.roll = 0.2})), {0, 0, -0.15}}, data_->qpos);
  vehicle.Apply(data_.get(), 0.002, kZero, 0);
  EXPECT_LT(Acceleration()[3], -0.1);  // back to level
  EXPECT_NEAR(Acceleration()[4], 0, 1e-9);
}

TEST_F(MultirotorTest, MotorsLagAndStayWithinTheirLimits) {
  Multirotor vehicle({}, model_.get());
  vehicle.Command({-100, 300, 5000, 838});
  EXPECT_TRUE(vehicle.saturated());
  for (int i = 1; i <= 10; ++i) {
    vehicle.Apply(data_.get(), 0.002, kZero, kNoGround);
    const double share = 1 - std::exp(-i * 0.002 / 0.0125);
    EXPECT_EQ(vehicle.speeds()[0], 0);
    EXPECT_NEAR(vehicle.speeds()[1], 300 * share, 1e-9);
    EXPECT_NEAR(vehicle.speeds()[2], 838 * share, 1e-9);
  }
}

TEST_F(MultirotorTest, IsSaturatedAtEitherEndButNotAtRest) {
  Multirotor vehicle({}, model_.get());
  EXPECT_FALSE(vehicle.saturated());
  vehicle.Command(Same(500));
  EXPECT_FALSE(vehicle.saturated());
  vehicle.Command({500, 500, 0, 500});
  EXPECT_TRUE(vehicle.saturated());
  vehicle.Command(vehicle.Allocate(12, {0, 0, 1}));
  EXPECT_TRUE(vehicle.saturated());
  vehicle.Command(vehicle.Allocate(100, kZero));
  EXPECT_TRUE(vehicle.saturated());
  vehicle.Command(vehicle.Allocate(12, {0.1, 0.1, 0.01}));
  EXPECT_FALSE(vehicle.saturated());
}

TEST_F(MultirotorTest, PelicanStandsOnItsSkidsAndDoesNotBounce) {
  ASSERT_NO_FATAL_FAILURE(Load(PelicanWorld()));
  Multirotor vehicle({}, model_.get());
  PoseToMujoco({Quaterniond::Identity(), {0, 0, -0.20}}, data_->qpos);
  VectorToMujoco({0.1, 0, 0.3}, data_->qvel);
  bool touched = false;
  double highest = 0;  // after the touch-down
  for (int i = 0; i < 1500; ++i) {
    Step(vehicle, kZero, 0);
    touched |= data_->ncon > 0;
    if (touched) highest = std::max(highest, data_->qpos[2]);
  }
  ASSERT_TRUE(touched);
  EXPECT_LT(highest, 0.17);
  EXPECT_NEAR(data_->qpos[2], 0.16, 0.003);
  EXPECT_LT(VectorFromMujoco(data_->qvel).norm(), 1e-3);
  EXPECT_NEAR(data_->xmat[9 + 8], 1, 1e-6);  // level
}

TEST_F(MultirotorTest, PelicanLeavesTheViewOfItsDownwardCameraFree) {
  ASSERT_NO_FATAL_FAILURE(Load(PelicanWorld()));
  mj_forward(model_.get(), data_.get());
  const Vector3d camera(data_->site_xpos + 3 * mj_name2id(model_.get(), mjOBJ_SITE, "camera_mount"));
  EXPECT_NEAR(camera.z() - data_->xpos[5], -0.05, 1e-12);
  ExpectFreeDownwardView(model_.get(), data_.get());
}

}  // namespace
}  // namespace kestrel::sim
