// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace kestrel::scenarios {

// Adds the missions of Kestrel's own to those that there are (mission/mission_type.h). May be called again.
void AddFlights();

}  // namespace kestrel::scenarios
