// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>

#include "sim/world/scene.h"

namespace kestrel::sim {

// Empty message: it compiled.
struct CompiledModel {
  ModelPtr model;
  std::string message;
};

// Compiles a model in MJCF. files: what it names that lies in memory only, by its name. May be called on any
// thread.
CompiledModel CompileMjcf(const std::string& mjcf, std::map<std::string, std::string> files = {});

}  // namespace kestrel::sim
