// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/stabilisation/gyro_file.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <numbers>
#include <sstream>

#include "base/user_file.h"

namespace kestrel::vision {
namespace {

std::vector<std::string> Cells(const std::string& line) {
  std::vector<std::string> cells;
  std::istringstream in(line);
  for (std::string cell; std::getline(in, cell, ',');) {
    const std::size_t from = cell.find_first_not_of(" \t\r"), to = cell.find_last_not_of(" \t\r");
    cells.push_back(from == std::string::npos ? "" : cell.substr(from, to - from + 1));
  }
  return cells;
}

bool ReadNumber(const std::string& cell, double& number) {
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), number);
  return error == std::errc() && end == cell.data() + cell.size() && std::isfinite(number);
}

}  // namespace

std::vector<GyroSample> ReadGyroFile(const std::string& file, Mistakes& mistakes) {
  constexpr const char* kValid = "valid: t_s,wx_rad_s,wy_rad_s,wz_rad_s, or the rates in _deg_s";
  const FileContent content = ReadUserFile(file, kMaxDataBytes);
  if (!content.error.empty()) {
    mistakes.Add(file, "", content.error, kValid);
    return {};
  }
  std::istringstream in(content.bytes);
  std::string line;
  std::getline(in, line);
  const std::vector<std::string> header = Cells(line);
  const auto column = [&](const std::string& name) {
    const auto at = std::find(header.begin(), header.end(), name);
    return at == header.end() ? -1 : static_cast<int>(at - header.begin());
  };
  std::array<int, 4> columns = {column("t_s"), column("wx_rad_s"), column("wy_rad_s"), column("wz_rad_s")};
  double unit = 1;
  if (columns[1] < 0) {
    columns = {column("t_s"), column("wx_deg_s"), column("wy_deg_s"), column("wz_deg_s")};
    unit = std::numbers::pi / 180;
  }
  if (std::any_of(columns.begin(), columns.end(), [](int c) { return c < 0; })) {
    mistakes.Add({file, 1}, "", "its header does not name the columns of a gyro", kValid);
    return {};
  }
  std::vector<GyroSample> samples;
  for (int number = 2; std::getline(in, line); ++number) {
    const std::vector<std::string> cells = Cells(line);
    if (cells.empty()) continue;
    std::array<double, 4> values{};
    for (std::size_t k = 0; k < 4; ++k) {
      const auto c = static_cast<std::size_t>(columns[k]);
      if (c < cells.size() && ReadNumber(cells[c], values[k])) continue;
      mistakes.Add({file, number}, header[c],
                   fmt::format("'{}' is no number", c < cells.size() ? cells[c] : ""));
      return {};
    }
    if (!samples.empty() && !(values[0] > samples.back().t_s)) {
      mistakes.Add({file, number}, "t_s",
                   fmt::format("{} is not later than {} of the row before it", values[0], samples.back().t_s),
                   "valid: rows in the order of time");
      return {};
    }
    samples.push_back({values[0], unit * Eigen::Vector3d(values[1], values[2], values[3])});
  }
  if (samples.size() < 2) mistakes.Add(file, "", "has fewer than two rows", kValid);
  return samples;
}

}  // namespace kestrel::vision
