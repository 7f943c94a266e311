// SPDX-License-Identifier: Apache-2.0
#include "python/core/arrays.h"
#include "python/core/given.h"
#include "python/core/module.h"

namespace kestrel::python {
namespace py = pybind11;

void BindFrames(py::module_& m) {
  using F = ShownFrame;
  py::class_<F>(m, "Frame",
                "A camera's frame. Its arrays are views without a copy, which numpy does not write (OpenCV "
                "does: copy first), and which stay "
                "valid for as long as they are held.")
      .def_property_readonly(
          "t", [](const F& f) { return f.frame.t_s; }, "Middle of the exposure, on the autopilot's clock, s.")
      .def_property_readonly(
          "sequence", [](const F& f) { return f.frame.sequence; },
          "Counts exposures from 0; a gap is a lost frame.")
      .def_property_readonly(
          "image", [](const F& f) { return ViewOf(f.frame.image); },
          "(height, width) or (height, width, 3) in the order blue, green, red, uint8; None: the "
          "flight has no images.")
      .def_property_readonly(
          "depth", [](const F& f) { return ViewOf(f.depth); },
          "(height, width) float32, distance along the ray of each pixel, m; infinite in the sky, NaN "
          "outside the lens. None: not asked for.")
      .def_property_readonly(
          "segmentation", [](const F& f) { return ViewOf(f.segmentation); },
          "(height, width) int32, what each pixel shows, by its place in Sim.geom_names; -1: sky, -2: "
          "outside the lens. None: not asked for.")
      .def_property_readonly(
          "camera_position", [](const F& f) { return f.X_NC.p; },
          "(3,) the truth of the camera at the exposure: north, east, down, m.")
      .def_property_readonly(
          "camera_rotation", [](const F& f) { return f.X_NC.R.toRotationMatrix(); },
          "(3, 3) the truth: turns vectors of the camera (right, down, forward) into north-east-down.")
      .def_property_readonly(
          "flow", [](const F& f) { return ViewOf(f.flow); },
          "(height, width, 2) float32: [v, u] is by how many pixels to the right and down what pixel (u, v) "
          "of "
          "the frame before showed has moved until this one. None: not asked for, or it is the first.");
}

}  // namespace kestrel::python
