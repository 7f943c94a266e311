// SPDX-License-Identifier: Apache-2.0
#include "vision/camera/file/model_words.h"

#include <fmt/format.h>

#include <cctype>

namespace kestrel::vision {
namespace {

const char* NameOf(OpenCvModel model) {
  switch (model) {
    case OpenCvModel::kCalibrateCamera:
      return "brown_conrady";
    case OpenCvModel::kFisheye:
      return "kannala_brandt";
    case OpenCvModel::kOmnidir:
      break;
  }
  return "unified";
}

// The words that OpenCV, ROS, Kalibr, MRPT and their users write for a model.
const std::vector<ModelWord>& ModelWords() {
  using enum OpenCvModel;
  static const std::vector<ModelWord> kWords{{"plumb_bob", kCalibrateCamera},
                                             {"rational_polynomial", kCalibrateCamera},
                                             {"radtan", kCalibrateCamera},
                                             {"brown_conrady", kCalibrateCamera},
                                             {"radial_tangential", kCalibrateCamera},
                                             {"equidistant", kFisheye},
                                             {"equi", kFisheye},
                                             {"fisheye", kFisheye},
                                             {"kannala_brandt", kFisheye},
                                             {"omnidir", kOmnidir},
                                             {"omni", kOmnidir},
                                             {"mei", kOmnidir},
                                             {"unified", kOmnidir},
                                             {"pinhole", {}},
                                             {"perspective", {}}};
  return kWords;
}

}  // namespace

const ModelWord* FindModelWord(std::string_view written) {
  const auto letters = [](std::string_view text) {
    std::string kept;
    for (const unsigned char c : text)
      if (std::isalnum(c)) kept += static_cast<char>(std::tolower(c));
    return kept;
  };
  for (const ModelWord& each : ModelWords())
    if (letters(each.word) == letters(written)) return &each;
  return nullptr;
}

Keys AllModelWords() {
  Keys all;
  for (const ModelWord& each : ModelWords()) all.push_back(each.word);
  return all;
}

std::optional<OpenCvModel> OpenCvModelOf(const ConfigNode& root, std::size_t coefficients, Sheet& sheet) {
  struct Claim {
    const char* key;
    const ConfigNode* node;
    OpenCvModel model;
  };
  std::vector<Claim> claims;
  bool wrong = false;
  const auto refuse = [&](const Place& where, const char* key, const std::string& what,
                          const std::string& remedy = {}) {
    sheet.Wrong(where, key, what, remedy);
    wrong = true;
  };

  for (const char* key : {"distortion_model", "camera_model", "model_type", "model"}) {
    const ConfigNode* node = Find(root, key);
    if (!node) continue;
    const ModelWord* word = FindModelWord(node->text);
    if (word && word->model) claims.push_back({key, node, *word->model});
    if (word) continue;
    sheet.Unknown(*node, key, AllModelWords());
    wrong = true;
  }
  const ConfigNode* xi = Find(root, "xi");
  if (xi) claims.push_back({"xi", xi, OpenCvModel::kOmnidir});
  if (const ConfigNode* flag = Find(root, "fisheye_model")) {
    const bool yes = IsNumber(*flag, 1) || flag->text == "true",
               no = IsNumber(*flag, 0) || flag->text == "false";
    if (yes) claims.push_back({"fisheye_model", flag, OpenCvModel::kFisheye});
    if (no && !xi) claims.push_back({"fisheye_model", flag, OpenCvModel::kCalibrateCamera});
    if (!yes && !no)
      refuse(flag->where, "fisheye_model", fmt::format("'{}' is not valid", flag->text), "valid: 0, 1");
  }

  for (const Claim& claim : claims) {
    if (claim.model == claims.front().model) continue;
    refuse(claim.node->where, claim.key,
           fmt::format("'{}' is of the model {}, but {} is of {}", claim.node->text, NameOf(claim.model),
                       claims.front().key, NameOf(claims.front().model)),
           "valid: keys that agree");
  }
  if (wrong) return {};
  if (claims.empty() && coefficients == 4) {
    refuse(root.where, "distortion_model",
           "must be given: four distortion coefficients are k1, k2, p1, p2 of cv::calibrateCamera "
           "(distortion_model: plumb_bob) or k1 to k4 of cv::fisheye (distortion_model: equidistant)");
    return {};
  }
  if (claims.empty()) return OpenCvModel::kCalibrateCamera;
  if (claims.front().model == OpenCvModel::kOmnidir && !xi) {
    refuse(root.where, "xi",
           fmt::format("must be given, since {} is '{}'", claims.front().key, claims.front().node->text));
    return {};
  }
  return claims.front().model;
}

}  // namespace kestrel::vision
