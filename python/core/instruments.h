// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <pybind11/numpy.h>

#include "flight/stepped/sim.h"

// The readings of the last step as structured arrays of numpy. SimError: the aircraft has no such instrument.
namespace kestrel::python {

pybind11::array ImuOf(const Sim& sim);
pybind11::array ImuTruthOf(const Sim& sim);
pybind11::array GpsOf(const Sim& sim);
pybind11::array BarometerOf(const Sim& sim);
pybind11::array MagnetometerOf(const Sim& sim);
pybind11::array RangefinderOf(const Sim& sim);
pybind11::array EventsOf(const Sim& sim);

}  // namespace kestrel::python
