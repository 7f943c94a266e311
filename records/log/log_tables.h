// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <map>
#include <string>
#include <string_view>
#include <vector>

namespace kestrel::records {

// The messages of one kind in a log: a column of numbers for each field, all of one length. "t_s" is the time.
using LogTable = std::map<std::string, std::vector<double>, std::less<>>;
// By the names of the kinds.
using LogTables = std::map<std::string, LogTable, std::less<>>;

// A ULog of PX4 (docs.px4.io, "ULog File Format"): the first instance of each topic; arrays as name[0], name[1],
// nested ones as outer.inner. What is cut off at the end is left out. Throws std::runtime_error: what is wrong.
LogTables ReadUlog(std::string_view bytes);

// A DataFlash log of ArduPilot (libraries/AP_Logger/LogStructure.h): fields in the units of their letters, the centi
// ones brought to whole. Throws std::runtime_error: what is wrong.
LogTables ReadDataFlash(std::string_view bytes);

// A table with a line of names before the numbers, as our telemetry.csv. Cells that are no numbers are NaN.
LogTable ReadCsvTable(std::string_view text);

}  // namespace kestrel::records
