// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>

namespace kestrel {

// The file of the running program. Where /proc is not mounted, by the name that it was started with.
std::filesystem::path OwnProgram();

}  // namespace kestrel
