// SPDX-License-Identifier: Apache-2.0
#include "flight/dataset/trajectory/pose_file.h"

#include <fmt/format.h>

#include <array>
#include <charconv>
#include <cmath>
#include <optional>
#include <string>
#include <string_view>

#include "base/file/files.h"
#include "base/user_file.h"
#include "flight/dataset/trajectory/conventions.h"

namespace kestrel::flight {
namespace {

constexpr std::size_t kNumbers = 7;                       // of a pose
constexpr double kOffUnit = 0.01;                         // TUM's files have four decimals
constexpr std::int64_t kLongest_ns = 36'000'000'000'000;  // as a flight
constexpr std::size_t kMostMistakes = 20;                 // of one kind of file: the rest says the same

std::vector<std::string_view> CellsOf(std::string_view line, bool csv) {
  const char* separators = csv ? "," : " \t";
  std::vector<std::string_view> cells;
  for (std::size_t at = 0; at <= line.size();) {
    const std::size_t end = std::min(line.find_first_of(separators, at), line.size());
    std::string_view cell = line.substr(at, end - at);
    while (!cell.empty() && std::isspace(static_cast<unsigned char>(cell.front()))) cell.remove_prefix(1);
    while (!cell.empty() && std::isspace(static_cast<unsigned char>(cell.back()))) cell.remove_suffix(1);
    if (csv || !cell.empty()) cells.push_back(cell);
    at = end + 1;
  }
  return cells;
}

template <class T>
std::optional<T> NumberOf(std::string_view cell) {
  if (!cell.empty() && cell.front() == '+') cell.remove_prefix(1);
  T value{};
  const auto [end, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
  if (error != std::errc() || end != cell.data() + cell.size()) return std::nullopt;
  return value;
}

// Seconds with decimals, exactly: a double of today's date holds no ns.
std::optional<std::int64_t> StampOfSeconds(std::string_view cell) {
  const std::size_t dot = cell.find('.');
  const auto whole = NumberOf<std::int64_t>(cell.substr(0, dot));
  if (!whole || *whole < 0 || *whole > 9'000'000'000) return std::nullopt;
  std::string decimals(dot == std::string_view::npos ? "" : cell.substr(dot + 1));
  if (decimals.find_first_not_of("0123456789") != std::string::npos) return std::nullopt;
  decimals.resize(9, '0');
  return *whole * 1'000'000'000 + *NumberOf<std::int64_t>(decimals);
}

}  // namespace

bool IsPoseFile(const std::filesystem::path& file) { return HasEnding(file, {".csv", ".txt"}); }

LoadedTrajectory LoadPoses(const std::filesystem::path& file, const Pose& X_BC) {
  const bool csv = HasEnding(file, {".csv"});
  const FileContent content = ReadUserFile(file, kMaxDataBytes);
  if (!content.error.empty()) throw InputError(file.string(), content.error);
  Mistakes mistakes;
  std::vector<std::int64_t> stamps;
  std::vector<Pose> poses;
  std::vector<Place> places;
  std::string_view text = content.bytes;
  for (int line = 1; !text.empty() && mistakes.all().size() < kMostMistakes; ++line) {
    const std::string_view row = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(row.size() + 1, text.size()));
    const std::vector<std::string_view> cells = CellsOf(row, csv);
    if (cells.empty() || cells[0].empty() || cells[0].front() == '#') continue;
    const Place where(file.string(), line);
    if (cells.size() < kNumbers + 1 || (!csv && cells.size() > kNumbers + 1)) {
      mistakes.Add(
          where, "", fmt::format("has {} values", cells.size()),
          csv ? "valid: stamp [ns], x, y, z, qw, qx, qy, qz, and more" : "valid: t tx ty tz qx qy qz qw");
      continue;
    }
    const auto stamp = csv ? NumberOf<std::int64_t>(cells[0]) : StampOfSeconds(cells[0]);
    if (!stamp || *stamp < 0) {
      mistakes.Add(where, "", fmt::format("'{}' is no stamp", cells[0]),
                   csv ? "valid: a whole number of ns, not negative"
                       : "valid: seconds, not negative, without exponent, with up to nine decimals");
      continue;
    }
    std::array<double, kNumbers> n{};
    bool all = true;
    for (std::size_t i = 0; i < kNumbers; ++i) {
      const auto number = NumberOf<double>(cells[i + 1]);
      if (!number || !std::isfinite(*number)) {
        mistakes.Add(where, "", fmt::format("'{}' is not a finite number", cells[i + 1]));
        all = false;
      }
      n[i] = number.value_or(0);
    }
    if (!all) continue;
    const Eigen::Quaterniond q =
        csv ? Eigen::Quaterniond(n[3], n[4], n[5], n[6]) : Eigen::Quaterniond(n[6], n[3], n[4], n[5]);
    if (std::abs(q.norm() - 1) > kOffUnit) {
      mistakes.Add(where, "", fmt::format("the quaternion has the length {:.4g}", q.norm()), "valid: 1");
      continue;
    }
    if (!stamps.empty() && *stamp <= stamps.back()) {
      mistakes.Add(where, "",
                   fmt::format("the stamp {} is not after that of line {}", cells[0], places.back().line),
                   *stamp == stamps.back() ? "valid: each stamp once" : "valid: rising stamps");
      continue;
    }
    const Pose X_N = TurnWorld(Pose{q.normalized(), {n[0], n[1], n[2]}});
    stamps.push_back(*stamp);
    poses.push_back(csv ? X_N : X_N * X_BC.Inverse());
    places.push_back(where);
  }
  if (!stamps.empty() && stamps.back() - stamps.front() > kLongest_ns)
    mistakes.Add(places.back(), "",
                 fmt::format("is {:.6g} s after the first pose",
                             1e-9 * static_cast<double>(stamps.back() - stamps.front())),
                 "valid: up to 36000 s");
  if (mistakes.empty() && stamps.size() < 2)
    mistakes.Add(file.string(), "", fmt::format("holds {} poses", stamps.size()), "valid: two or more");
  mistakes.ThrowIfAny();
  return {Trajectory(stamps, poses), stamps, places};
}

}  // namespace kestrel::flight
