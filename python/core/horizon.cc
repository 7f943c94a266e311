// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <pybind11/stl.h>

#include <optional>
#include <utility>

#include "python/core/arrays.h"
#include "python/core/camera.h"
#include "python/core/module.h"
#include "python/core/one_thread.h"
#include "python/core/poses.h"
#include "vision/horizon/skyline.h"
#include "vision/horizon/visual_compass.h"

namespace kestrel::python {
namespace py = pybind11;
using namespace pybind11::literals;
namespace {

// An image of the size that the camera gives.
cv::Mat SizedImage(const py::array& array, const char* what, const vision::CameraModel& camera) {
  const cv::Mat image = ImageOf(array, what);
  if (image.cols != vision::WidthPx(camera) || image.rows != vision::HeightPx(camera))
    throw py::value_error(fmt::format("{} is of {} x {} pixels, and the camera's images are of {} x {}", what,
                                      image.cols, image.rows, vision::WidthPx(camera),
                                      vision::HeightPx(camera)));
  return image;
}

cv::Mat MaskOf(const std::optional<py::array>& mask, const vision::CameraModel& camera) {
  if (!mask) return {};
  const cv::Mat image = SizedImage(*mask, "mask", camera);
  if (image.channels() != 1) throw py::value_error("mask must be (height, width)");
  return image.clone();
}

std::optional<Eigen::Vector3d> UnitOf(const std::optional<Eigen::Vector3d>& vector, const char* what) {
  if (!vector) return std::nullopt;
  if (!vector->allFinite() || vector->norm() < 1e-9)
    throw py::value_error(fmt::format("{} must be a finite vector that is not zero", what));
  return vector->normalized();
}

struct Measured {
  vision::SkylineResult result;
  Eigen::Matrix3d R_BC;
  const vision::SkylineFix* fix() const { return std::get_if<vision::SkylineFix>(&result); }
  std::optional<vision::RollPitch> attitude() const {
    if (!fix()) return std::nullopt;
    return vision::RollPitchFromDown(R_BC * fix()->down_C, R_BC * fix()->covariance * R_BC.transpose());
  }
};

class Horizon {
 public:
  Horizon(const py::object& camera, const Eigen::Matrix3d& mount, const std::optional<py::array>& mask)
      : camera_(CameraOf(camera)),
        R_BC_(RotationOf(mount).toRotationMatrix()),
        skyline_(camera_, R_BC_, MaskOf(mask, camera_), {}) {}

  Measured Measure(const py::array& image, const std::optional<Eigen::Vector3d>& down, double down_sigma,
                   const std::optional<double>& height) const {
    const cv::Mat pixels = SizedImage(image, "image", camera_);
    const vision::SkylineExpected expected{UnitOf(down, "down"), down_sigma, height};
    const py::gil_scoped_release others_run;
    return {skyline_.Measure(pixels, expected), R_BC_};
  }

 private:
  vision::CameraModel camera_;
  Eigen::Matrix3d R_BC_;
  vision::Skyline skyline_;
};

class Compass {
 public:
  Compass(const py::object& camera, const Eigen::Matrix3d& mount, const std::optional<py::array>& mask)
      : camera_(CameraOf(camera)),
        compass_(camera_, RotationOf(mount).toRotationMatrix(), MaskOf(mask, camera_), {}) {}

  vision::CompassResult Turn(const py::array& image, const Eigen::Vector3d& down) {
    const OneThread::Use use(one_thread_);
    const cv::Mat pixels = SizedImage(image, "image", camera_);
    if (pixels.channels() != 3) throw py::value_error("image must be (height, width, 3)");
    const auto down_C = UnitOf(down, "down");
    const py::gil_scoped_release others_run;
    return compass_.Turn(pixels, down_C);
  }

  int keyframes() const { return compass_.keyframes(); }
  void Forget() {
    const OneThread::Use use(one_thread_);
    compass_.Forget();
  }

 private:
  OneThread one_thread_{"Compass"};
  vision::CameraModel camera_;
  vision::VisualCompass compass_;
};

struct Heading {
  vision::CompassResult result;
  const vision::CompassHeading* heading() const { return std::get_if<vision::CompassHeading>(&result); }
};

void BindSkyline(py::module_& m) {
  py::class_<Measured>(m, "Skyline", "What the skyline of one image says of the attitude. Arrays are copies.")
      .def("__bool__", [](const Measured& s) { return s.fix() != nullptr; })
      .def_property_readonly(
          "reason",
          [](const Measured& s) {
            return s.fix() ? "" : vision::NameOf(std::get<vision::NoSkyline>(s.result));
          },
          "Why there is no attitude; empty: there is one.")
      .def_property_readonly(
          "roll",
          [](const Measured& s) -> std::optional<double> {
            if (const auto a = s.attitude()) return a->roll;
            return std::nullopt;
          },
          "Of the aircraft, to the right, rad; or None.")
      .def_property_readonly(
          "pitch",
          [](const Measured& s) -> std::optional<double> {
            if (const auto a = s.attitude()) return a->pitch;
            return std::nullopt;
          },
          "Of the aircraft, nose up, rad; or None.")
      .def_property_readonly(
          "covariance",
          [](const Measured& s) -> std::optional<Eigen::Matrix2d> {
            if (const auto a = s.attitude()) return a->covariance;
            return std::nullopt;
          },
          "(2, 2) of roll and pitch, rad^2; or None.")
      .def_property_readonly(
          "down",
          [](const Measured& s) -> std::optional<Eigen::Vector3d> {
            if (s.fix()) return s.fix()->down_C;
            return std::nullopt;
          },
          "(3,) unit vector down, in the camera's frame; or None.")
      .def_property_readonly(
          "circle_seen",
          [](const Measured& s) -> std::optional<double> {
            if (s.fix()) return s.fix()->circle_seen;
            return std::nullopt;
          },
          "Share of the azimuths in which the contour was found, 0 to 1; or None.");

  py::class_<Horizon>(m, "Horizon", "Attitude from the skyline of one image, without memory of any other.")
      .def(py::init<const py::object&, const Eigen::Matrix3d&, const std::optional<py::array>&>(), "camera"_a,
           "mount"_a, "mask"_a = py::none(),
           "camera: a Camera, or the name or the file of one. mount (3, 3): turns vectors of the camera "
           "(right, down, "
           "forward) into the aircraft's (forward, right, down). mask: uint8 (height, width), not 0 where "
           "the aircraft "
           "itself is seen.")
      .def("measure", &Horizon::Measure, "image"_a, "down"_a = py::none(), "down_sigma"_a = 0.05,
           "height"_a = py::none(),
           "The Skyline of an image, uint8 (height, width) or (height, width, 3). down (3,): where it is "
           "expected, in the "
           "camera's frame, with its deviation, rad; height: over the ground, m. They say where to look and "
           "what to refuse, "
           "and are not mixed into the measurement.");
}

}  // namespace

void BindHorizon(py::module_& m) {
  BindSkyline(m);
  py::class_<Heading>(m, "Heading", "How far the aircraft has turned, by one image.")
      .def("__bool__", [](const Heading& h) { return h.heading() != nullptr; })
      .def_property_readonly(
          "reason",
          [](const Heading& h) {
            return h.heading() ? "" : vision::NameOf(std::get<vision::NoHeading>(h.result));
          },
          "Why there is no heading; empty: there is one.")
      .def_property_readonly(
          "turned",
          [](const Heading& h) -> std::optional<double> {
            if (h.heading()) return h.heading()->turned;
            return std::nullopt;
          },
          "Since the first image, rad, clockwise seen from above, over any number of turns; or None.")
      .def_property_readonly(
          "variance",
          [](const Heading& h) -> std::optional<double> {
            if (h.heading()) return h.heading()->variance;
            return std::nullopt;
          },
          "rad^2; or None.")
      .def_property_readonly(
          "likeness",
          [](const Heading& h) -> std::optional<double> {
            if (h.heading()) return h.heading()->likeness;
            return std::nullopt;
          },
          "To the keyframe that it was compared with, -1 to 1; or None.");

  py::class_<Compass>(
      m, "Compass",
      "Heading from what stands round about, by keyframes that it learns. Not for several threads at a time.")
      .def(py::init<const py::object&, const Eigen::Matrix3d&, const std::optional<py::array>&>(), "camera"_a,
           "mount"_a, "mask"_a = py::none(), "As of Horizon.")
      .def(
          "turn",
          [](Compass& c, const py::array& image, const Eigen::Vector3d& down) {
            return Heading{c.Turn(image, down)};
          },
          "image"_a, "down"_a,
          "The Heading by the next image, uint8 (height, width, 3). down (3,): in the camera's frame, such "
          "as Skyline.down.")
      .def("forget", &Compass::Forget, "Begins anew: the next image is the first.")
      .def_property_readonly("keyframes", &Compass::keyframes, "How many it has learnt.");
}

}  // namespace kestrel::python
