// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "base/file/files.h"
#include "records/plot/plot_rows.h"
#include "records/plot/plots.h"
#include "records/telemetry/flight_log.h"
#include "records/video/video.h"

namespace kestrel::records {

struct TelemetryOptions {
  bool truth = true;    // is known; otherwise its columns are empty
  bool safety = false;  // of a real aircraft: further columns of what its safety layer did
  const mission::MissionType* mission = nullptr;  // whose own columns are written too; null: none
};

struct RecorderOptions {
  bool video = true;
  double rate_hz = 30;  // of the video
  PlotOptions plots = {};
  TelemetryOptions telemetry = {};  // without truth there is one plot (flown_plot.h)
  int video_kbit_s = 800;  // at most: the page of a minute, with all that it holds, has less than 12 MB then
};

// Writes the folder of a run: telemetry.csv, video.mp4, plots/ and, last, summary.json. A file has its final
// name only once it is complete; until then, and for good where writing failed, it has ".part" behind it.
// What an earlier run left under these names is removed first.
//
// telemetry.csv has a line for each frame, an empty cell where there is no value. truth and estimate are in N
// when the decision was made (t_s); fix is in the pad's frame at the exposure (exposure_t_s), and target is
// the truth of it, what a perfect fix reads; the velocity of a setpoint is in the heading frame, its position
// in N. Of a real aircraft setpoint is what the mission asked for; safe_... is what the safety layer made of
// it and what was sent, but in a dry run; safety_hazard and safety_reaction say why
// (control/safety/safety.h). Times of the processor are not in it: the same run gives the same file.
class Recorder {
 public:
  // Throws std::runtime_error, here and in Write, with the file and the reason.
  Recorder(std::filesystem::path folder, RecorderOptions options);

  void Write(const LogRow& row);
  bool wants_images() const { return video_.has_value(); }
  void WriteImage(const cv::Mat& bgr);  // the next frame of the video, as drawn; nothing without video
  // The same of the video that the mission's type names; nothing of an empty image.
  void WriteProduct(const cv::Mat& bgr);

  // Ends all files, those of a run that broke off as far as they go. What fails here makes the run one that
  // broke off. Returns what summary.json then says; throws std::runtime_error only if that cannot be written.
  Summary Finish(Summary summary);

 private:
  std::filesystem::path folder_;
  RecorderOptions options_;
  std::optional<PartFile> telemetry_;
  std::optional<Video> video_, product_;
  PlotRows plotted_;
};

// The first line of telemetry.csv and a line of it, without their ends.
std::string TelemetryHeader(const TelemetryOptions& options = {});
std::string TelemetryLine(const LogRow& row, const TelemetryOptions& options = {});

}  // namespace kestrel::records
