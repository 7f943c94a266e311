// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace kestrel::records {

struct TelemetryColumnsJson {
  std::string json;  // an object
  std::size_t rows = 0;
  double rate_hz = 0;  // of rows, by the column t_s; 0: not known
};

// The columns of a telemetry.csv by their names: each a list of its numbers, letter by letter as the file has them,
// null for an empty cell or what is not finite. One in which any cell is no number is {"words": [...], "at": [index
// or null, ...]}. Of a column that is wholly empty nothing is there; of a last row that was cut off neither. Throws
// std::runtime_error: a line with more or fewer cells than the first, with its number.
TelemetryColumnsJson ColumnsOf(std::string_view csv);

}  // namespace kestrel::records
