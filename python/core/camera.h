// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/pybind11.h>

#include "vision/camera/camera_model.h"

namespace kestrel::python {

// A camera model, as Python has it: it cannot be changed.
struct Camera {
  vision::CameraModel model;
};

// A Camera, or the name or the file of one. TypeError, InputError.
vision::CameraModel CameraOf(const pybind11::object& given);

}  // namespace kestrel::python
