// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "control/estimate/deck/deck_estimator.h"
#include "mission/touch_down/touch_down_records.h"

namespace kestrel::scenarios {

// Of a frame: where the deck is believed to be, and what touching down was expected to be like.
struct DeckReport final : mission::TouchDownReport {
  std::optional<control::DeckEstimator::Deck> deck;
  std::optional<mission::ExpectedTouch> touch;
};

// Beside those of every touch-down, the deck's truth.
std::vector<mission::TelemetryColumn> DeckColumns();
std::vector<mission::Metric> DeckMetrics();
void AddDeckMetrics(const std::vector<mission::LogRow>& rows, std::map<std::string, double>& metrics);

}  // namespace kestrel::scenarios
