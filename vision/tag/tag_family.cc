// SPDX-License-Identifier: Apache-2.0
#include "vision/tag/tag_family.h"

#ifndef KESTREL_WITHOUT_APRILTAG
#include <apriltag/tag16h5.h>
#include <apriltag/tag25h9.h>
#include <apriltag/tag36h10.h>
#include <apriltag/tag36h11.h>
#include <apriltag/tagCircle21h7.h>
#include <apriltag/tagCircle49h12.h>
#include <apriltag/tagCustom48h12.h>
#include <apriltag/tagStandard41h12.h>
#include <apriltag/tagStandard52h13.h>
#endif

#include <algorithm>
#include <array>
#include <map>
#include <memory>
#include <mutex>
#include <opencv2/core/version.hpp>
#include <opencv2/imgproc.hpp>
#if CV_VERSION_MAJOR > 4 || CV_VERSION_MINOR >= 7
#include <opencv2/objdetect/aruco_dictionary.hpp>
#else
#include <opencv2/aruco/dictionary.hpp>
#endif

namespace kestrel::vision {

#ifdef KESTREL_WITHOUT_APRILTAG

std::vector<std::string> TagFamilyNames() { return {}; }
TagFamily TagFamilyOf(const std::string&) { return {}; }
std::uint64_t TagCodeOf(const TagFamily&, int) { return 0; }
cv::Mat CellsOfTag(const TagFamily&, int) { return {}; }

#else

namespace {

struct OfAprilTag {
  const char* name;
  apriltag_family_t* (*create)();
  void (*destroy)(apriltag_family_t*);
};
constexpr std::array kOfAprilTag = {
    OfAprilTag{"tag36h11", tag36h11_create, tag36h11_destroy},
    OfAprilTag{"tag36h10", tag36h10_create, tag36h10_destroy},
    OfAprilTag{"tag25h9", tag25h9_create, tag25h9_destroy},
    OfAprilTag{"tag16h5", tag16h5_create, tag16h5_destroy},
    OfAprilTag{"tagStandard41h12", tagStandard41h12_create, tagStandard41h12_destroy},
    OfAprilTag{"tagStandard52h13", tagStandard52h13_create, tagStandard52h13_destroy},
    OfAprilTag{"tagCustom48h12", tagCustom48h12_create, tagCustom48h12_destroy},
    OfAprilTag{"tagCircle21h7", tagCircle21h7_create, tagCircle21h7_destroy},
    OfAprilTag{"tagCircle49h12", tagCircle49h12_create, tagCircle49h12_destroy}};

// In the order of OpenCV's numbers, from 0.
constexpr std::array kOfAruco = {
    "DICT_4X4_50",  "DICT_4X4_100",  "DICT_4X4_250", "DICT_4X4_1000", "DICT_5X5_50",        "DICT_5X5_100",
    "DICT_5X5_250", "DICT_5X5_1000", "DICT_6X6_50",  "DICT_6X6_100",  "DICT_6X6_250",       "DICT_6X6_1000",
    "DICT_7X7_50",  "DICT_7X7_100",  "DICT_7X7_250", "DICT_7X7_1000", "DICT_ARUCO_ORIGINAL"};

struct CodedFamily {
  TagFamily family;
  std::vector<std::uint64_t> codes;
};

CodedFamily Read(const OfAprilTag& of) {
  apriltag_family_t* const from = of.create();
  CodedFamily read;
  read.family = {.name = of.name,
                 .count = static_cast<int>(from->ncodes),
                 .total_cells = from->total_width,
                 .border_cells = from->width_at_border,
                 .reversed = from->reversed_border,
                 .distance = static_cast<int>(from->h),
                 .bits = {}};
  for (std::uint32_t i = 0; i < from->nbits; ++i)
    read.family.bits.emplace_back(static_cast<int>(from->bit_x[i]), static_cast<int>(from->bit_y[i]));
  read.codes.assign(from->codes, from->codes + from->ncodes);
  of.destroy(from);
  return read;
}

CodedFamily ReadAruco(int number) {
#if CV_VERSION_MAJOR > 4 || CV_VERSION_MINOR >= 7
  const cv::aruco::Dictionary dictionary = cv::aruco::getPredefinedDictionary(number);
#else
  const cv::aruco::Dictionary dictionary = *cv::aruco::getPredefinedDictionary(number);
#endif
  const int side = dictionary.markerSize;
  CodedFamily read;
  read.family = {.name = kOfAruco[static_cast<std::size_t>(number)],
                 .count = dictionary.bytesList.rows,
                 .total_cells = side + 4,  // the border, and white around it
                 .border_cells = side + 2,
                 .reversed = false,
                 .distance = 2 * dictionary.maxCorrectionBits + 1,
                 .bits = {}};
  for (int turn = 0; turn < 4; ++turn) {
    for (int y = 0; y < side / 2; ++y) {
      for (int x = 0; x < (side + 1) / 2; ++x) {
        cv::Point bit(x, y);
        for (int k = 0; k < turn; ++k) bit = {side - 1 - bit.y, bit.x};
        read.family.bits.push_back(bit + cv::Point(1, 1));
      }
    }
  }
  if (side % 2 == 1) read.family.bits.emplace_back(1 + side / 2, 1 + side / 2);
  for (int id = 0; id < read.family.count; ++id) {
    const cv::Mat cells = cv::aruco::Dictionary::getBitsFromByteList(dictionary.bytesList.row(id), side);
    std::uint64_t code = 0;
    for (const cv::Point& bit : read.family.bits)
      code = code << 1 | (cells.at<std::uint8_t>(bit.y - 1, bit.x - 1) != 0 ? 1 : 0);
    read.codes.push_back(code);
  }
  return read;
}

const CodedFamily& Kept(const std::string& name) {
  static std::mutex mutex;
  static std::map<std::string, CodedFamily> kept;
  const std::lock_guard lock(mutex);
  if (const auto found = kept.find(name); found != kept.end()) return found->second;
  for (const OfAprilTag& of : kOfAprilTag)
    if (name == of.name) return kept.emplace(name, Read(of)).first->second;
  const auto* const aruco = std::find(kOfAruco.begin(), kOfAruco.end(), name);
  return kept.emplace(name, ReadAruco(static_cast<int>(aruco - kOfAruco.begin()))).first->second;
}

}  // namespace

std::vector<std::string> TagFamilyNames() {
  std::vector<std::string> names;
  for (const OfAprilTag& of : kOfAprilTag) names.emplace_back(of.name);
  names.insert(names.end(), kOfAruco.begin(), kOfAruco.end());
  return names;
}

TagFamily TagFamilyOf(const std::string& name) { return Kept(name).family; }

std::uint64_t TagCodeOf(const TagFamily& family, int id) {
  return Kept(family.name).codes[static_cast<std::size_t>(id)];
}

cv::Mat CellsOfTag(const TagFamily& family, int id) {
  cv::Mat cells(family.total_cells, family.total_cells, CV_8UC1, cv::Scalar(kHoleCell));
  // The edge that is detected, with a cell of each colour beside it.
  const int around = (family.total_cells - family.border_cells) / 2;
  const auto ring = [&](int from, TagCell cell) {
    const int side = family.total_cells - 2 * from;
    cv::rectangle(cells, cv::Rect(from, from, side, side), cv::Scalar(cell), 1);
  };
  ring(around - 1, family.reversed ? kBlackCell : kWhiteCell);
  ring(around, family.reversed ? kWhiteCell : kBlackCell);
  const std::uint64_t code = TagCodeOf(family, id);
  const std::size_t count = family.bits.size();
  for (std::size_t i = 0; i < count; ++i) {
    const cv::Point at = family.bits[i] + cv::Point(around, around);
    cells.at<std::uint8_t>(at.y, at.x) = code >> (count - 1 - i) & 1 ? kWhiteCell : kBlackCell;
  }
  return cells;
}

#endif

}  // namespace kestrel::vision
