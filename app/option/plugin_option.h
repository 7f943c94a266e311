// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace kestrel::app {

// `--plugin`, to a command and to those under it: the files go to flight::LoadPlugins.
void AddPluginOption(CLI::App* command, std::vector<std::string>& files);

}  // namespace kestrel::app
