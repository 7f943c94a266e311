// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>
#include <pybind11/stl.h>

#include <opencv2/imgproc.hpp>
#include <optional>
#include <utility>

#include "base/file/model_files.h"
#include "mission/helipad_pilot.h"
#include "python/core/arrays.h"
#include "python/core/camera.h"
#include "python/core/module.h"
#include "python/core/one_thread.h"
#include "python/core/poses.h"
#include "vision/camera/views.h"
#include "vision/landmark/pad_file.h"
#include "vision/landmark/pad_tracker.h"

namespace kestrel::python {
namespace py = pybind11;
using namespace pybind11::literals;
namespace {

cv::Mat GreyOf(const py::array& image, const char* what) {
  cv::Mat grey = ImageOf(image, what);
  if (grey.channels() == 3) cv::cvtColor(grey, grey, cv::COLOR_BGR2GRAY);
  return grey;
}

// A pad by its name or file, or a picture of it with its size.
vision::PadReference ReferenceOf(const py::object& pad,
                                 const std::optional<std::pair<double, double>>& size) {
  Mistakes mistakes;
  vision::PadReference reference;
  if (py::isinstance<py::array>(pad)) {
    if (!size) throw py::value_error("a pad by its picture needs its size: (height, width), m");
    reference = vision::ReferenceOfPicture(GreyOf(pad.cast<py::array>(), "pad"), {size->first, size->second},
                                           "pad", "PadTracker", "pad", mistakes);
  } else {
    if (size) throw py::value_error("a pad's file has its size; size is for a picture");
    std::string name = py::str(pad);
    if (const auto file = ModelFile(Model::kPad, name, "", "PadTracker", mistakes))
      reference = vision::LoadPad(*file, mistakes).reference;
  }
  mistakes.ThrowIfAny();
  return reference;
}

vision::PadTrackerOptions OptionsOf(const std::string& method) {
  vision::PadTrackerOptions options;
  if (method != "klt" && method != "icia")
    throw py::value_error(fmt::format("method '{}': valid are 'klt' and 'icia'", method));
  options.method = method;
  return options;
}

vision::Pinhole TrackersViewOf(const vision::CameraModel& camera) {
  const auto view = mission::TrackersCamera(camera);
  if (!view)
    throw py::value_error("this camera's lens does not see its own axis, along which the pad is looked for");
  return *view;
}

class PadTracker {
 public:
  PadTracker(const py::object& pad, const py::object& camera,
             const std::optional<std::pair<double, double>>& size, const std::string& method)
      : camera_(CameraOf(camera)),
        view_(TrackersViewOf(camera_)),
        tracker_(ReferenceOf(pad, size), view_, OptionsOf(method)) {
    if (!std::holds_alternative<vision::Pinhole>(camera_))
      to_view_ = vision::MakeViewTable(vision::PerspectiveView{view_}, camera_);
  }

  std::optional<vision::PadObservation> Track(const py::array& image,
                                              const std::optional<Eigen::Vector3d>& position,
                                              const std::optional<Eigen::Matrix3d>& rotation) {
    const OneThread::Use use(one_thread_);
    cv::Mat grey = GreyOf(image, "image");
    if (grey.cols != vision::WidthPx(camera_) || grey.rows != vision::HeightPx(camera_))
      throw py::value_error(fmt::format("image is of {} x {} pixels, and the camera's are of {} x {}",
                                        grey.cols, grey.rows, vision::WidthPx(camera_),
                                        vision::HeightPx(camera_)));
    if (position.has_value() != rotation.has_value())
      throw py::value_error("an expected pose has both a position and a rotation");
    std::optional<Pose> expected;
    if (position) expected = PoseOf(*position, *rotation);
    const py::gil_scoped_release others_run;
    if (to_view_) grey = vision::Look(*to_view_, grey);
    return tracker_.Track(grey, expected);
  }

 private:
  OneThread one_thread_{"PadTracker"};
  vision::CameraModel camera_;
  vision::Pinhole view_;                      // the tracker's camera, of the same C
  std::optional<vision::ViewTable> to_view_;  // none: the image is the view
  vision::PadTracker tracker_;
};

}  // namespace

void BindPad(py::module_& m) {
  using O = vision::PadObservation;
  py::class_<O>(m, "PadPose", "Where the pad is in one image. Arrays are copies.")
      .def_property_readonly(
          "position", [](const O& o) { return o.X_CT.p; },
          "(3,) of the pad's centre in the camera: right, down, forward, m.")
      .def_property_readonly(
          "rotation", [](const O& o) { return o.X_CT.R.toRotationMatrix(); },
          "(3, 3) turns vectors of the pad (x along its long side, z down) into the camera's frame.")
      .def_property_readonly(
          "covariance", [](const O& o) { return Eigen::MatrixXd(o.covariance); },
          "(6, 6) of the translation, m, and the rotation vector, rad, in the camera's frame.")
      .def_readonly("inliers", &O::inliers, "Points that agree.")
      .def_readonly("residual_px", &O::residual_px, "Their root mean square error, px.")
      .def_readonly("visible", &O::visible, "Share of the pad that was matched, 0 to 1.")
      .def_readonly("registered", &O::registered, "Against the pad's known picture, so free of drift.")
      .def_readonly("found", &O::found, "By search in this image, not by tracking.");

  py::class_<PadTracker>(m, "PadTracker",
                         "The pose of a landing pad from image to image. Not for several threads at a time.")
      .def(py::init<const py::object&, const py::object&, const std::optional<std::pair<double, double>>&,
                    const std::string&>(),
           "pad"_a, "camera"_a, "size"_a = py::none(), "method"_a = "klt",
           "pad: a name in models/pads, a file, or its picture from above, uint8 (height, width) or (height, "
           "width, 3), "
           "with size = (height, width), m. camera: a Camera, or the name or the file of one, of any model. "
           "method: 'klt', "
           "by corners, or 'icia', by its whole picture. Raises InputError.")
      .def("track", &PadTracker::Track, "image"_a, "position"_a = py::none(), "rotation"_a = py::none(),
           "The PadPose in the next image, uint8 (height, width) or (height, width, 3); None: it is not "
           "seen, and there is "
           "never an old pose. position, rotation: where it should be, if that is known.");
}

}  // namespace kestrel::python
