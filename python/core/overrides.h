// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/pybind11.h>

#include <string>
#include <vector>

namespace kestrel::python {

// The value of a key as YAML, of which JSON is a part; a string as it is.
std::string YamlOf(const std::string& key, pybind11::object value);

// "key.path=value" of a dict of them, or of a list of such strings. Values are anything that JSON has, also of numpy.
std::vector<std::string> OverridesOf(const pybind11::object& given);

}  // namespace kestrel::python
