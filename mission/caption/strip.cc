// SPDX-License-Identifier: Apache-2.0
#include "mission/caption/strip.h"

#include <cassert>
#include <opencv2/imgproc.hpp>
#include <optional>

#include "vision/drawn_colours.h"

namespace kestrel::mission {
namespace {

constexpr int kFont = cv::FONT_HERSHEY_SIMPLEX;
constexpr double kScale = 0.45, kSmaller = 0.92;
constexpr int kEdge_px = 8, kBetween_px = 22, kBelowBase_px = 5;

// In a font of this scale; none: it does not fit.
std::optional<std::vector<PlacedText>> Placed(const StripText& text, int width_px, int rows, double scale) {
  std::vector<PlacedText> placed;
  int x = kEdge_px, row = 0, end = width_px - kEdge_px;
  const auto width_of = [scale](const std::string& words) {
    return cv::getTextSize(words, kFont, scale, 1, nullptr).width;
  };
  const auto add = [&](const std::string& words, int at, bool alarm) {
    placed.push_back({words, {at, row * kStripRow_px + 2, width_of(words), kStripRow_px}, scale, alarm});
  };
  if (!text.right.empty()) {
    const int width = width_of(text.right);
    add(text.right, end - width, false);
    end -= width + kBetween_px;
  }
  if (!text.left.empty()) {
    add(text.left, x, false);
    x += width_of(text.left) + kBetween_px;
    if (x - kBetween_px > end) return std::nullopt;
  }
  for (const Caption& each : text.captions) {
    if (each.text.empty()) continue;
    const int width = width_of(each.text);
    if (x + width > end) {
      if (++row == rows) return std::nullopt;
      x = kEdge_px, end = width_px - kEdge_px;
    }
    if (x + width > end) return std::nullopt;
    add(each.text, x, each.alarm);
    x += width + kBetween_px;
  }
  return placed;
}

}  // namespace

std::vector<PlacedText> PlacedInStrip(const StripText& text, int width_px, int rows) {
  assert(rows >= 1);
  constexpr double kLeast = 0.05;  // in which nobody can read
  for (double scale = kScale; scale > kLeast; scale *= kSmaller)
    if (auto placed = Placed(text, width_px, rows, scale)) return *std::move(placed);
  return {};
}

cv::Mat WithStrip(const cv::Mat& image, const StripText& text, int rows) {
  cv::Mat drawn;
  cv::copyMakeBorder(image, drawn, 0, rows * kStripRow_px + 4, 0, 0, cv::BORDER_CONSTANT);
  for (const PlacedText& each : PlacedInStrip(text, image.cols, rows)) {
    const cv::Point base(each.box.x, image.rows + each.box.y + kStripRow_px - kBelowBase_px);
    if (each.alarm)
      cv::rectangle(drawn, each.box + cv::Point(-4, image.rows) + cv::Size(8, -1), vision::kLimitColour,
                    cv::FILLED);
    cv::putText(drawn, each.text, base, kFont, each.scale, {255, 255, 255}, 1, cv::LINE_AA);
  }
  return drawn;
}

}  // namespace kestrel::mission
