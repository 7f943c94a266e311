// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <Eigen/Geometry>
#include <opencv2/core.hpp>

// How numbers and images of ours become arrays of numpy, and back.
namespace kestrel::python {

// (w, x, y, z), w >= 0.
Eigen::Vector4d QuaternionOf(const Eigen::Quaterniond& R);

// A view without a copy, which owns a reference to the pixels and cannot be written: (rows, columns), or
// (rows, columns, channels) of several channels. None of an empty one.
pybind11::object ViewOf(const cv::Mat& mat);

// The other way: a view of an array of uint8 of the shape (rows, columns) or (rows, columns, 3), which must live as
// long; what: for the message of the TypeError or ValueError that another one gets.
cv::Mat ImageOf(const pybind11::array& array, const char* what);

}  // namespace kestrel::python
