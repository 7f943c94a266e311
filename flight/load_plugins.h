// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace kestrel::flight {

// Loads plug-ins (mission/plugin.h): these, and those of KESTREL_PLUGINS of the environment, separated by
// colons, which then names all of them, so that the programs that this one starts load them too. Each is
// loaded once, and stays. Throws InputError with every one that is none, or of another version.
void LoadPlugins(const std::vector<std::string>& files);

// The files that were loaded, in their order.
const std::vector<std::string>& LoadedPlugins();

}  // namespace kestrel::flight
