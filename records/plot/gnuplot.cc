// SPDX-License-Identifier: Apache-2.0
#include "records/plot/gnuplot.h"

#include <fmt/format.h>

#include <fstream>
#include <stdexcept>

#include "base/file/files.h"
#include "base/process/piped_process.h"

namespace kestrel::records {

std::string GnuplotQuoted(const std::string& text) {
  std::string quoted = "'";
  for (const char c : text) {
    if (c == '\'')
      quoted += "''";
    else
      quoted += static_cast<unsigned char>(c) < 0x20 ? ' ' : c;
  }
  return quoted + '\'';
}

std::string GnuplotOutput(const std::filesystem::path& file) {
  return fmt::format("set output {}\n", GnuplotQuoted(std::filesystem::absolute(PartOf(file)).string()));
}

void RequireWholePng(const std::filesystem::path& file) {
  std::ifstream in(PartOf(file), std::ios::binary);
  in.seekg(-8, std::ios::end);
  char end[8] = {};
  in.read(end, sizeof end);
  if (!in || std::string_view(end, 4) != "IEND") {
    throw std::runtime_error(fmt::format("cannot write {}: the picture is not whole", file.string()));
  }
}

void RunGnuplot(const std::filesystem::path& file, const std::string& script) {
  try {
    PipedProcess gnuplot({"gnuplot", "-d"});
    gnuplot.Write(script);
    gnuplot.Close();
  } catch (const std::runtime_error& e) {
    throw std::runtime_error(fmt::format("cannot draw {}: {}", file.string(), e.what()));
  }
  RequireWholePng(file);
  Complete(file);
}

void DrawPng(const std::filesystem::path& file, int width_px, int height_px, const std::string& script) {
  RunGnuplot(file,
             fmt::format("set terminal pngcairo size {},{} font 'DejaVu Sans,12' background rgb 'white'\n"
                         "{}set encoding utf8\n{}\nunset output\n",
                         width_px, height_px, GnuplotOutput(file), script));
}

}  // namespace kestrel::records
