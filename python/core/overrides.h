// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/pybind11.h>

#include <string>
#include <vector>

namespace kestrel::python {

// "key.path=value" of a dict of them, or of a list of such strings. Values are anything that JSON has, also of numpy.
std::vector<std::string> OverridesOf(const pybind11::object& given);

}  // namespace kestrel::python
