// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

#include "campaign/report/html_report.h"

namespace kestrel::campaign {

// A campaign of landings as one might come to: wind, latency, noise, light and starts vary, one run in a
// hundred does not pass, for different reasons. Made of numbers, not flown. folder: where records of the
// failures and of two others are written, with a video of the first of them.
ReportSubject LandingCampaign(std::int64_t runs, const std::filesystem::path& folder);

// Three methods, five repetitions of each.
TuningHistory HoverTuning();

}  // namespace kestrel::campaign
