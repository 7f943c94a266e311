// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <string>

namespace kestrel::records {

// A text as gnuplot takes it: in single quotes it runs nothing that a name may hold.
std::string GnuplotQuoted(const std::string& text);

// The line that has a picture written to PartOf(file). gnuplot runs a name that begins with a bar as a
// command, so the name is an absolute one.
std::string GnuplotOutput(const std::filesystem::path& file);

// gnuplot says nothing when the disk is full: throws std::runtime_error unless the part of a picture ends as
// PNG ends.
void RequireWholePng(const std::filesystem::path& file);

// Draws one picture with a script that sets its terminal, and its output to PartOf(file). Throws
// std::runtime_error with the file and the reason.
void RunGnuplot(const std::filesystem::path& file, const std::string& script);

// The same with a script whose terminal and output are set already.
void DrawPng(const std::filesystem::path& file, int width_px, int height_px, const std::string& script);

}  // namespace kestrel::records
