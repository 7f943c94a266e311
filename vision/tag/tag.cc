// SPDX-License-Identifier: Apache-2.0
#include "vision/tag/tag.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>

#include "vision/tag/tag_family.h"

namespace kestrel::vision {
namespace {

constexpr int kMinPicture_px = 256, kMaxPicture_px = 4096;
constexpr double kCell_px = 8;

double CellOf(const Tag& tag, const TagFamily& family) { return tag.side_m / family.border_cells; }

// The square that a tag's picture takes, all its cells, as a half side.
double HalfOf(const Tag& tag, const TagFamily& family) {
  return CellOf(tag, family) * family.total_cells / 2;
}

// The share of each pixel along one side of the picture that lies between two places, in pixels.
float Covered(int pixel, double low, double high) {
  return static_cast<float>(std::clamp(std::min(high, pixel + 1.0) - std::max(low, double(pixel)), 0.0, 1.0));
}

// A picture of how black each pixel is, 0 to 1, in which x of T points up and y to the right.
struct Canvas {
  cv::Mat black;  // CV_32FC1
  Eigen::Vector2d size_m;

  // shade(old value, share of the pixel that is covered)
  template <class Shade>
  void Fill(const Eigen::Vector2d& low_m, const Eigen::Vector2d& high_m, Shade shade) {
    const double rows_per_m = black.rows / size_m.x(), cols_per_m = black.cols / size_m.y();
    const double top = (size_m.x() / 2 - high_m.x()) * rows_per_m,
                 bottom = (size_m.x() / 2 - low_m.x()) * rows_per_m,
                 left = (low_m.y() + size_m.y() / 2) * cols_per_m,
                 right = (high_m.y() + size_m.y() / 2) * cols_per_m;
    for (int row = std::max(0, static_cast<int>(top)); row < std::min<double>(black.rows, bottom); ++row) {
      for (int col = std::max(0, static_cast<int>(left)); col < std::min<double>(black.cols, right); ++col) {
        float& pixel = black.at<float>(row, col);
        pixel = shade(pixel, Covered(row, top, bottom) * Covered(col, left, right));
      }
    }
  }
};

// The lower and the higher corner in T of a cell.
std::array<Eigen::Vector2d, 2> CellAt(const Tag& tag, const TagFamily& family, int row, int col) {
  const double cell = CellOf(tag, family), half = HalfOf(tag, family);
  const Eigen::Vector2d low = tag.at_m + Eigen::Vector2d(half - (row + 1) * cell, col * cell - half);
  return {low, low + Eigen::Vector2d(cell, cell)};
}

// Whether the whole square of one lies over a cell of another that is read.
bool Hides(const Tag& small, const TagFamily& of_small, const Tag& large, const TagFamily& of_large) {
  const double half = HalfOf(small, of_small);
  const cv::Mat cells = CellsOfTag(of_large, large.id);
  for (int row = 0; row < cells.rows; ++row) {
    for (int col = 0; col < cells.cols; ++col) {
      if (cells.at<std::uint8_t>(row, col) == kHoleCell) continue;
      const auto [low, high] = CellAt(large, of_large, row, col);
      const double slack = 0.01 * CellOf(large, of_large);
      const auto apart = [&](int axis) {
        return small.at_m[axis] + half <= low[axis] + slack || small.at_m[axis] - half >= high[axis] - slack;
      };
      if (!apart(0) && !apart(1)) return true;
    }
  }
  return false;
}

// Some of ArUco's first dictionary do.
bool LooksAlikeTurned(const TagFamily& family, int id) {
  const cv::Mat cells = CellsOfTag(family, id);
  for (const int how : {cv::ROTATE_90_CLOCKWISE, cv::ROTATE_180}) {
    cv::Mat turned;
    cv::rotate(cells, turned, how);
    if (cv::norm(turned, cells, cv::NORM_INF) == 0) return true;
  }
  return false;
}

}  // namespace

void Fields(FieldVisitor& v, Tag& tag) {
  v({"family", "family of AprilTag, or dictionary of ArUco"}, tag.family, TagFamilyNames());
  v({"id", "number of the tag in its family"}, tag.id, 0, 100000);
  v({"side_m",
     "side of the square whose corners are detected: of the black one of tag36h11 and ArUco, of the light "
     "one "
     "within the dark frame of tagStandard and tagCustom"},
    tag.side_m, 0.005, 20.0);
  v({"at_m", "centre of the tag along x (up in the picture) and y (right in it) from the pad's centre"},
    tag.at_m, -10.0, 10.0);
}

std::array<Eigen::Vector2d, 4> CornersOf(const Tag& tag) {
  const double h = tag.side_m / 2;
  const auto at = [&](double x, double y) { return Eigen::Vector2d(tag.at_m + Eigen::Vector2d(x, y)); };
  return {at(h, -h), at(h, h), at(-h, h), at(-h, -h)};
}

void CheckTags(const std::vector<Tag>& tags, const Eigen::Vector2d& size_m, const Place& where,
               const std::string& key, Mistakes& mistakes) {
  const std::vector<std::string> names = TagFamilyNames();
  if (names.empty())
    return mistakes.Add(where, key, "are there, and this build has no AprilTag",
                        "valid: texture, or build anew with Debian's libapriltag-dev");
  std::vector<TagFamily> families;
  for (std::size_t i = 0; i < tags.size(); ++i) {
    const Tag& tag = tags[i];
    if (std::find(names.begin(), names.end(), tag.family) == names.end()) return;  // it was refused by Fields
    const TagFamily& family = families.emplace_back(TagFamilyOf(tag.family));
    const std::string name = fmt::format("{}[{}]", key, i);
    if (tag.id >= family.count) {
      mistakes.Add(where, name + ".id", fmt::format("{} is not in the family {}", tag.id, tag.family),
                   fmt::format("valid: 0 to {}", family.count - 1));
      return;
    }
    if (LooksAlikeTurned(family, tag.id))
      mistakes.Add(where, name + ".id",
                   fmt::format("{} of {} looks the same when it is turned", tag.id, tag.family),
                   "valid: another id");
    const double half = HalfOf(tag, family);
    const Eigen::Vector2d over =
        (tag.at_m.cwiseAbs() - size_m / 2).array() + half - 1e-6 * Eigen::Array2d::Ones();
    if (over.maxCoeff() > 0)
      mistakes.Add(
          where, name,
          fmt::format("takes {:.3g} x {:.3g} m with the cells around its square, and reaches {:.3g} m "
                      "beyond the picture",
                      2 * half, 2 * half, over.maxCoeff()),
          "valid: a smaller side_m, another at_m or a larger size_m");
    for (std::size_t other = 0; other < i; ++other) {
      if (tags[other].family == tag.family && tags[other].id == tag.id)
        mistakes.Add(where, name, fmt::format("is {} {} as {}[{}] is", tag.family, tag.id, key, other),
                     "valid: another id, for one could not be told from the other");
      const bool smaller = half <= HalfOf(tags[other], families[other]);
      const std::size_t small = smaller ? i : other, large = smaller ? other : i;
      if (Hides(tags[small], families[small], tags[large], families[large]))
        mistakes.Add(
            where, fmt::format("{}[{}]", key, small),
            fmt::format("hides a part of {}[{}] that is read", key, large),
            "valid: beside it, or in the hole in the middle of a tagCustom48h12, a fifth of its whole "
            "picture wide");
    }
  }
}

cv::Mat DrawTags(const std::vector<Tag>& tags, const Eigen::Vector2d& size_m) {
  std::vector<TagFamily> families;
  double finest = size_m.minCoeff();
  for (const Tag& tag : tags)
    finest = std::min(finest, CellOf(tag, families.emplace_back(TagFamilyOf(tag.family))));
  const auto side_px = [&](double side_m) {
    const double wanted =
        std::clamp(kCell_px * side_m / finest, double{kMinPicture_px}, double{kMaxPicture_px});
    return static_cast<int>(std::bit_ceil(static_cast<unsigned>(std::lround(wanted))));
  };
  Canvas canvas{cv::Mat(side_px(size_m.x()), side_px(size_m.y()), CV_32FC1, cv::Scalar(0)), size_m};
  std::vector<std::size_t> order(tags.size());
  std::iota(order.begin(), order.end(), 0);
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
    return HalfOf(tags[a], families[a]) > HalfOf(tags[b], families[b]);
  });
  for (const std::size_t i : order) {
    const Eigen::Vector2d half = Eigen::Vector2d::Constant(HalfOf(tags[i], families[i]));
    canvas.Fill(tags[i].at_m - half, tags[i].at_m + half,
                [](float old, float covered) { return old * (1 - covered); });
    const cv::Mat cells = CellsOfTag(families[i], tags[i].id);
    for (int row = 0; row < cells.rows; ++row) {
      for (int col = 0; col < cells.cols; ++col) {
        if (cells.at<std::uint8_t>(row, col) != kBlackCell) continue;
        const auto [low, high] = CellAt(tags[i], families[i], row, col);
        canvas.Fill(low, high, [](float old, float covered) { return std::min(1.0F, old + covered); });
      }
    }
  }
  cv::Mat grey;
  canvas.black.convertTo(grey, CV_8U, -255, 255);
  return grey;
}

}  // namespace kestrel::vision
