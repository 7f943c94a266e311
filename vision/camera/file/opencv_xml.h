// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

#include "base/yaml/config.h"

namespace kestrel::vision {

bool IsXml(std::string_view text);
// What OpenCV's FileStorage wrote as XML, as if it were YAML. Not readable, with a mistake: it is none of
// that. The line of a value is that on which its key first stands.
Config ParseOpenCvXml(const std::string& text, const std::string& name, Mistakes& mistakes);

}  // namespace kestrel::vision
