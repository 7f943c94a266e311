// SPDX-License-Identifier: Apache-2.0
#include "python/core/overrides.h"

#include <fmt/format.h>
#include <pybind11/stl.h>

namespace kestrel::python {
namespace py = pybind11;

std::string YamlOf(const std::string& key, py::object value) {
  if (py::isinstance<py::str>(value)) return value.cast<std::string>();
  if (py::hasattr(value, "tolist")) value = value.attr("tolist")();  // of numpy
  try {
    return py::module_::import("json").attr("dumps")(value).cast<std::string>();
  } catch (py::error_already_set& e) {
    throw py::type_error(fmt::format("override {}: {}", key, e.what()));
  }
}

std::vector<std::string> OverridesOf(const py::object& given) {
  std::vector<std::string> all;
  if (given.is_none()) return all;
  if (py::isinstance<py::dict>(given)) {
    for (const auto& [key, value] : given.cast<py::dict>()) {
      if (!py::isinstance<py::str>(key))
        throw py::type_error(fmt::format("overrides: the key {} is no string", std::string(py::repr(key))));
      const auto name = key.cast<std::string>();
      all.push_back(fmt::format("{}={}", name, YamlOf(name, py::reinterpret_borrow<py::object>(value))));
    }
    return all;
  }
  if (!py::isinstance<py::list>(given) && !py::isinstance<py::tuple>(given))
    throw py::type_error(
        fmt::format("overrides are a dict of key and value, or a list of \"key=value\", and not {}",
                    std::string(py::repr(given))));
  for (const py::handle each : given) {
    if (!py::isinstance<py::str>(each))
      throw py::type_error(
          fmt::format("overrides: {} is no string \"key=value\"", std::string(py::repr(each))));
    all.push_back(each.cast<std::string>());
  }
  return all;
}

}  // namespace kestrel::python
