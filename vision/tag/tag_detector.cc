// SPDX-License-Identifier: Apache-2.0
#include "vision/tag/tag_detector.h"

#ifndef KESTREL_WITHOUT_APRILTAG
#include <apriltag/apriltag.h>
#endif

#include <algorithm>
#include <map>
#include <string>

#include "vision/tag/tag_family.h"

namespace kestrel::vision {

#ifdef KESTREL_WITHOUT_APRILTAG

struct TagDetector::Library {};
TagDetector::TagDetector(const std::vector<Tag>&) {}  // tags were refused
std::vector<DetectedTag> TagDetector::Detect(const cv::Mat&) const { return {}; }

#else

namespace {

constexpr int kMostWrongBits = 2;  // of a code, that the library mends

// What the library reads a family from, with the codes of some tags alone.
struct SomeOfFamily {
  std::vector<std::size_t> indices;  // of the tags, in the order of the codes
  std::vector<std::uint64_t> codes;
  std::vector<std::uint32_t> bit_x, bit_y;
  std::string name;
  apriltag_family_t family{};
};

}  // namespace

struct TagDetector::Library {
  Library() : detector(apriltag_detector_create()) {}
  ~Library() { apriltag_detector_destroy(detector); }
  Library(const Library&) = delete;
  Library& operator=(const Library&) = delete;

  apriltag_detector_t* detector;
  std::map<std::string, SomeOfFamily> families;  // where they are they stay
};

TagDetector::TagDetector(const std::vector<Tag>& tags) : library_(std::make_unique<Library>()) {
  library_->detector->nthreads = 1;
  library_->detector->quad_decimate = 1;
  for (std::size_t i = 0; i < tags.size(); ++i) {
    SomeOfFamily& some = library_->families[tags[i].family];
    some.indices.push_back(i);
    some.codes.push_back(TagCodeOf(TagFamilyOf(tags[i].family), tags[i].id));
  }
  for (auto& [name, some] : library_->families) {
    const TagFamily family = TagFamilyOf(name);
    some.name = name;
    for (const cv::Point& bit : family.bits) {
      some.bit_x.push_back(static_cast<std::uint32_t>(bit.x));
      some.bit_y.push_back(static_cast<std::uint32_t>(bit.y));
    }
    some.family.ncodes = static_cast<std::uint32_t>(some.codes.size());
    some.family.codes = some.codes.data();
    some.family.width_at_border = family.border_cells;
    some.family.total_width = family.total_cells;
    some.family.reversed_border = family.reversed;
    some.family.nbits = static_cast<std::uint32_t>(some.bit_x.size());
    some.family.bit_x = some.bit_x.data();
    some.family.bit_y = some.bit_y.data();
    some.family.h = static_cast<std::uint32_t>(family.distance);
    some.family.name = some.name.data();
    apriltag_detector_add_family_bits(library_->detector, &some.family,
                                      std::clamp((family.distance - 1) / 2, 0, kMostWrongBits));
  }
}

std::vector<DetectedTag> TagDetector::Detect(const cv::Mat& grey) const {
  image_u8_t image{.width = grey.cols,
                   .height = grey.rows,
                   .stride = static_cast<int>(grey.step[0]),
                   .buf = const_cast<std::uint8_t*>(grey.data)};  // which the library only reads
  zarray_t* const found = apriltag_detector_detect(library_->detector, &image);
  std::vector<DetectedTag> tags;
  for (int i = 0; i < zarray_size(found); ++i) {
    apriltag_detection_t* one = nullptr;
    zarray_get(found, i, static_cast<void*>(&one));
    const SomeOfFamily& some = library_->families.at(one->family->name);
    DetectedTag tag{.index = some.indices[static_cast<std::size_t>(one->id)],
                    .corners = {},
                    .margin = one->decision_margin};
    // The library's corners begin at the lower left and go on to the lower right; its first pixel's centre is at
    // (0.5, 0.5).
    for (std::size_t k = 0; k < 4; ++k) tag.corners[k] = {one->p[3 - k][0] - 0.5, one->p[3 - k][1] - 0.5};
    tags.push_back(tag);
  }
  apriltag_detections_destroy(found);
  // In an order of its own, whatever the library's.
  std::sort(tags.begin(), tags.end(), [](const DetectedTag& a, const DetectedTag& b) {
    return std::tuple(a.index, a.corners[0].x(), a.corners[0].y()) <
           std::tuple(b.index, b.corners[0].x(), b.corners[0].y());
  });
  return tags;
}

#endif

TagDetector::~TagDetector() = default;
TagDetector::TagDetector(TagDetector&&) noexcept = default;
TagDetector& TagDetector::operator=(TagDetector&&) noexcept = default;

}  // namespace kestrel::vision
