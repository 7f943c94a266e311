// SPDX-License-Identifier: Apache-2.0
#include "vision/camera/file/opencv.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <optional>

#include "vision/camera/file/camera_forms.h"
#include "vision/camera/file/model_words.h"

namespace kestrel::vision {
namespace {

const Keys kFocal{"fx_px", "fy_px", "cx_px", "cy_px"};

// What the two are called together.
struct CalibrationKeys {
  std::string matrix, distortion;
};

const std::vector<CalibrationKeys>& CalibrationNames() {
  static const std::vector<CalibrationKeys> kNames{{"camera_matrix", "distortion_coefficients"},
                                                   {"camera_matrix", "dist_coeffs"},
                                                   {"camera_matrix", "dist_coeff"},
                                                   {"Camera_Matrix", "Distortion_Coefficients"},
                                                   {"cameraMatrix", "distCoeffs"},
                                                   {"cameraMatrix", "distortionCoefficients"},
                                                   {"cameraMatrix", "dist_coeffs"},
                                                   {"cameraMatrix", "D"},
                                                   {"CameraMatrix", "DistCoeffs"},
                                                   {"K", "D"},
                                                   {"k", "d"},
                                                   {"K", "distCoeffs"},
                                                   {"K", "dist"},
                                                   {"mtx", "dist"},
                                                   {"M", "D"}};
  return kNames;
}

std::vector<CalibrationKeys> CalibrationsOf(const ConfigNode& root) {
  const auto both = [&](const CalibrationKeys& keys) {
    return Find(root, keys.matrix) && Find(root, keys.distortion);
  };
  static const std::vector<std::pair<Keys, bool>> kSides{
      {{"1", "2"}, true},          {{"L", "R"}, true},        {{"_l", "_r"}, true},
      {{"_left", "_right"}, true}, {{"Left", "Right"}, true}, {{"left_", "right_"}, false}};
  for (const CalibrationKeys& name : CalibrationNames()) {
    if (both(name)) return {name};
    for (const auto& [sides, behind] : kSides) {
      std::vector<CalibrationKeys> pair;
      for (const std::string& side : sides) {
        const CalibrationKeys keys = behind ? CalibrationKeys{name.matrix + side, name.distortion + side}
                                            : CalibrationKeys{side + name.matrix, side + name.distortion};
        if (both(keys)) pair.push_back(keys);
      }
      if (!pair.empty()) return pair;
    }
  }
  if (Find(root, "camera_matrix")) return {CalibrationNames().front()};
  return {};
}

void SetMatrix(const ConfigNode& matrix, const std::string& key, bool with_skew, Sheet& sheet) {
  const Nodes K = ElementsOf(matrix);
  if (K.size() != 9)
    return sheet.Wrong(matrix.where, key, "is not a matrix of 3 rows and 3 columns with 9 numbers in data");
  sheet.SetAll({K[0], K[4], K[2], K[5]}, kFocal);
  if (with_skew) sheet.Set("skew_px", *K[1]);
  for (const std::size_t i : {1, 3, 6, 7, 8}) {
    if ((i == 1 && with_skew) || IsNumber(*K[i], i == 8)) continue;
    return sheet.Wrong(K[i]->where, fmt::format("{}.data.{}", key, i),
                       fmt::format("{} is not valid", Shown(*K[i])),
                       fmt::format("valid: {}", i == 8 ? 1 : 0));
  }
}

}  // namespace

void SetOpenCvDistortion(const ConfigNode& list, const std::string& key, Sheet& sheet) {
  static const Keys kNames{"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"};
  const Nodes numbers = ElementsOf(list);
  const std::size_t count = numbers.size();
  if (count != 4 && count != 5 && count != 8 && count != 12 && count != 14)
    return sheet.Wrong(list.where, key, fmt::format("{} numbers are not valid", count),
                       "valid: 4, 5 or 8: k1, k2, p1, p2, k3, k4, k5, k6");
  const auto some = [&](std::size_t from) {
    return std::find_if(numbers.begin() + static_cast<std::ptrdiff_t>(std::min(from, count)), numbers.end(),
                        [](const ConfigNode* each) { return !IsNumber(*each, 0); });
  };
  if (const auto beyond = some(kNames.size()); beyond != numbers.end())
    return sheet.Wrong(
        (*beyond)->where, fmt::format("{}.data.{}", key, beyond - numbers.begin()),
        fmt::format("{} belongs to OpenCV's thin prism or tilted model, which is not known here",
                    Shown(**beyond)),
        fmt::format("valid: 0, or a calibration with {} alone", fmt::join(kNames, ", ")));
  const bool rational = some(5) != numbers.end();
  sheet.SetText("model", rational ? "rational" : "brown_conrady", list.where);
  const std::size_t used = rational ? 8 : std::min<std::size_t>(count, 5);
  sheet.SetAll(numbers, Keys(kNames.begin(), kNames.begin() + static_cast<std::ptrdiff_t>(used)));
}

Keys OpenCvCameras(const ConfigNode& root) { return NumberedCameras(CalibrationsOf(root).size()); }

void FromOpenCv(const ConfigNode& root, std::size_t index, Sheet& sheet) {
  const CalibrationKeys keys = CalibrationsOf(root)[index];
  const ConfigNode& matrix = *Find(root, keys.matrix);
  const ConfigNode* distortion = Find(root, keys.distortion);
  const std::optional<OpenCvModel> model =
      OpenCvModelOf(root, distortion ? ElementsOf(*distortion).size() : 0, sheet);
  if (!model) return;
  const bool omnidir = *model == OpenCvModel::kOmnidir;
  SetMatrix(matrix, keys.matrix, omnidir, sheet);
  if (!distortion) return sheet.Wrong(root.where, keys.distortion, "must be given");
  if (*model == OpenCvModel::kCalibrateCamera) {
    SetOpenCvDistortion(*distortion, keys.distortion, sheet);
  } else {
    sheet.SetText("model", omnidir ? "unified" : "kannala_brandt", root.where);
    sheet.SetList(root, keys.distortion,
                  omnidir ? Keys{"k1", "k2", "p1", "p2"} : Keys{"k1", "k2", "k3", "k4"});
  }
  if (omnidir) sheet.SetList(root, "xi", {"xi"});

  sheet.SetSize(FindAny(root, {"image_width", "image_Width", "width"}),
                FindAny(root, {"image_height", "image_Height", "height"}));
  for (const char* size : {"imageSize", "image_size"})
    if (Find(root, size)) sheet.SetList(root, size, {"width_px", "height_px"});
}

}  // namespace kestrel::vision
