// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <pybind11/operators.h>

#include <cmath>

#include "control/autopilot.h"
#include "python/core/module.h"

namespace kestrel::python {
namespace py = pybind11;
using namespace pybind11::literals;
namespace {

double Finite(const char* type, const char* name, double value) {
  if (!std::isfinite(value))
    throw py::value_error(fmt::format("{}: {} is {}; it must be a finite number", type, name, value));
  return value;
}

control::VelocitySetpoint Velocity(double vx, double vy, double vz, double yaw_rate) {
  return {{Finite("Velocity", "vx", vx), Finite("Velocity", "vy", vy), Finite("Velocity", "vz", vz)},
          Finite("Velocity", "yaw_rate", yaw_rate)};
}

control::PositionSetpoint Position(double north, double east, double down, double yaw) {
  return {{Finite("Position", "north", north), Finite("Position", "east", east),
           Finite("Position", "down", down)},
          Finite("Position", "yaw", yaw)};
}

control::AttitudeSetpoint Attitude(double roll, double pitch, double yaw_rate, double thrust) {
  return {Finite("Attitude", "roll", roll), Finite("Attitude", "pitch", pitch),
          Finite("Attitude", "yaw_rate", yaw_rate), Finite("Attitude", "thrust", thrust)};
}

control::RateSetpoint Rates(double p, double q, double r, double thrust) {
  return {{Finite("Rates", "p", p), Finite("Rates", "q", q), Finite("Rates", "r", r)},
          Finite("Rates", "thrust", thrust)};
}

}  // namespace

// A setpoint cannot be changed, so that one that is made is one that can be sent.
void BindSetpoints(py::module_& m) {
  using V = control::VelocitySetpoint;
  py::class_<V>(m, "Velocity",
                "A velocity in the heading frame: forward, right, down, m/s; and a yaw rate, rad/s, "
                "clockwise seen from above.")
      .def(py::init(&Velocity), "vx"_a, "vy"_a, "vz"_a, "yaw_rate"_a = 0.0)
      .def_property_readonly(
          "vx", [](const V& v) { return v.v_H.x(); }, "Forward, m/s.")
      .def_property_readonly(
          "vy", [](const V& v) { return v.v_H.y(); }, "To the right, m/s.")
      .def_property_readonly(
          "vz", [](const V& v) { return v.v_H.z(); }, "Down, m/s.")
      .def_readonly("yaw_rate", &V::yaw_rate, "Clockwise seen from above, rad/s.")
      .def("__repr__",
           [](const V& v) {
             return fmt::format("kestrel.Velocity({}, {}, {}, yaw_rate={})", v.v_H.x(), v.v_H.y(), v.v_H.z(),
                                v.yaw_rate);
           })
      .def(py::pickle([](const V& v) { return py::make_tuple(v.v_H.x(), v.v_H.y(), v.v_H.z(), v.yaw_rate); },
                      [](const py::tuple& t) {
                        return Velocity(t[0].cast<double>(), t[1].cast<double>(), t[2].cast<double>(),
                                        t[3].cast<double>());
                      }));

  using P = control::PositionSetpoint;
  py::class_<P>(m, "Position",
                "A place in the world, m: north, east and down of where the autopilot was switched on; "
                "and a heading, rad. On the ground, one above it is the command to take off.")
      .def(py::init(&Position), "north"_a, "east"_a, "down"_a, "yaw"_a)
      .def_property_readonly(
          "north", [](const P& p) { return p.p_N.x(); }, "m.")
      .def_property_readonly(
          "east", [](const P& p) { return p.p_N.y(); }, "m.")
      .def_property_readonly(
          "down", [](const P& p) { return p.p_N.z(); }, "m.")
      .def_readonly("yaw", &P::yaw, "Clockwise from north, rad.")
      .def("__repr__",
           [](const P& p) {
             return fmt::format("kestrel.Position({}, {}, {}, yaw={})", p.p_N.x(), p.p_N.y(), p.p_N.z(),
                                p.yaw);
           })
      .def(py::pickle([](const P& p) { return py::make_tuple(p.p_N.x(), p.p_N.y(), p.p_N.z(), p.yaw); },
                      [](const py::tuple& t) {
                        return Position(t[0].cast<double>(), t[1].cast<double>(), t[2].cast<double>(),
                                        t[3].cast<double>());
                      }));

  using A = control::AttitudeSetpoint;
  py::class_<A>(m, "Attitude", "Roll and pitch, rad, a yaw rate, rad/s, and a thrust, 0 to 1 of the maximum.")
      .def(py::init(&Attitude), "roll"_a, "pitch"_a, "yaw_rate"_a, "thrust"_a)
      .def_readonly("roll", &A::roll, "To the right, rad.")
      .def_readonly("pitch", &A::pitch, "Nose up, rad.")
      .def_readonly("yaw_rate", &A::yaw_rate, "Clockwise seen from above, rad/s.")
      .def_readonly("thrust", &A::thrust, "0 to 1 of the maximum.")
      .def("__repr__",
           [](const A& a) {
             return fmt::format("kestrel.Attitude({}, {}, yaw_rate={}, thrust={})", a.roll, a.pitch,
                                a.yaw_rate, a.thrust);
           })
      .def(py::pickle([](const A& a) { return py::make_tuple(a.roll, a.pitch, a.yaw_rate, a.thrust); },
                      [](const py::tuple& t) {
                        return Attitude(t[0].cast<double>(), t[1].cast<double>(), t[2].cast<double>(),
                                        t[3].cast<double>());
                      }));

  using R = control::RateSetpoint;
  py::class_<R>(m, "Rates",
                "Body rates about forward, right and down, rad/s, and a thrust, 0 to 1 of the maximum. "
                "Nothing limits the tilt.")
      .def(py::init(&Rates), "p"_a, "q"_a, "r"_a, "thrust"_a)
      .def_property_readonly(
          "p", [](const R& r) { return r.w_B.x(); }, "About forward, rad/s.")
      .def_property_readonly(
          "q", [](const R& r) { return r.w_B.y(); }, "About right, rad/s.")
      .def_property_readonly(
          "r", [](const R& r) { return r.w_B.z(); }, "About down, rad/s.")
      .def_readonly("thrust", &R::thrust, "0 to 1 of the maximum.")
      .def("__repr__",
           [](const R& r) {
             return fmt::format("kestrel.Rates({}, {}, {}, thrust={})", r.w_B.x(), r.w_B.y(), r.w_B.z(),
                                r.thrust);
           })
      .def(py::pickle([](const R& r) { return py::make_tuple(r.w_B.x(), r.w_B.y(), r.w_B.z(), r.thrust); },
                      [](const py::tuple& t) {
                        return Rates(t[0].cast<double>(), t[1].cast<double>(), t[2].cast<double>(),
                                     t[3].cast<double>());
                      }));
}

}  // namespace kestrel::python
