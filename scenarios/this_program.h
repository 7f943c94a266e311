// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace kestrel {

// The file of this program, also where no /proc is.
std::filesystem::path ThisProgram();

}  // namespace kestrel
