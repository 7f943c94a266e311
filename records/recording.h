// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/file/files.h"
#include "mission/mission_type.h"

// What flight code was given and what it made of it, so that it can be given the same again: the folder
// recording/ of a flight, with an image without loss for each frame (000012.png) and frames.csv. Numbers in
// it read back to the same bits.
namespace kestrel::records {

class RecordingWriter {
 public:
  // The folder recording/ is made in that of the flight; what an earlier one left there is removed. Throws
  // std::runtime_error, here and later, with the file and the reason.
  RecordingWriter(const std::filesystem::path& flight_folder, const mission::MissionType& type);
  void Write(const vision::Frame& frame, const control::VehicleState& state,
             const mission::Decision& decision);
  void Close();

 private:
  std::filesystem::path folder_;
  const mission::MissionType& type_;
  PartFile table_;
};

// own_parts.png of a flight that looks through parts of its own aircraft, for LoadPlan; none: nothing.
void WriteOwnParts(const std::filesystem::path& flight_folder, const cv::Mat& own_parts);

// What is compared: what was measured and what was asked for, as text that says each bit.
struct RecordedDecision {
  std::string phase, target, outcome;
  std::vector<std::optional<double>> numbers;  // by RecordedNumbers(), or a Recording's numbers()
};
RecordedDecision Recorded(const mission::Decision& decision, const mission::MissionType& type);
// Their names, with units: "setpoint_vx_m_s", "fix_x_m", ..., and the telemetry of the mission's own.
std::vector<std::string> RecordedNumbers(const mission::MissionType& type);

struct RecordedFrame {
  std::int64_t sequence = 0;
  double t_s = 0;
  control::VehicleState state;
  RecordedDecision decision;
};

class Recording {
 public:
  // Throws InputError with file, line and everything that is wrong.
  explicit Recording(const std::filesystem::path& flight_folder);
  const std::vector<RecordedFrame>& frames() const { return frames_; }
  // The names of its numbers; another version's may be other ones.
  const std::vector<std::string>& numbers() const { return numbers_; }
  vision::Frame At(std::size_t index) const;  // reads the image; throws InputError if it is damaged
  // The images that are not there, are no PNG, or end before their end; without decoding them.
  std::vector<std::filesystem::path> Damaged() const;

 private:
  std::filesystem::path folder_;
  std::vector<std::string> numbers_;
  std::vector<RecordedFrame> frames_;
};

}  // namespace kestrel::records
