// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <filesystem>
#include <string>

#include "campaign/execution/result_store.h"

namespace kestrel::campaign {

// A result file but for what depends on the machine, as text, to the last bit.
inline std::string TablesOf(const std::filesystem::path& file) {
  const ResultStore store = ResultStore::Read(file);
  std::string text = HashOf(store.identity().table) + "\n";
  for (const RunResult& r : store.Results()) {
    text += fmt::format("{} {} {} {} {}", r.row, NameOf(r.status), r.outcome, r.state_hash, r.image_hash);
    for (const auto& [name, value] : r.metrics) text += fmt::format(" {}={:a}", name, value);
    text += "\n";
  }
  return text;
}

}  // namespace kestrel::campaign
