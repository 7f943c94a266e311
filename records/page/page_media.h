// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

// The videos and the scene of a flight's folder, as its page holds them.
namespace kestrel::records {

// An element script#id of text/plain with the bytes in Base64; empty without bytes.
std::string MediaElement(std::string_view id, std::string_view bytes);

// script#video, #view and #scene, with a suffix to their names, of those files of the folder that can be shown.
std::string MediaElements(const std::filesystem::path& folder, std::string_view suffix);

// What the page of that folder is without though it should have it, each in a sentence: a video or a scene that is
// cut off or none at all, or of more than 64 MB (ten minutes of video; no browser takes hours of it); a table of
// telemetry that is missing.
std::vector<std::string> LeftOutOfPage(const std::filesystem::path& folder);

}  // namespace kestrel::records
