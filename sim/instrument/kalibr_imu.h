// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "base/yaml/config.h"
#include "sim/instrument/instrument_parameters.h"

namespace kestrel::sim {

// The noise densities, random walks and update rate of a file as Kalibr reads (imu.yaml) and writes it
// (its results, below the name of the IMU); what else the file says is passed over. Mistakes have the file's
// own line; with any the numbers that are missing are as they were.
void ReadKalibrImu(const Config& file, ImuParameters& into, Mistakes& mistakes);

}  // namespace kestrel::sim
