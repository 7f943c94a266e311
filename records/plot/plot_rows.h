// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "records/telemetry/flight_log.h"

namespace kestrel::records {

// The rows of a flight that its pictures are drawn from: all of some minutes, of a longer flight evenly
// fewer, so that one of hours takes no more memory. A row is 1.4 kB, and a picture a thousand pixels wide.
class PlotRows {
 public:
  static constexpr std::size_t kMax = 1 << 14;  // 9 minutes of 30 images a second

  void Add(const LogRow& row) {
    if (given_++ % every_ != 0) return;
    if (rows_.size() == kMax) {
      for (std::size_t i = 1; 2 * i < kMax; ++i) rows_[i] = std::move(rows_[2 * i]);
      rows_.resize(kMax / 2);
      every_ *= 2;
    }
    rows_.push_back(row);
  }
  const std::vector<LogRow>& rows() const { return rows_; }

 private:
  std::vector<LogRow> rows_;
  std::int64_t given_ = 0, every_ = 1;
};

}  // namespace kestrel::records
