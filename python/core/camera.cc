// SPDX-License-Identifier: Apache-2.0
#include "python/core/camera.h"

#include <fmt/format.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <limits>

#include "base/file/files.h"
#include "base/file/model_files.h"
#include "python/core/arrays.h"
#include "python/core/module.h"
#include "vision/camera/calibration_file.h"

namespace kestrel::python {
namespace py = pybind11;
using namespace pybind11::literals;
namespace {

namespace fs = std::filesystem;
using Doubles = py::array_t<double, py::array::c_style | py::array::forcecast>;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

Camera Load(const fs::path& name_or_file, const std::string& camera,
            const std::optional<std::pair<int, int>>& size) {
  Mistakes mistakes;
  std::string name = name_or_file.string();
  std::optional<Camera> loaded;
  if (const auto file = ModelFile(Model::kCamera, name, "", "Camera.load", mistakes)) {
    std::optional<cv::Size> image;
    if (size) image = cv::Size(size->first, size->second);
    loaded = Camera{vision::LoadCamera(*file, mistakes, camera, image)};
  }
  mistakes.ThrowIfAny();
  return *loaded;
}

Camera FromYaml(const std::string& text, const std::string& camera) {
  Mistakes mistakes;
  const Config config = ParseConfig(text, "Camera.from_yaml", {}, mistakes);
  Camera parsed{vision::ParseCamera(config, mistakes, camera)};
  mistakes.ThrowIfAny();
  return parsed;
}

// The rows of an array whose last dimension is so long, or of a single one.
py::ssize_t RowsOf(const Doubles& array, int length, const char* what) {
  if (array.ndim() < 1 || array.shape(array.ndim() - 1) != length)
    throw py::value_error(fmt::format("{} have the shape {}; it must be (..., {})", what,
                                      std::string(py::str(array.attr("shape"))), length));
  return array.size() / length;
}

// An array of the leading dimensions of another, with other last ones.
Doubles Like(const Doubles& array, std::initializer_list<py::ssize_t> last) {
  std::vector<py::ssize_t> shape(array.shape(), array.shape() + array.ndim() - 1);
  shape.insert(shape.end(), last);
  return Doubles(shape);
}

// For each row: out gets so many numbers of what function makes of it; NaN where it makes none.
template <int kIn, int kOut, class Function>
void ForRows(const double* in, double* out, py::ssize_t rows, Function function) {
  const py::gil_scoped_release others_run;
  for (py::ssize_t i = 0; i < rows; ++i) {
    const Eigen::Map<const Eigen::Matrix<double, kIn, 1>> row(in + kIn * i);
    Eigen::Map<Eigen::Matrix<double, kOut, 1>> result(out + kOut * i);
    if (!row.allFinite() || !function(Eigen::Matrix<double, kIn, 1>(row), result)) result.setConstant(kNan);
  }
}

Doubles ProjectAll(const Camera& camera, const Doubles& points) {
  const py::ssize_t rows = RowsOf(points, 3, "points");
  Doubles pixels = Like(points, {2});
  ForRows<3, 2>(points.data(), pixels.mutable_data(), rows, [&](const Eigen::Vector3d& p, auto& uv) {
    const auto found = vision::Project(camera.model, p);
    if (found) uv = *found;
    return found.has_value();
  });
  return pixels;
}

Doubles UnprojectAll(const Camera& camera, const Doubles& pixels) {
  const py::ssize_t rows = RowsOf(pixels, 2, "pixels");
  Doubles rays = Like(pixels, {3});
  ForRows<2, 3>(pixels.data(), rays.mutable_data(), rows, [&](const Eigen::Vector2d& uv, auto& ray) {
    const auto found = vision::Ray(camera.model, uv);
    if (found) ray = *found;
    return found.has_value();
  });
  return rays;
}

Doubles JacobianAll(const Camera& camera, const Doubles& points) {
  const py::ssize_t rows = RowsOf(points, 3, "points");
  Doubles jacobians = Like(points, {2, 3});
  ForRows<3, 6>(points.data(), jacobians.mutable_data(), rows, [&](const Eigen::Vector3d& p, auto& row) {
    Eigen::Matrix<double, 2, 3> by_point;
    if (!vision::Project(camera.model, p, &by_point)) return false;
    row << by_point.row(0).transpose(), by_point.row(1).transpose();
    return true;
  });
  return jacobians;
}

py::dict ParametersOf(const Camera& camera) {
  const std::vector<std::string> names = vision::ParameterNames(camera.model);
  const Eigen::VectorXd values = vision::Parameters(camera.model);
  py::dict all;
  for (std::size_t i = 0; i < names.size(); ++i)
    all[py::str(names[i])] = values[static_cast<Eigen::Index>(i)];
  return all;
}

std::string FileTextOf(const Camera& camera, const std::string& form) {
  if (form == "kestrel") return vision::ToCameraYaml(camera.model);
  if (form == "kalibr") return vision::ToKalibr(camera.model);
  throw py::value_error(fmt::format("form '{}': valid are 'kestrel' and 'kalibr'", form));
}

std::vector<std::string> NamesOf(const fs::path& file) {
  Mistakes mistakes;
  const Config config = LoadConfig(file, {}, mistakes);
  mistakes.ThrowIfAny();
  return vision::CameraNames(config);
}

}  // namespace

vision::CameraModel CameraOf(const py::object& given) {
  if (py::isinstance<Camera>(given)) return given.cast<const Camera&>().model;
  if (py::isinstance<py::str>(given) || py::hasattr(given, "__fspath__"))
    return Load(given.cast<fs::path>(), "", {}).model;
  throw py::type_error(fmt::format("a camera is a kestrel.Camera, or the name or the file of one, and not {}",
                                   std::string(py::repr(given))));
}

void BindCamera(py::module_& m) {
  py::class_<Camera>(
      m, "Camera",
      "A camera model: pinhole, brown_conrady, unified, kannala_brandt, double_sphere or one of its kin. "
      "Points and rays are in the camera's frame: right, down, forward.")
      .def_static(
          "load", &Load, "name_or_file"_a, "camera"_a = "", "size"_a = py::none(),
          "A camera by its name in models/cameras, or of a file of Kestrel, Kalibr, OpenCV, ROS, Basalt, "
          "VINS, "
          "ORB-SLAM, OKVIS, SVO or maplab, which is told by its content. camera: which of a file that has "
          "several. "
          "size: (width, height), px, for a file that does not say it. Raises InputError with every mistake.")
      .def_static("from_yaml", &FromYaml, "text"_a, "camera"_a = "", "The same, of the text of a file.")
      .def_static("names", &NamesOf, "file"_a,
                  "The cameras of a file of another program, the first first; of Kestrel's own files none.")
      .def_property_readonly(
          "model", [](const Camera& c) { return vision::NameOf(c.model); }, "Name of the model.")
      .def_property_readonly(
          "width", [](const Camera& c) { return vision::WidthPx(c.model); }, "Of the image, px.")
      .def_property_readonly(
          "height", [](const Camera& c) { return vision::HeightPx(c.model); }, "Of the image, px.")
      .def_property_readonly(
          "max_angle", [](const Camera& c) { return vision::MaxAngle(c.model); },
          "How far from the optical axis the valid domain goes, rad.")
      .def_property_readonly("parameters", &ParametersOf,
                             "fx, fy, cx, cy, then the model's own, by their names.")
      .def("project", &ProjectAll, "points"_a,
           "(..., 3) points, m, to (..., 2) pixels, which may lie off the image; NaN outside the valid "
           "domain.")
      .def("unproject", &UnprojectAll, "pixels"_a,
           "(..., 2) pixels to (..., 3) unit vectors; NaN where the lens shows nothing.")
      .def("jacobian", &JacobianAll, "points"_a,
           "(..., 3) points, m, to (..., 2, 3) derivatives of their pixels, px/m; NaN outside the valid "
           "domain.")
      .def("yaml", &FileTextOf, "form"_a = "kestrel",
           "The text of its file. form: 'kestrel', whose numbers read back to the same bits, or 'kalibr'.")
      .def(
          "save",
          [](const Camera& c, const fs::path& file, const std::string& form) {
            WriteFile(file, FileTextOf(c, form));
          },
          "file"_a, "form"_a = "kestrel", "Writes its file.")
      .def("__repr__",
           [](const Camera& c) {
             return fmt::format("<kestrel.Camera {} {} x {}>", vision::NameOf(c.model),
                                vision::WidthPx(c.model), vision::HeightPx(c.model));
           })
      .def(py::pickle([](const Camera& c) { return vision::ToCameraYaml(c.model); },
                      [](const std::string& text) { return FromYaml(text, ""); }));
}

}  // namespace kestrel::python
