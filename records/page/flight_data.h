// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

namespace kestrel::records {

// What the page has of the folder of a run, as JSON: an object with what SubjectJson and OutcomeJson say
// (flight_json.h), and
//   events      [{t_s, what, is}], the lines of events.log
//   columns     those of telemetry.csv (telemetry_columns.h)
//   live        false
//   left_out    what the page is without though it should have it (page_media.h)
//   changeable  []: it has ended
// Of a flight that was broken off, by a crash or a cut of power, what had been written is there, "complete" is false
// and "error" says so. A folder of an older version has no page.json: camera and pad are null then, and again is
// empty. Throws InputError: the folder is none of a run, or one of its files is damaged.
std::string FlightData(const std::filesystem::path& folder);

}  // namespace kestrel::records
