// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/pybind11.h>

// The module kestrel._core: a file for each subject, which binds it by a function of its own.
namespace kestrel::python {

void BindErrors(pybind11::module_& m);
void BindSetpoints(pybind11::module_& m);
void BindStates(pybind11::module_& m);
void BindFrames(pybind11::module_& m);
void BindDecisions(pybind11::module_& m);
void BindSim(pybind11::module_& m);
void BindCamera(pybind11::module_& m);
void BindWorld(pybind11::module_& m);
void BindPad(pybind11::module_& m);
void BindBall(pybind11::module_& m);
void BindHorizon(pybind11::module_& m);
void BindLaws(pybind11::module_& m);

}  // namespace kestrel::python
