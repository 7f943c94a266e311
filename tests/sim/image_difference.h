// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <opencv2/core.hpp>
#include <ostream>
#include <vector>

namespace kestrel::sim {

// Grey levels between two images of 8 bits, over all pixels and channels.
struct ImageDifference {
  double mean = 0;
  int of_99 = 0;  // 99 % are not more
  int most = 0;
  double above_1 = 0;  // share
};

inline ImageDifference Compare(const cv::Mat& a, const cv::Mat& b) {
  cv::Mat difference;
  cv::absdiff(a, b, difference);
  std::vector<uchar> sorted(difference.datastart, difference.dataend);
  std::sort(sorted.begin(), sorted.end());
  const auto above = sorted.end() - std::upper_bound(sorted.begin(), sorted.end(), 1);
  return {cv::mean(difference.reshape(1))[0], sorted[sorted.size() * 99 / 100], sorted.back(),
          static_cast<double>(above) / static_cast<double>(sorted.size())};
}

inline std::ostream& operator<<(std::ostream& out, const ImageDifference& d) {
  return out << "mean " << d.mean << ", 99 % up to " << d.of_99 << ", most " << d.most
             << ", above 1: " << d.above_1;
}

inline bool SameBits(const cv::Mat& a, const cv::Mat& b) {
  return a.size() == b.size() && a.type() == b.type() && std::equal(a.datastart, a.dataend, b.datastart);
}

}  // namespace kestrel::sim
