// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "vision/image_file.h"

namespace kestrel::vision {

// One camera's images of a recording, whatever wrote it.
struct RecordedImages {
  // Reads the image of an index below size(). What cannot be read has its error.
  using Reader = std::function<ImageFile(std::size_t, ImageColours)>;

  std::vector<std::string> names;       // what to call each: its file, or its message
  std::vector<std::int64_t> stamps_ns;  // of the recording's own clock, going up; empty: it has none
  std::vector<std::int64_t> logged_ns;  // when each was logged, of an MCAP; empty: that is not known
  std::function<Reader()> reader;       // one for each thread
  std::string topic;                    // which camera of several it is; empty: there is but one
  std::filesystem::path calibration;    // of this camera, in the recording; empty: it has none
  std::string calibration_text;         // the same, of a recording in one file
  std::filesystem::path gyro;           // of the same clock, in the recording; empty: it has none
  std::string note;                     // what is to be told: a cut file's rest; empty: nothing

  std::size_t size() const { return names.size(); }
  bool stamped() const { return !stamps_ns.empty(); }
  // Since the first image: exact to the nanosecond for recordings of up to a hundred days.
  double Time_s(std::size_t index) const;
  double Rate_hz() const;  // in the mean, of two stamped images or more; otherwise 0
};

// The images of
//   a folder of EuRoC (with mav0/, mav0 itself, or one of its cameras with data.csv and data/);
//   a sequence of TUM (with rgb.txt) or KITTI (with times.txt, or an image folder beside it);
//   an MCAP file of ROS 2 (mcap_images.h);
//   a folder of image files whose names are stamps (StampOfName);
//   a folder of images, or those whose names a pattern with one number matches ("image%04d.png"), or one alone,
//   by name, numbers in the names by their value: without stamps.
// topic: which camera of several, by its folder ("cam1", "image_2") or its topic. Empty: the only one, cam0 of EuRoC.
//
// Every mistake of a table is one, with its line: a row of the wrong shape, a stamp that repeats or goes back,
// an image that is not there. With any, there are no images.
// The reader may throw std::runtime_error where a file has gone since.
RecordedImages OpenRecordedImages(const std::filesystem::path& recording, const std::string& topic,
                                  Mistakes& mistakes);

// Whether it is a folder or an MCAP: neither a video nor an image.
bool IsRecording(const std::filesystem::path& file);

}  // namespace kestrel::vision
