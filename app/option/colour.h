// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdio>
#include <string>

namespace kestrel::app {

// Whether a stream is a terminal that takes colours, and nobody wants none: NO_COLOR (no-color.org) is not set.
bool TakesColours(std::FILE* stream);

// For results, where colours are wanted; otherwise the text as it is.
std::string Green(const std::string& text, bool colours);
std::string Red(const std::string& text, bool colours);

}  // namespace kestrel::app
