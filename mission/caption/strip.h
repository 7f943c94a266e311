// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <string>
#include <vector>

#include "mission/caption/caption.h"

namespace kestrel::mission {

// The strip below an image that holds all that is said of it, so that no word covers what it speaks of: at the
// left of its first row a heading, at the right end who speaks, then the captions from left to right, as many to
// a row as there is room. It is of one height whatever it says, for frames of a video are of one size; text that
// would need more is written smaller.
struct StripText {
  std::string left, right;
  std::vector<Caption> captions;
};

struct PlacedText {
  std::string text;
  cv::Rect box;  // px, from the strip's upper left corner
  double scale;  // of the font
  bool alarm;
};

inline constexpr int kStripRow_px = 18;
// rows: at least 1.
std::vector<PlacedText> PlacedInStrip(const StripText& text, int width_px, int rows);
// image: CV_8UC3. As wide, and higher by rows * kStripRow_px + 4 px.
cv::Mat WithStrip(const cv::Mat& image, const StripText& text, int rows);

}  // namespace kestrel::mission
