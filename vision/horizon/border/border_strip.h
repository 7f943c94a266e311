// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <opencv2/core.hpp>
#include <vector>

#include "vision/horizon/border/plane_view.h"

namespace kestrel::vision {

inline constexpr int kStripSpacing = 3;        // px between the columns of a strip
inline constexpr int kLeastStripColumns = 20;  // in view

// What is seen along a line: a row for each column across it, from below upwards, a pixel apart.
struct Strip {
  cv::Mat colour, shown;  // CV_32FC3; CV_8UC1
  double first = 0;       // of the columns, along the line from the foot of the middle of the view, px
};

// below, above: how far the columns reach from the line, px.
Strip ReadStrip(const cv::Mat& view, const cv::Mat& shown, const SkyBorder& line, int below, int above);

// Where the border lies in each column, between samples j - 1 and j, by the path that explains all of them best; -1
// where a column is not in view. middle: the sample on the line. start: where the border was, by column; what is
// nearer to it than the gap (px) teaches nothing. of_sky: the border is where the sky, as it goes on from above, ends;
// otherwise where the colours of what lies below it begin.
std::vector<double> BorderPath(const Strip& strip, int middle, const std::vector<double>& start, int gap,
                               bool of_sky);

// Of the samples from first to last.
cv::Vec3f MeanColour(const cv::Vec3f* colour, int from, int to);

}  // namespace kestrel::vision
