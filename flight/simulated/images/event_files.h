// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <filesystem>
#include <opencv2/core.hpp>

#include "base/file/files.h"
#include "sim/camera/event/event_camera.h"

namespace kestrel::flight {

// What an event camera gives, in a folder of its own:
//   events.txt      as the Event Camera Dataset has it (Mueggler et al., 2017): a line "t x y polarity" for each;
//                   t in s, with nine decimals, column, row, 1: brighter or 0: darker; in the order of time, and
//                   where that is the same of rows, then columns
//   N_events.png    the frame N (telemetry.csv: sequence) with the events of the 10 ms before the middle of its
//                   exposure: red where it became brighter last, blue where darker
// Throws std::runtime_error with the file and the reason.
class EventFiles {
 public:
  // Removes what an earlier run left there under these names.
  explicit EventFiles(const std::filesystem::path& folder);

  void Write(const std::vector<sim::Event>& events);  // later than those before
  // After the events until t_s.
  void WriteView(std::int64_t sequence, double t_s, const cv::Mat& frame);
  void Close();

 private:
  std::filesystem::path folder_;
  PartFile file_;
  std::deque<sim::Event> recent_;  // that a view may yet show
};

}  // namespace kestrel::flight
