// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace kestrel::campaign {

// What lies in scenarios/FLIGHT/KINDs/NAME.yaml, by its full name FLIGHT/NAME, sorted. kind: "campaign" or
// "tuning".
std::vector<std::string> NamesOfKind(const std::string& kind);

// A file that is given by itself, by its full name, or by NAME alone where only one flight has that. Throws
// InputError: there is none of that name, or one of several flights.
std::filesystem::path NamedFile(const std::string& kind, const std::string& name_or_file);

}  // namespace kestrel::campaign
