// SPDX-License-Identifier: Apache-2.0
#include "bench/planar/planar_pictures.h"

#include <algorithm>
#include <cmath>
#include <opencv2/imgproc.hpp>

#include "base/random.h"

namespace kestrel::bench {
namespace {

int Whole(RandomStream& random, int low, int high) {  // [low, high)
  return low + static_cast<int>(random.Bits() % static_cast<std::uint64_t>(high - low));
}

cv::Mat Text(RandomStream& random) {
  cv::Mat page(kPictureSize, CV_8UC1, cv::Scalar(235));
  for (int y = 70; y < page.rows - 30;) {
    const bool heading = random.Uniform(0, 1) < 0.15;
    const double scale = heading ? 1.9 : 1.0;
    for (int x = 45; x < page.cols - 120;) {
      std::string word;
      for (int i = Whole(random, 2, 9); i > 0; --i)
        word += static_cast<char>((heading ? 'A' : 'a') + Whole(random, 0, 26));
      const int width =
          cv::getTextSize(word, cv::FONT_HERSHEY_SIMPLEX, scale, heading ? 4 : 2, nullptr).width;
      if (x + width > page.cols - 40) break;
      cv::putText(page, word, {x, y}, cv::FONT_HERSHEY_SIMPLEX, scale, 25, heading ? 4 : 2, cv::LINE_AA);
      x += width + 24;
    }
    y += heading ? 68 : 44;
  }
  return page;
}

cv::Mat Sign(RandomStream& random) {
  cv::Mat sign(kPictureSize, CV_8UC1, cv::Scalar(225));
  cv::rectangle(sign, {24, 24}, {sign.cols - 25, sign.rows - 25}, 40, 26);
  const auto x = [&] { return Whole(random, 180, sign.cols - 180); };
  const auto y = [&] { return Whole(random, 160, sign.rows - 160); };
  // One draw at a time: the order in which a call's arguments are drawn is the compiler's.
  const auto point = [&] {
    const int u = x();
    return cv::Point(u, y());
  };
  const auto size = [&] {
    const int width = Whole(random, 120, 220);
    return cv::Size(width, Whole(random, 80, 140));
  };
  const cv::Point middle = point();
  cv::circle(sign, middle, Whole(random, 70, 120), 90, cv::FILLED, cv::LINE_AA);
  const cv::Point left_top = point() - cv::Point(90, 60);
  cv::rectangle(sign, cv::Rect(left_top, size()), 60, cv::FILLED);
  const cv::Point corner = point();
  const std::vector<cv::Point> arrow = {
      corner, {corner.x + 130, corner.y + 60}, {corner.x + 20, corner.y + 130}};
  cv::fillConvexPoly(sign, arrow, 30, cv::LINE_AA);
  return sign;
}

cv::Mat Repeated(RandomStream& random) {
  constexpr int kTile = 64;
  cv::Mat tile(kTile, kTile, CV_8UC1, cv::Scalar(200));
  const int u = Whole(random, 16, 28), v = Whole(random, 16, 28), radius = Whole(random, 8, 14),
            width = Whole(random, 12, 22), height = Whole(random, 12, 24);
  cv::circle(tile, {u, v}, radius, 50, cv::FILLED, cv::LINE_AA);
  cv::rectangle(tile, cv::Rect(36, 34, width, height), 95, cv::FILLED);
  cv::line(tile, {0, kTile - 1}, {kTile - 1, kTile - 1}, 130, 2);
  cv::Mat all = cv::repeat(tile, kPictureSize.height / kTile, kPictureSize.width / kTile);
  cv::rectangle(all, {16, 16}, {all.cols - 17, all.rows - 17}, 20,
                32);                                              // the one thing that tells where it ends
  cv::rectangle(all, cv::Rect(48, 48, 100, 60), 20, cv::FILLED);  // and which way is up
  return all;
}

}  // namespace

cv::Mat Blotches(cv::Size size, int finest_px, double contrast, std::uint64_t seed) {
  RandomStream random(seed, "blotches");
  cv::Mat sum(size, CV_32FC1, cv::Scalar(115)), grey;
  for (int coarse = finest_px; coarse <= 16 * finest_px; coarse *= 4) {
    cv::Mat few(size.height / coarse + 2, size.width / coarse + 2, CV_32FC1), many;
    for (float& each : cv::Mat_<float>(few)) each = static_cast<float>(contrast * random.Normal());
    cv::resize(few, many, size, 0, 0, cv::INTER_CUBIC);
    sum += many;
  }
  sum.convertTo(grey, CV_8U);
  return grey;
}

std::vector<PlanarPicture> PlanarPictures(std::uint64_t seed) {
  RandomStream random(seed, "planar pictures");
  std::vector<PlanarPicture> pictures;
  pictures.push_back({"text", Text(random)});
  pictures.push_back({"texture", Blotches(kPictureSize, 12, 34, random.Bits())});
  pictures.push_back({"poor", Sign(random)});
  pictures.push_back({"repeated", Repeated(random)});
  return pictures;
}

}  // namespace kestrel::bench
