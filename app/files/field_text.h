// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "base/yaml/describe_fields.h"

namespace kestrel::app {

std::string AsSentence(const std::string& phrase);

// "number from 0 to 20, by default 0", "text, must be given"
std::string TypeAndDefault(const FieldDescription& field);

}  // namespace kestrel::app
