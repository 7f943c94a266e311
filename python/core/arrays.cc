// SPDX-License-Identifier: Apache-2.0
#include "python/core/arrays.h"

#include <fmt/format.h>

#include <vector>

namespace kestrel::python {
namespace py = pybind11;
namespace {

py::dtype TypeOf(int depth) {
  switch (depth) {
    case CV_8U:
      return py::dtype::of<std::uint8_t>();
    case CV_16U:
      return py::dtype::of<std::uint16_t>();
    case CV_32S:
      return py::dtype::of<std::int32_t>();
    case CV_32F:
      return py::dtype::of<float>();
    case CV_64F:
      return py::dtype::of<double>();
  }
  throw py::type_error(fmt::format("no array has the elements of an image of OpenCV's depth {}", depth));
}

}  // namespace

Eigen::Vector4d QuaternionOf(const Eigen::Quaterniond& R) {
  const double sign = R.w() < 0 ? -1 : 1;
  return {sign * R.w(), sign * R.x(), sign * R.y(), sign * R.z()};
}

py::object ViewOf(const cv::Mat& mat) {
  if (mat.empty()) return py::none();
  const py::capsule owner(new cv::Mat(mat), [](void* held) { delete static_cast<cv::Mat*>(held); });
  std::vector<py::ssize_t> shape = {mat.rows, mat.cols};
  std::vector<py::ssize_t> strides = {static_cast<py::ssize_t>(mat.step[0]),
                                      static_cast<py::ssize_t>(mat.elemSize())};
  if (mat.channels() > 1) {
    shape.push_back(mat.channels());
    strides.push_back(static_cast<py::ssize_t>(mat.elemSize1()));
  }
  py::array view(TypeOf(mat.depth()), shape, strides, mat.data, owner);
  py::detail::array_proxy(view.ptr())->flags &= ~py::detail::npy_api::NPY_ARRAY_WRITEABLE_;
  return view;
}

cv::Mat ImageOf(const py::array& array, const char* what) {
  if (!array.dtype().is(py::dtype::of<std::uint8_t>()))
    throw py::type_error(fmt::format("{} is an array of {}; it must be one of uint8", what,
                                     std::string(py::str(array.dtype()))));
  const bool colour = array.ndim() == 3;
  if ((array.ndim() != 2 && !colour) || (colour && array.shape(2) != 3) || array.size() == 0)
    throw py::value_error(fmt::format("{} has the shape {}; it must be (height, width) or (height, width, 3)",
                                      what, std::string(py::str(array.attr("shape")))));
  const int rows = static_cast<int>(array.shape(0)), columns = static_cast<int>(array.shape(1));
  const int type = colour ? CV_8UC3 : CV_8UC1;
  const bool dense = array.strides(1) == (colour ? 3 : 1) && (!colour || array.strides(2) == 1) &&
                     array.strides(0) >= columns * array.strides(1);
  if (!dense) {  // a slice with steps, turned or mirrored
    const py::array copy = py::module_::import("numpy").attr("ascontiguousarray")(array);
    return cv::Mat(rows, columns, type, const_cast<void*>(copy.data())).clone();
  }
  return cv::Mat(rows, columns, type, const_cast<void*>(array.data()),
                 static_cast<std::size_t>(array.strides(0)));
}

}  // namespace kestrel::python
