// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/yaml/config.h"
#include "geometry/pose.h"
#include "vision/camera/camera_model.h"

namespace kestrel::vision {

// A camera from a file, whatever wrote it, told by its content: this project (the key `model`, default
// pinhole, and the keys that the model's Fields say), or a program of vision/camera/file/camera_forms.h:
// Kalibr, OpenCV, ROS, Basalt, VINS, ORB-SLAM, OKVIS, SVO, maplab and EuRoC. A model that is not known is refused,
// and so are four coefficients of which nothing says whether they are those of cv::calibrateCamera or of
// cv::fisheye. Mistakes have the file's own line and the name of the parameter; with any, the camera is not
// to be used.
//
// name: which camera of a file that has several, by its key in a camchain and otherwise cam0, cam1, ... in
// the order of the file; the first when empty. image: the size of the images that it is for: a file that
// gives another is refused, and one that gives none (as OpenCV's omnidir does) is completed; without image, a
// file must give it.
CameraModel LoadCamera(const std::filesystem::path& file, Mistakes& mistakes, const std::string& name = "",
                       const std::optional<cv::Size>& image = {});
CameraModel ParseCamera(const Config& config, Mistakes& mistakes, const std::string& name = "",
                        const std::optional<cv::Size>& image = {});

// X_IC, I being the axes of the camera's IMU, by a file that says it: T_cam_imu of Kalibr, T_imu_cam, T_B_C of
// SVO and maplab, T_SC of OKVIS, Tbc of ORB-SLAM, T_BS of EuRoC. None: it does not, or the camera is not read. How the IMU
// stands on the aircraft no such file says.
std::optional<Pose> LoadPoseOnImu(const std::filesystem::path& file, Mistakes& mistakes,
                                  const std::string& name = "");

// The cameras of the file of another program, the first first; of this project's none.
std::vector<std::string> CameraNames(const Config& config);

// The same camera as a file of this project, and as Kalibr's cam0. Numbers read back to the same bits,
// field_deg to the last one or two. Throws InputError for what Kalibr's models cannot say: k3 or a skew.
std::string ToCameraYaml(const CameraModel& camera);
std::string ToKalibr(const CameraModel& camera);

}  // namespace kestrel::vision
