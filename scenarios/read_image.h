// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <string>

#include "config/yaml_fields.h"

namespace kestrel {

// An image file, decoded as cv::imread does with these flags but never turned by what its camera noted. Empty
// if it is none or damaged; then a mistake says what it is instead.
cv::Mat ReadImage(const std::string& file, int flags, Mistakes& mistakes);

// Whether a file begins as images do, whole or not.
bool LooksLikeImage(const std::string& file);

}  // namespace kestrel
