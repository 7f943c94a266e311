// SPDX-License-Identifier: Apache-2.0
#pragma once

#include "app/flight/replay_command.h"

namespace kestrel::app {

// Gives the images and states of an MCAP, whoever flew, to the mission of a scenario, as fast as it takes them; writes
// what it made of each image. Throws InputError with every mistake.
void ReplayLog(const ReplayArguments& arguments);

}  // namespace kestrel::app
