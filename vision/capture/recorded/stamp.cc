// SPDX-License-Identifier: Apache-2.0
#include "vision/capture/recorded/stamp.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <string>

namespace kestrel::vision {
namespace {

constexpr int kDecimals = 9;  // of a second, in nanoseconds

bool AllDigits(std::string_view text) {
  return !text.empty() && std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

template <class Number>
std::optional<Number> Whole(std::string_view text) {
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

std::optional<std::int64_t> StampOfNanoseconds(std::string_view text) {
  return AllDigits(text) ? Whole<std::int64_t>(text) : std::nullopt;
}

std::optional<std::int64_t> StampOfSeconds(std::string_view text) {
  if (text.find_first_of("eE") != std::string_view::npos) {
    constexpr double kMost_s = 9e9;
    const auto seconds = Whole<double>(text);
    if (!seconds || !(*seconds >= 0 && *seconds < kMost_s)) return std::nullopt;
    return std::llround(*seconds * 1e9);
  }
  const std::size_t point = std::min(text.find('.'), text.size());
  const std::string_view whole = text.substr(0, point);
  std::string decimals(point < text.size() ? text.substr(point + 1) : "");
  if (!AllDigits(whole) || (!decimals.empty() && !AllDigits(decimals))) return std::nullopt;
  const bool up = decimals.size() > kDecimals && decimals[kDecimals] >= '5';
  decimals.resize(kDecimals, '0');
  const auto stamp = Whole<std::int64_t>(std::string(whole) + decimals);
  return stamp ? std::optional(*stamp + up) : std::nullopt;
}

std::optional<std::int64_t> StampOfName(std::string_view stem) {
  constexpr std::size_t kNanosecondDigits = 19, kLeastDecimals = 3;
  if (stem.size() == kNanosecondDigits && AllDigits(stem)) return StampOfNanoseconds(stem);
  const std::size_t point = stem.find('.');
  if (point == std::string_view::npos || stem.size() - point - 1 < kLeastDecimals ||
      !AllDigits(stem.substr(point + 1)))
    return std::nullopt;
  return StampOfSeconds(stem);
}

}  // namespace kestrel::vision
