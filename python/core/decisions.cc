// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <pybind11/stl.h>

#include <optional>

#include "python/core/arrays.h"
#include "python/core/given.h"
#include "python/core/module.h"

namespace kestrel::python {
namespace py = pybind11;

void BindDecisions(py::module_& m) {
  using D = OwnedDecision;
  py::class_<D>(m, "Decision",
                "What the scenario's own mission decides on a frame. Sim.step takes it as a setpoint.")
      .def_property_readonly(
          "setpoint", [](const D& d) { return d.decision.setpoint; },
          "Velocity, Position, Attitude or Rates; None: the last one stands.")
      .def_property_readonly(
          "aid",
          [](const D& d) -> std::optional<Eigen::Vector4d> {
            if (!d.decision.aid) return std::nullopt;
            return QuaternionOf(d.decision.aid->R_NB);
          },
          "(4,) attitude w, x, y, z for the autopilot to fly by in place of its own, or None.")
      .def_readonly("phase", &D::phase, "Of the flight plan, such as 'descend'.")
      .def_readonly("target", &D::target,
                    "State of the mission's target, in its own word, such as 'tracked'.")
      .def_readonly("outcome", &D::outcome, "Not empty: the flight is over, and this is how.")
      .def_property_readonly(
          "fix_position",
          [](const D& d) -> std::optional<Eigen::Vector3d> {
            if (!d.decision.fix) return std::nullopt;
            return d.decision.fix->p_TB;
          },
          "(3,) the aircraft in the frame of the mission's target, by the image alone, m; None: it is not "
          "seen.")
      .def_property_readonly(
          "fix_yaw",
          [](const D& d) -> std::optional<double> {
            if (!d.decision.fix) return std::nullopt;
            return d.decision.fix->yaw_TB;
          },
          "Its heading in that frame, rad, or None.")
      .def_property_readonly(
          "fix_age", [](const D& d) { return d.decision.fix_age_s; },
          "Time since the exposure of the newest fix, s.")
      .def_property_readonly(
          "goal_position", [](const D& d) { return d.decision.goal_T; },
          "(3,) where the aircraft is meant to be, in the target's frame, m, or None.")
      .def("__repr__", [](const D& d) {
        return fmt::format("<kestrel.Decision phase='{}' target='{}' outcome='{}'>", d.phase, d.target,
                           d.outcome);
      });
}

}  // namespace kestrel::python
