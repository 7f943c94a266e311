// SPDX-License-Identifier: Apache-2.0
#include "python/core/module.h"

PYBIND11_MODULE(_core, m) {
  using namespace kestrel::python;
  m.doc() = "What of Kestrel is C++; use it by the package kestrel.";
  BindErrors(m);
  BindSetpoints(m);
  BindStates(m);
  BindFrames(m);
  BindDecisions(m);
  BindSim(m);
  BindCamera(m);
  BindWorld(m);
  BindPad(m);
  BindBall(m);
  BindHorizon(m);
  BindLaws(m);
}
