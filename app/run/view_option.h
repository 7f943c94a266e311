// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "base/diagnostics.h"
#include "flight/simulated/view/view_options.h"

namespace kestrel::app {

// "1280x720" of an option, each side within what a view may have. None: it was not given, or is wrong.
std::optional<cv::Size> ReadViewSize(const char* option, const std::string& text, Mistakes& mistakes);

// --view KIND or KIND+camera and --view-size, over the scenario's own view. None: --view was not given, or is wrong.
std::optional<flight::ViewOptions> ReadView(const std::string& view, const std::string& size,
                                            const sim::ViewParameters& of_scenario, Mistakes& mistakes);

}  // namespace kestrel::app
