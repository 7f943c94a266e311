// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace kestrel {

// The one of the valid names that a misspelt one most likely stands for, if any is near.
std::optional<std::string> NearestName(std::string_view name, const std::vector<std::string>& valid);

// What to say of a name that is none of the valid ones: the nearest, or all of them.
std::string RemedyForName(std::string_view name, const std::vector<std::string>& valid);

}  // namespace kestrel
