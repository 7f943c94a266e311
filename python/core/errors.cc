// SPDX-License-Identifier: Apache-2.0
#include <exception>

#include "base/diagnostics.h"
#include "flight/stepped/sim.h"
#include "python/core/module.h"
#include "sim/simulator.h"

namespace kestrel::python {
namespace py = pybind11;

void BindErrors(py::module_& m) {
  static const auto* const input_error = new py::exception<InputError>(m, "InputError", PyExc_ValueError);
  static const auto* const sim_error = new py::exception<SimError>(m, "SimError", PyExc_RuntimeError);
  input_error->attr("__doc__") =
      "A scenario, a file or an override that cannot be: every mistake, one to a line, with its file, line, "
      "key and "
      "remedy.";
  sim_error->attr("__doc__") =
      "A Sim was used in a way that it cannot be, such as a step after the end; or its physics gave up.";
  py::register_exception_translator([](std::exception_ptr thrown) {
    try {
      if (thrown) std::rethrow_exception(thrown);
    } catch (const InputError& e) {
      PyErr_SetString(input_error->ptr(), e.what());
    } catch (const SimError& e) {
      PyErr_SetString(sim_error->ptr(), e.what());
    } catch (const sim::RunError& e) {
      PyErr_SetString(sim_error->ptr(), e.what());
    }
  });
}

}  // namespace kestrel::python
