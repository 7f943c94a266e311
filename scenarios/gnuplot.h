// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

namespace kestrel {

// A text as gnuplot takes it: in single quotes it runs nothing that a name may hold.
std::string GnuplotQuoted(const std::string& text);

// gnuplot says nothing when the disk is full: throws std::runtime_error unless the part of a picture ends as
// PNG ends.
void RequireWholePng(const std::filesystem::path& file);

// Draws one picture with that script, whose terminal and output are set already. Throws std::runtime_error
// with the file and the reason.
void DrawPng(const std::filesystem::path& file, int width_px, int height_px, const std::string& script);

}  // namespace kestrel
