// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>
#include <vector>

#include "base/yaml/config.h"
#include "vision/camera/camera_model.h"

namespace kestrel::vision {

// A camera from a file, whatever wrote it, told by its content:
// - this project: the key `model` (default pinhole) and the keys that the model's Fields say;
// - Kalibr: a camchain with pinhole-radtan, pinhole-equi, pinhole-none, omni-radtan, omni-none or ds-none;
// - OpenCV (FileStorage) or ROS: camera_matrix and distortion_coefficients; with xi it is an omnidir camera,
//   with `fisheye_model: 1` or a distortion_model such as equidistant a fisheye one. A distortion_model that
//   is not known is refused, and so are four coefficients of which nothing says whether they are those of
//   cv::calibrateCamera or of cv::fisheye.
// All mistakes are gathered, by the file's own line and the name of the parameter; with any, the camera is
// not to be used.
//
// name: which camera of a camchain; the first (cam0) when empty. image: the size of the images that it is
// for: a file that gives another is refused, and one that gives none (as OpenCV's omnidir does) is completed;
// without image, a file must give it.
CameraModel LoadCamera(const std::filesystem::path& file, Mistakes& mistakes, const std::string& name = "",
                       const std::optional<cv::Size>& image = {});
CameraModel ParseCamera(const Config& config, Mistakes& mistakes, const std::string& name = "",
                        const std::optional<cv::Size>& image = {});

// The cameras of a camchain of Kalibr, the first first; of any other file none.
std::vector<std::string> CameraNames(const Config& config);

// The same camera as a file of this project, and as Kalibr's cam0. Numbers read back to the same bits,
// field_deg to the last one or two. Throws InputError for what Kalibr's models cannot say: k3 or a skew.
std::string ToCameraYaml(const CameraModel& camera);
std::string ToKalibr(const CameraModel& camera);

}  // namespace kestrel::vision
