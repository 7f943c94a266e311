// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace kestrel {

// A text as a word of any POSIX shell that means it.
std::string ShellWord(const std::string& text);

}  // namespace kestrel
