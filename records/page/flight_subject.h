// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "geometry/pose.h"
#include "vision/camera/camera_model.h"

namespace kestrel::records {

// A key of the scenario that may be changed while it is flown.
struct ChangeableKey {
  std::string key, meaning;
  std::string value;                 // JSON
  std::optional<double> min, max;    // of a number, or of each of a list of numbers
  std::vector<std::string> choices;  // JSON each; none: any that is valid
};

// What a page of a flight tells of it and its telemetry does not hold, known before it begins. page.json of its
// folder, so that the page can be written long after and where scenarios, models and pads are others.
struct FlightSubject {
  struct Camera {
    std::string name, projection;  // a name in models/cameras or a file; which of the models it is
    int width_px = 0, height_px = 0;
    double h_deg = 0, v_deg = 0;  // how much it sees across its middle row and column
    Pose X;                       // X_BC; of a camera on the ground X_TC, with its head at rest
  };
  struct Pad {
    Eigen::Vector2d size_m = Eigen::Vector2d::Zero();  // along x and y of T
    std::optional<Pose> X_NT;                          // at the beginning; none: nobody knows
    std::string picture;                               // a data URL; empty: none
  };
  std::string scenario;       // its name
  std::string mode;           // records/telemetry/flight_mode.h
  std::string mission;        // of MissionType
  std::string title, wanted;  // the page's heading; in a sentence or two, what the flight is for
  std::string again;          // the command that flies it again; empty: none does
  std::string version;
  std::uint64_t seed = 0;
  double rate_hz = 0;  // of the video
  std::optional<Camera> camera, ground_camera;
  std::optional<Pad> pad;
  std::vector<ChangeableKey> changeable;  // while it is flown; not in page.json
};

FlightSubject::Camera CameraOf(const std::string& name, const vision::CameraModel& camera, const Pose& X);

// A picture, CV_8UC1 or CV_8UC3, as a data URL of a page, made smaller where it is large; empty: there is none.
std::string PictureOf(const cv::Mat& picture);

// page.json. Throws std::runtime_error with the file and the reason; Read: also of what is no such file.
void WriteSubject(const std::filesystem::path& folder, const FlightSubject& subject);
FlightSubject ReadSubject(const std::filesystem::path& folder);

}  // namespace kestrel::records
