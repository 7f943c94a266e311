// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace kestrel::flight {

// The rows of a flight as text, for viewers who come late: all of some minutes; of a longer flight the newest,
// and evenly fewer of those before, so that one of hours takes no more memory. None that comes is skipped, as
// it is for plots (records/plot/plot_rows.h): who watches now is told of each.
class RowStore {
 public:
  static constexpr std::size_t kMax = 1 << 14;  // 9 minutes of 30 images a second
  struct Row {
    std::int64_t number;  // counted from 0 over all that were given
    std::string text;
  };

  void Add(std::string text) {
    if (rows_.size() == kMax) Thin();
    rows_.push_back({given_++, std::move(text)});
  }
  // Those that are there from this number on, the oldest first.
  auto From(std::int64_t number) const {
    return std::ranges::subrange(std::ranges::lower_bound(rows_, number, {}, &Row::number), rows_.end());
  }
  std::int64_t given() const { return given_; }

 private:
  // Makes room for kNewest: one in every_ of those before the newest stays, and these are at most half.
  void Thin() {
    const std::int64_t newest = given_ - static_cast<std::int64_t>(kNewest);
    while (newest / every_ >= static_cast<std::int64_t>(kMax / 2)) every_ *= 2;
    std::erase_if(rows_, [&](const Row& row) { return row.number < newest && row.number % every_ != 0; });
  }

  static constexpr std::size_t kNewest = kMax / 4;
  std::vector<Row> rows_;
  std::int64_t given_ = 0, every_ = 1;
};

}  // namespace kestrel::flight
