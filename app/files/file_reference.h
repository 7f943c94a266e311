// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace kestrel::app {

// docs/reference/files.md: all kinds of files with their keys, as Markdown.
std::string FileReference();

}  // namespace kestrel::app
