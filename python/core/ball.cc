// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <pybind11/stl.h>

#include <array>
#include <optional>

#include "python/core/arrays.h"
#include "python/core/camera.h"
#include "python/core/module.h"
#include "python/core/one_thread.h"
#include "vision/target/balloon_tracker.h"

namespace kestrel::python {
namespace py = pybind11;
using namespace pybind11::literals;
namespace {

vision::ColourRange RangeOf(double hue_deg, double hue_half_width_deg, double min_saturation,
                            double min_value) {
  if (!std::isfinite(hue_deg)) throw py::value_error("hue_deg must be a finite number");
  if (!(hue_half_width_deg >= 1 && hue_half_width_deg <= 90))
    throw py::value_error(fmt::format("hue_half_width_deg is {}; valid: 1 to 90", hue_half_width_deg));
  if (!(min_saturation >= 0 && min_saturation <= 1) || !(min_value >= 0 && min_value <= 1))
    throw py::value_error("min_saturation and min_value must be from 0 to 1");
  vision::ColourRange range;
  range.hue_deg = hue_deg;
  range.hue_half_width_deg = hue_half_width_deg;
  range.min_saturation = min_saturation;
  range.min_value = min_value;
  return range;
}

class BallTracker {
 public:
  BallTracker(const py::object& camera, double hue_deg, double hue_half_width_deg, double min_saturation,
              double min_value)
      : camera_(CameraOf(camera)),
        tracker_(vision::ColourModel(RangeOf(hue_deg, hue_half_width_deg, min_saturation, min_value)),
                 camera_, {}) {}

  void Begin(const std::array<double, 4>& box) { tracker_.Begin(cv::Rect2d(box[0], box[1], box[2], box[3])); }

  vision::BalloonObservation Track(const py::array& image) {
    const OneThread::Use use(one_thread_);
    const cv::Mat bgr = ImageOf(image, "image");
    if (bgr.channels() != 3) throw py::value_error("image is grey, and a ball is known by its colour");
    if (bgr.cols != vision::WidthPx(camera_) || bgr.rows != vision::HeightPx(camera_))
      throw py::value_error(fmt::format("image is of {} x {} pixels, and the camera's are of {} x {}",
                                        bgr.cols, bgr.rows, vision::WidthPx(camera_),
                                        vision::HeightPx(camera_)));
    const py::gil_scoped_release others_run;
    return tracker_.Track(bgr);
  }

 private:
  OneThread one_thread_{"BallTracker"};
  vision::CameraModel camera_;
  vision::BalloonTracker tracker_;
};

}  // namespace

void BindBall(py::module_& m) {
  using O = vision::BalloonObservation;
  py::class_<O>(m, "Ball", "What is seen of a ball in one image. Arrays are copies.")
      .def_property_readonly(
          "state", [](const O& o) { return vision::NameOf(o.track.state); },
          "Of its colour's tracking, such as 'tracked' or 'lost'.")
      .def_property_readonly(
          "direction",
          [](const O& o) -> std::optional<Eigen::Vector3d> {
            if (!o.cone) return std::nullopt;
            return o.cone->axis;
          },
          "(3,) unit vector to its centre, in the camera's frame, by its outline; None: it is not measured.")
      .def_property_readonly(
          "half_angle",
          [](const O& o) -> std::optional<double> {
            if (!o.cone) return std::nullopt;
            return o.cone->half_angle;
          },
          "Between its centre and its outline, rad: its radius is distance * sin(half_angle). Or None.")
      .def_property_readonly(
          "covariance", [](const O& o) { return Eigen::MatrixXd(o.covariance); },
          "(4, 4) of the direction and the half-angle, rad^2.")
      .def_property_readonly(
          "features",
          [](const O& o) -> std::optional<Eigen::Vector3d> {
            if (!o.features) return std::nullopt;
            return o.features->xyd;
          },
          "(3,) x/z and y/z of its centre and its diameter over z, without unit; or None.");

  py::class_<BallTracker>(
      m, "BallTracker",
      "A ball of one colour from image to image: found by its colour, measured by its outline. Not for "
      "several threads at a time.")
      .def(py::init<const py::object&, double, double, double, double>(), "camera"_a, "hue_deg"_a = 0.0,
           "hue_half_width_deg"_a = 15.0, "min_saturation"_a = 0.45, "min_value"_a = 0.12,
           "camera: a Camera, or the name or the file of one. hue_deg: middle of its hues, red 0, green 120, "
           "blue 240. "
           "min_saturation, min_value: 0 to 1, below which a pixel has no hue.")
      .def("begin", &BallTracker::Begin, "box"_a,
           "Points at it in the next image: (left, top, width, height), px. Without it, it is found by its "
           "colour.")
      .def("track", &BallTracker::Track, "image"_a, "The Ball in the next image, uint8 (height, width, 3).");
}

}  // namespace kestrel::python
