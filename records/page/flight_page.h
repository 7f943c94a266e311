// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "records/page/flight_subject.h"

namespace kestrel::records {

// A page of HTML that shows a flight, or two over each other, and holds all that it shows: it works from a file,
// without a network. Its own files lie in records/page/web of the program's data; Chart.js and three.js are put
// into it. It has the elements
//   script#data of application/json      {"flights": [FLIGHT] or [FLIGHT, FLIGHT]} of flight_data.h
//   script#video, #view, #scene          of text/plain: video.mp4, view.mp4, scene.glb in Base64; none where the
//                                        folder has no such file
//   script#video-b, #view-b, #scene-b    of the second flight
// What cannot be shown is left out, and the page says so (page_media.h).
// The same folders give the same page. Throws InputError as FlightData; std::runtime_error: a file of the page or a
// library is not there.
std::string FlightPage(const std::filesystem::path& folder,
                       const std::optional<std::filesystem::path>& second = {});

// The page of a flight that goes on: FLIGHT is LiveJson's (flight_json.h). scene_glb: of its world; empty: there is
// none.
std::string LiveFlightPage(const FlightSubject& subject, const std::string& scene_glb = {});

// Writes report.html into the folder of a run that has ended.
void WriteFlightPage(const std::filesystem::path& folder);

}  // namespace kestrel::records
