// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <CLI/CLI.hpp>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "base/diagnostics.h"

namespace kestrel::app {

// What the command lines of campaigns and of tunings have in common.

// Beside what CLI11 itself checks; a text says what is wrong.

// nan is neither below nor above a range.
inline std::string NotNan(const std::string& text) {
  return std::isnan(std::strtod(text.c_str(), nullptr)) ? '\'' + text + "' is not a number" : "";
}

// What to say to `kestrel campaign` or `kestrel tune` alone: what there is. kind: "campaign" or "tuning".
std::string NoneNamed(const std::string& kind);

// A page of another kind than is to be written lies where its data do: --out is refused. kind: of that other,
// data: its file in the folder.
void RefuseReportOf(const char* kind, const std::filesystem::path& data, Mistakes& mistakes);

// Until OnEndSignals (base/process/end_signals.h) is called again: what asks the program to end ends it at
// once, with a word and the status of what broke off.
void EndOnInterrupt();

}  // namespace kestrel::app
