// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <pybind11/stl.h>

#include <optional>
#include <vector>

#include "control/law/bearing_servo.h"
#include "control/law/hold_bearing.h"
#include "control/law/pbvs.h"
#include "control/law/point_servo.h"
#include "control/law/servo_law.h"
#include "control/law/sphere_target.h"
#include "python/core/arrays.h"
#include "python/core/module.h"
#include "python/core/poses.h"

namespace kestrel::python {
namespace py = pybind11;
using namespace pybind11::literals;
namespace {

using Points2 = Eigen::Matrix<double, Eigen::Dynamic, 2, Eigen::RowMajor>;
using Points3 = Eigen::Matrix<double, Eigen::Dynamic, 3, Eigen::RowMajor>;
using Vector6 = Eigen::Matrix<double, 6, 1>;

Vector6 VectorOf(const control::Twist& twist) { return (Vector6() << twist.v, twist.w).finished(); }

double Positive(const char* name, double value) {
  if (!(value > 0) || !std::isfinite(value))
    throw py::value_error(fmt::format("{} is {}; it must be a positive number", name, value));
  return value;
}

void RequireFinite(const char* name, const Eigen::Ref<const Eigen::MatrixXd>& values) {
  if (!values.allFinite()) throw py::value_error(fmt::format("{} has a number that is not finite", name));
}

control::InteractionChoice ChoiceOf(const std::string& interaction) {
  if (interaction == "current") return control::InteractionChoice::kCurrent;
  if (interaction == "desired") return control::InteractionChoice::kDesired;
  if (interaction == "mean") return control::InteractionChoice::kMean;
  throw py::value_error(
      fmt::format("interaction '{}': valid are 'current', 'desired' and 'mean'", interaction));
}

std::vector<control::ImagePoint> ImagePointsOf(const Points2& points, const Eigen::VectorXd& depths) {
  if (points.rows() != depths.size())
    throw py::value_error(fmt::format("there are {} points and {} depths", points.rows(), depths.size()));
  std::vector<control::ImagePoint> all;
  for (Eigen::Index i = 0; i < points.rows(); ++i) all.push_back({points.row(i).transpose(), depths[i]});
  return all;
}

std::vector<control::BearingPoint> BearingsOf(const Points3& bearings, const Eigen::VectorXd& distances) {
  if (bearings.rows() != distances.size())
    throw py::value_error(
        fmt::format("there are {} bearings and {} distances", bearings.rows(), distances.size()));
  std::vector<control::BearingPoint> all;
  for (Eigen::Index i = 0; i < bearings.rows(); ++i)
    all.push_back({bearings.row(i).transpose(), distances[i]});
  return all;
}

void BindStep(py::module_& laws) {
  using S = control::ServoStep;
  py::class_<S>(laws, "ServoStep", "What a law says. Arrays are copies.")
      .def_property_readonly(
          "state", [](const S& s) { return control::NameOf(s.state); },
          "'regular', or why the velocity is none or leaves out directions.")
      .def_property_readonly(
          "regular", [](const S& s) { return s.state == control::ServoState::kRegular; },
          "The interaction matrix has the rank that its size allows.")
      .def_property_readonly(
          "velocity", [](const S& s) { return s.velocity; },
          "(m,) of the camera in its own frame: m/s, then rad/s; zero where there is none.")
      .def_readonly("rank", &S::rank, "Of the interaction matrix.")
      .def_readonly("conditioning", &S::conditioning, "Minimum over maximum singular value.")
      .def_readonly("reach", &S::reach, "Share of the error that any velocity can change, 0 to 1.");
  laws.def(
      "servo",
      [](const Eigen::MatrixXd& interaction, const Eigen::VectorXd& error, double gain, double damping) {
        if (interaction.rows() != error.size())
          throw py::value_error(fmt::format("interaction is of {} x {} and the error of {}",
                                            interaction.rows(), interaction.cols(), error.size()));
        return control::ServoVelocity(interaction, error, Positive("gain", gain), {.damping = damping});
      },
      "interaction"_a, "error"_a, "gain"_a, "damping"_a = 0.0,
      "The law of image-based servoing, thesis (5.6): velocity = -gain pinv(interaction) error. interaction "
      "(n, m), "
      "error (n,), gain 1/s. Returns a ServoStep.");
}

void BindImageBased(py::module_& laws) {
  laws.def(
      "point_interaction",
      [](const Points2& points, const Eigen::VectorXd& depths) {
        RequireFinite("points", points);
        for (const double depth : depths) Positive("a depth", depth);
        return control::PointInteraction(ImagePointsOf(points, depths));
      },
      "points"_a, "depths"_a,
      "(2n, 6) interaction matrix of points (n, 2), x/z and y/z in the camera, at depths (n,), m; thesis "
      "(5.7).");
  laws.def(
      "ibvs",
      [](const Points2& points, const Eigen::VectorXd& depths, const Points2& wanted,
         const Eigen::VectorXd& wanted_depths, double gain, const std::string& interaction) {
        if (points.rows() != wanted.rows())
          throw py::value_error(
              fmt::format("there are {} points and {} wanted", points.rows(), wanted.rows()));
        const auto now = ImagePointsOf(points, depths), goal = ImagePointsOf(wanted, wanted_depths);
        return control::PointServo(now, goal, ChoiceOf(interaction), Positive("gain", gain));
      },
      "points"_a, "depths"_a, "wanted"_a, "wanted_depths"_a, "gain"_a, "interaction"_a = "current",
      "Image-based servoing on points (n, 2), x/z and y/z in the camera, with depths (n,), m, and where they "
      "are "
      "wanted. interaction: 'current', 'desired' or 'mean'. Returns a ServoStep of (6,).");
  laws.def(
      "bearing_interaction",
      [](const Points3& bearings, const Eigen::VectorXd& distances) {
        RequireFinite("bearings", bearings);
        for (const double distance : distances) Positive("a distance", distance);
        return control::BearingInteraction(BearingsOf(bearings, distances));
      },
      "bearings"_a, "distances"_a, "(3n, 6) interaction matrix of unit vectors (n, 3) at distances (n,), m.");
  laws.def(
      "bearing_servo",
      [](const Points3& bearings, const Eigen::VectorXd& distances, const Points3& wanted,
         const Eigen::VectorXd& wanted_distances, double gain, const std::string& interaction) {
        if (bearings.rows() != wanted.rows())
          throw py::value_error(
              fmt::format("there are {} bearings and {} wanted", bearings.rows(), wanted.rows()));
        const auto now = BearingsOf(bearings, distances), goal = BearingsOf(wanted, wanted_distances);
        return control::BearingServo(now, goal, ChoiceOf(interaction), Positive("gain", gain));
      },
      "bearings"_a, "distances"_a, "wanted"_a, "wanted_distances"_a, "gain"_a, "interaction"_a = "current",
      "As ibvs, for unit vectors (n, 3) anywhere about the camera, with distances (n,), m.");
}

void BindPoseBased(py::module_& laws) {
  laws.def(
      "pbvs",
      [](const Eigen::Vector3d& position, const Eigen::Matrix3d& rotation, double gain) {
        return VectorOf(control::PbvsTwist(PoseOf(position, rotation), Positive("gain", gain)));
      },
      "position"_a, "rotation"_a, "gain"_a,
      "The decoupled law, thesis (5.13). position (3,), m, and rotation (3, 3): the pose of the camera in "
      "the one that "
      "is wanted. Returns (6,), m/s and rad/s, in the camera's frame; the position error falls along a "
      "straight line.");
  laws.def(
      "pbvs_target",
      [](const Eigen::Vector3d& position, const Eigen::Matrix3d& rotation,
         const Eigen::Vector3d& wanted_position, const Eigen::Matrix3d& wanted_rotation, double gain) {
        return VectorOf(control::PbvsTargetTwist(
            PoseOf(position, rotation), PoseOf(wanted_position, wanted_rotation), Positive("gain", gain)));
      },
      "position"_a, "rotation"_a, "wanted_position"_a, "wanted_rotation"_a, "gain"_a,
      "The law that holds the target's place in the camera, thesis (5.11), of the target's pose in the "
      "camera, and of "
      "where it is wanted. Returns (6,), m/s and rad/s.");
  laws.def(
      "setpoint",
      [](const Eigen::Vector3d& position, double yaw, double gain, double vertical_gain, double yaw_gain,
         double speed_limit, double climb_limit, double yaw_rate_limit) {
        RequireFinite("position", position);
        if (!std::isfinite(yaw)) throw py::value_error("yaw must be a finite number");
        control::ServoGains gains;
        gains.lambda_per_s = Positive("gain", gain);
        gains.lambda_vertical_per_s = Positive("vertical_gain", vertical_gain);
        gains.lambda_yaw_per_s = Positive("yaw_gain", yaw_gain);
        gains.speed_limit_m_s = Positive("speed_limit", speed_limit);
        gains.climb_limit_m_s = Positive("climb_limit", climb_limit);
        gains.yaw_rate_limit_deg_s = Positive("yaw_rate_limit", yaw_rate_limit) * 180 / M_PI;
        const Pose X_DH{Eigen::Quaterniond(Eigen::AngleAxisd(yaw, Eigen::Vector3d::UnitZ())), position};
        return control::ServoSetpoint(X_DH, gains);
      },
      "position"_a, "yaw"_a, "gain"_a = 1.1, "vertical_gain"_a = 1.2, "yaw_gain"_a = 0.8,
      "speed_limit"_a = 1.5, "climb_limit"_a = 0.8, "yaw_rate_limit"_a = 40 * M_PI / 180,
      "The decoupled law for an aircraft that its autopilot holds level: position (3,), m, and yaw, rad, of "
      "its heading "
      "frame in the one that is wanted. Gains 1/s; limits m/s and rad/s. Returns a Velocity.");
}

void BindTargets(py::module_& laws) {
  laws.def(
      "sphere_interaction",
      [](const Eigen::Vector3d& features, double depth) {
        RequireFinite("features", features);
        return Eigen::MatrixXd(
            control::SphereInteraction({features.head<2>(), features.z()}, Positive("depth", depth)));
      },
      "features"_a, "depth"_a,
      "(3, 6) interaction matrix of a sphere's image, features (3,): x/z, y/z and diameter/z, at a depth, m; "
      "thesis "
      "(5.18).");
  laws.def(
      "follow",
      [](const Eigen::Vector3d& features, const Eigen::Vector3d& wanted, double depth,
         const Eigen::Vector3d& gains, bool coupled) -> std::optional<Eigen::Vector3d> {
        const auto step = control::FollowVelocity(
            {features.head<2>(), features.z()}, {wanted.head<2>(), wanted.z()}, depth,
            coupled ? control::FollowCoupling::kCoupled : control::FollowCoupling::kDecoupled, gains);
        if (step.state != control::ServoState::kRegular) return std::nullopt;
        return step.velocity;
      },
      "features"_a, "wanted"_a, "depth"_a, "gains"_a, "coupled"_a = true,
      "Following a sphere, thesis (5.21): (3,) velocity of the camera down and forward, m/s, and its rate "
      "about down, "
      "rad/s. features, wanted (3,): x/z, y/z, diameter/z. gains (3,), 1/s. None: there is no such "
      "velocity.");
  laws.def(
      "hold_bearing",
      [](double azimuth, double bearing, double gain, double yaw_rate_limit, const std::string& side) {
        control::HoldBearingState state;
        if (side == "left")
          state.side = control::PassingSide::kLeft;
        else if (side == "right")
          state.side = control::PassingSide::kRight;
        else if (!side.empty())
          throw py::value_error(fmt::format("side '{}': valid are 'left', 'right' and ''", side));
        control::HoldBearingGains gains;
        gains.lambda_per_s = Positive("gain", gain);
        gains.bearing_deg = Positive("bearing", bearing) * 180 / M_PI;
        gains.yaw_rate_limit_deg_s = Positive("yaw_rate_limit", yaw_rate_limit) * 180 / M_PI;
        if (!std::isfinite(azimuth)) throw py::value_error("azimuth must be a finite number");
        const auto step = control::HoldBearing(state, azimuth, gains);
        return std::pair(step.yaw_rate, step.state.side == control::PassingSide::kLeft ? "left" : "right");
      },
      "azimuth"_a, "bearing"_a = 50 * M_PI / 180, "gain"_a = 1.0, "yaw_rate_limit"_a = 40 * M_PI / 180,
      "side"_a = "",
      "See and avoid, thesis (6.29): the yaw rate, rad/s, that holds another aircraft at a bearing off the "
      "bow, rad. "
      "azimuth: of the other, to the right, rad. side: on which it is passed, '' at first. Returns (yaw "
      "rate, side).");
}

}  // namespace

void BindLaws(py::module_& m) {
  BindStep(m);
  BindImageBased(m);
  BindPoseBased(m);
  BindTargets(m);
}

}  // namespace kestrel::python
