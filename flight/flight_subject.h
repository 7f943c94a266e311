// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "flight/flight_plan.h"
#include "records/mcap/flight_messages.h"
#include "records/page/flight_subject.h"

namespace kestrel::flight {

// What a page tells of a flight by these keys; the pad, if there is any, as the mission knows it and with no place.
// description: the scenario's sentence of itself; empty: what the mission is for is told instead.
records::FlightSubject SubjectOf(const FlightKeys& keys, const mission::MissionParts& parts,
                                 const std::string& mode, const std::string& description);

// What messages of ROS 2 tell of a flight by these parts beside its rows.
records::FlightMessageOptions MessageOptionsOf(const mission::MissionParts& parts);

// The command that flies a scenario with such overrides again: "kestrel run landing --seed 7 --set wind.mean_m_s=5".
std::string CommandOf(const std::string& name_or_file, const std::vector<std::string>& overrides);

}  // namespace kestrel::flight
