// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <nlohmann/json_fwd.hpp>

#include "records/page/flight_subject.h"
#include "records/telemetry/flight_log.h"

namespace kestrel::records {

// What a page has of a flight, as JSON, without what was recorded: scenario, seed, mode, mission, title, wanted,
// again, version, rate_hz, camera, pad, changeable. Poses are {"p": m, "q": w, x, y, z}.
nlohmann::ordered_json SubjectJson(const FlightSubject& subject);

// What it came to: complete, passed, outcome, error, criteria, metrics, renderer, machine, plugins, sim_s, wall_s,
// stages, state_hash, image_hash. What is not finite is null.
nlohmann::ordered_json OutcomeJson(const Summary& summary);

// Both of a flight that goes on: "live" is true, "columns" and "events" are empty, the outcome is that of no flight.
nlohmann::ordered_json LiveJson(const FlightSubject& subject);

}  // namespace kestrel::records
