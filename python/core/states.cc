// SPDX-License-Identifier: Apache-2.0
#include <pybind11/stl.h>

#include "control/autopilot.h"
#include "geometry/tait_bryan.h"
#include "geometry/truth.h"
#include "python/core/arrays.h"
#include "python/core/module.h"

namespace kestrel::python {
namespace py = pybind11;
namespace {

void BindVehicleState(py::module_& m) {
  using S = control::VehicleState;
  py::class_<S>(m, "State", "The autopilot's own estimate, never the truth. Arrays are copies.")
      .def_readonly("t", &S::t_s, "The autopilot's clock, s.")
      .def_property_readonly(
          "position", [](const S& s) { return s.p_NB; },
          "(3,) north, east, down of where it was switched on, m.")
      .def_property_readonly(
          "velocity", [](const S& s) { return s.v_N; }, "(3,) north, east, down, m/s.")
      .def_property_readonly(
          "attitude", [](const S& s) { return QuaternionOf(s.R_NB); },
          "(4,) quaternion w, x, y, z that turns vectors of the body into north-east-down.")
      .def_property_readonly(
          "rotation", [](const S& s) { return s.R_NB.toRotationMatrix(); }, "(3, 3) the same as a matrix.")
      .def_property_readonly(
          "rates", [](const S& s) { return s.w_B; }, "(3,) about forward, right and down of the body, rad/s.")
      .def_property_readonly(
          "yaw", [](const S& s) { return YawOf(s.R_NB); }, "Clockwise from north, rad.")
      .def_property_readonly(
          "mode", [](const S& s) { return NameOf(s.mode); },
          "What it is doing, such as 'velocity' or 'hold'.")
      .def_readonly("landed", &S::landed, "On the ground, motors stopped by the touch-down logic.")
      .def_readonly("saturated", &S::saturated, "A motor or the tilt is at its limit.")
      .def_readonly("aided", &S::aided, "It flies by an attitude that it was sent.");
}

void BindTruth(py::module_& m) {
  using T = TargetTruth;
  py::class_<T>(m, "Target", "Another thing in the air. Arrays are copies.")
      .def_readonly("diameter", &T::diameter_m, "m.")
      .def_property_readonly(
          "position", [](const T& t) { return t.p_N; }, "(3,) of its centre: north, east, down, m.")
      .def_property_readonly(
          "velocity", [](const T& t) { return t.v_N; }, "(3,) north, east, down, m/s.")
      .def_readonly("in_view", &T::in_view, "Its centre is in the image.");

  using S = Truth;
  py::class_<S>(m, "Truth", "What the simulator knows and no flight code may see. Arrays are copies.")
      .def_readonly("t", &S::t_s, "s.")
      .def_property_readonly(
          "position", [](const S& s) { return s.X_NB.p; }, "(3,) north, east, down, m.")
      .def_property_readonly(
          "velocity", [](const S& s) { return s.v_N; }, "(3,) north, east, down, m/s.")
      .def_property_readonly(
          "attitude", [](const S& s) { return QuaternionOf(s.X_NB.R); },
          "(4,) quaternion w, x, y, z that turns vectors of the body into north-east-down.")
      .def_property_readonly(
          "rotation", [](const S& s) { return s.X_NB.R.toRotationMatrix(); }, "(3, 3) the same as a matrix.")
      .def_property_readonly(
          "rates", [](const S& s) { return s.w_B; }, "(3,) about forward, right and down of the body, rad/s.")
      .def_property_readonly(
          "yaw", [](const S& s) { return YawOf(s.X_NB.R); }, "Clockwise from north, rad.")
      .def_property_readonly(
          "wind", [](const S& s) { return s.wind_N; },
          "(3,) velocity of the air at the aircraft: north, east, down, m/s.")
      .def_property_readonly(
          "camera_position", [](const S& s) { return s.X_NC.p; }, "(3,) north, east, down, m.")
      .def_property_readonly(
          "camera_rotation", [](const S& s) { return s.X_NC.R.toRotationMatrix(); },
          "(3, 3) turns vectors of the camera (right, down, forward) into north-east-down.")
      .def_property_readonly(
          "pad_position", [](const S& s) { return s.X_NT.p; }, "(3,) of its centre: north, east, down, m.")
      .def_property_readonly(
          "pad_rotation", [](const S& s) { return s.X_NT.R.toRotationMatrix(); },
          "(3, 3) turns vectors of the pad (x along its long side, z down) into north-east-down.")
      .def_property_readonly(
          "pad_velocity", [](const S& s) { return s.v_NT; }, "(3,) of its centre: north, east, down, m/s.")
      .def_readonly("touching", &S::touching, "The skids touch something.")
      .def_property_readonly(
          "targets", [](const S& s) { return s.targets; }, "What else flies: a list of Target.");
}

}  // namespace

void BindStates(py::module_& m) {
  BindVehicleState(m);
  BindTruth(m);
}

}  // namespace kestrel::python
