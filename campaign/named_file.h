// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

namespace kestrel::campaign {

// A file that is given by itself or by its name: NAME or FLIGHT/NAME, for scenarios/FLIGHT/KINDs/NAME.yaml.
// kind: "campaign" or "tuning". Throws InputError: there is none of that name, or one of several flights.
std::filesystem::path NamedFile(const std::string& kind, const std::string& name_or_file);

}  // namespace kestrel::campaign
