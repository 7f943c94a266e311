// SPDX-License-Identifier: Apache-2.0
#include "vision/camera/calibration_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <span>
#include <string_view>

#include "base/diagnostics.h"
#include "base/user_file.h"
#include "base/yaml/fields.h"
#include "base/yaml/yaml_fields.h"

namespace kestrel::vision {
namespace {

using Kind = ConfigNode::Kind;
using Keys = std::vector<std::string>;

const ConfigNode* Find(const ConfigNode& node, std::string_view key) {
  for (const auto& [name, member] : node.members) {
    if (name == key) return &member;
  }
  return nullptr;
}

std::string TextOf(const ConfigNode& node, std::string_view key) {
  const ConfigNode* found = Find(node, key);
  return found ? found->text : "";
}

bool IsNumber(const ConfigNode& node, double expected) {
  double value = 0;
  const char* end = node.text.data() + node.text.size();
  const auto [rest, error] = std::from_chars(node.text.data(), end, value);
  return node.kind == Kind::kText && error == std::errc() && rest == end && value == expected;
}

// What a foreign file says, under this project's keys and with the lines where it was written, so that one
// reader checks all. path stands before the keys in the mistakes.
struct Sheet {
  ConfigNode node;
  std::string path;
  Mistakes& mistakes;

  void Set(const std::string& key, const ConfigNode& value) { node.members.emplace_back(key, value); }
  void SetText(const std::string& key, const std::string& text, const Place& where) {
    Set(key, {Kind::kText, text, false, where, {}});
  }
  void Wrong(const Place& where, std::string_view key, const std::string& what,
             const std::string& remedy = {}) {
    mistakes.Add(where, path.empty() ? std::string(key) : fmt::format("{}.{}", path, key), what, remedy);
  }
  // What is wrong already is not to be asked for again.
  void Excuse(const Keys& keys) {
    for (const std::string& key : keys)
      SetText(key, key == "width_px" || key == "height_px" ? "16" : "1", "");
  }
  // Each element of a list under a key of its own.
  void SetList(const ConfigNode& from, const std::string& key, const Keys& keys) {
    const ConfigNode* list = Find(from, key);
    if (!list && keys.empty()) return;
    const bool is_list = list && (list->kind == Kind::kList || list->kind == Kind::kNothing);
    if (is_list && list->members.size() == keys.size()) {
      for (std::size_t i = 0; i < keys.size(); ++i) Set(keys[i], list->members[i].node);
      return;
    }
    Excuse(keys);
    if (!list) return Wrong(from.where, key, fmt::format("must be given: {}", fmt::join(keys, ", ")));
    Wrong(
        list->where, key, fmt::format("{} numbers are not valid", list->members.size()),
        fmt::format("valid: a list of {}{}{}", keys.size(), keys.empty() ? "" : ": ", fmt::join(keys, ", ")));
  }
};

void SetImageSize(Sheet& sheet, const cv::Size& image) {
  sheet.SetText("width_px", std::to_string(image.width), sheet.node.where);
  sheet.SetText("height_px", std::to_string(image.height), sheet.node.where);
}

// Kalibr's names of a model, ours, and the order of its numbers.
struct KalibrForm {
  const char *camera_model, *distortion_model, *model;
  Keys intrinsics, distortion;
};

const std::vector<KalibrForm>& KalibrForms() {
  static const std::vector<KalibrForm> kForms = [] {
    const Keys pinhole{"fx_px", "fy_px", "cx_px", "cy_px"};
    const Keys omni{"xi", "fx_px", "fy_px", "cx_px", "cy_px"};
    const Keys spheres{"xi", "alpha", "fx_px", "fy_px", "cx_px", "cy_px"};
    const Keys radtan{"k1", "k2", "p1", "p2"}, equi{"k1", "k2", "k3", "k4"};
    return std::vector<KalibrForm>{{"pinhole", "radtan", BrownConrady::kName, pinhole, radtan},
                                   {"pinhole", "equidistant", KannalaBrandt::kName, pinhole, equi},
                                   {"pinhole", "equi", KannalaBrandt::kName, pinhole, equi},
                                   {"pinhole", "none", Pinhole::kName, pinhole, {}},
                                   {"omni", "radtan", Unified::kName, omni, radtan},
                                   {"omni", "none", Unified::kName, omni, {}},
                                   {"ds", "none", DoubleSphere::kName, spheres, {}}};
  }();
  return kForms;
}

// The cameras of a camchain, cam0 the first.
Keys CamerasOf(const ConfigNode& root) {
  Keys cameras;
  for (const auto& [key, member] : root.members) {
    if (key.starts_with("cam") && Find(member, "camera_model")) cameras.push_back(key);
  }
  std::sort(cameras.begin(), cameras.end());
  return cameras;
}

void FromKalibr(const ConfigNode& root, const std::string& name, const std::optional<cv::Size>& image,
                Sheet& sheet) {
  const Keys cameras = CamerasOf(root);
  sheet.path = name.empty() ? cameras.front() : name;
  const ConfigNode* camera = Find(root, sheet.path);
  if (!camera || std::find(cameras.begin(), cameras.end(), sheet.path) == cameras.end()) {
    return sheet.mistakes.Add(root.where, sheet.path, "there is no such camera",
                              fmt::format("valid: {}", fmt::join(cameras, ", ")));
  }
  sheet.node.where = camera->where;

  const std::string model = TextOf(*camera, "camera_model"), distortion = TextOf(*camera, "distortion_model");
  const auto& forms = KalibrForms();
  const auto form = std::find_if(forms.begin(), forms.end(), [&](const KalibrForm& each) {
    return each.camera_model == model && each.distortion_model == distortion;
  });
  if (form == forms.end()) {
    Keys valid;
    for (const auto& each : forms)
      valid.push_back(fmt::format("{}-{}", each.camera_model, each.distortion_model));
    const ConfigNode* written = Find(*camera, "camera_model");
    return sheet.Wrong(written ? written->where : camera->where, "camera_model",
                       fmt::format("'{}' with distortion_model '{}' is not known here; valid: {}", model,
                                   distortion, fmt::join(valid, ", ")));
  }
  sheet.SetText("model", form->model, camera->where);
  sheet.SetList(*camera, "intrinsics", form->intrinsics);
  sheet.SetList(*camera, "distortion_coeffs", form->distortion);
  if (image && !Find(*camera, "resolution"))
    SetImageSize(sheet, *image);
  else
    sheet.SetList(*camera, "resolution", {"width_px", "height_px"});
  if (const ConfigNode* field = Find(*camera, "field_deg")) sheet.Set("field_deg", *field);
}

bool IsOpenCv(const ConfigNode& root) { return Find(root, "camera_matrix"); }

// What the numbers of a calibration of OpenCV or ROS are those of.
enum class OpenCvModel { kBrownConrady, kFisheye, kOmnidir };

const char* NameOf(OpenCvModel model) {
  switch (model) {
    case OpenCvModel::kBrownConrady:
      return BrownConrady::kName;
    case OpenCvModel::kFisheye:
      return KannalaBrandt::kName;
    case OpenCvModel::kOmnidir:
      break;
  }
  return Unified::kName;
}

struct ModelWord {
  std::string word;
  std::optional<OpenCvModel> model;  // none: it says nothing of the distortion
};

// The words that OpenCV, ROS, Kalibr, MRPT and their users write for a model.
const std::vector<ModelWord>& ModelWords() {
  using enum OpenCvModel;
  static const std::vector<ModelWord> kWords{{"plumb_bob", kBrownConrady},
                                             {"rational_polynomial", kBrownConrady},
                                             {"radtan", kBrownConrady},
                                             {"brown_conrady", kBrownConrady},
                                             {"radial_tangential", kBrownConrady},
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

// Of a word as it is written: KannalaBrandt, kannala-brandt, KANNALA_BRANDT; null: not known.
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

// The model by every key that names one, which must agree; none: a mistake was added. A wrong guess here
// is a camera that is off by tens of pixels and looks valid, so nothing is guessed.
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
    Keys valid;
    for (const ModelWord& each : ModelWords()) valid.push_back(each.word);
    refuse(node->where, key, fmt::format("'{}' is not known", node->text),
           fmt::format("valid: {}", fmt::join(valid, ", ")));
  }
  const ConfigNode* xi = Find(root, "xi");
  if (xi) claims.push_back({"xi", xi, OpenCvModel::kOmnidir});
  if (const ConfigNode* flag = Find(root, "fisheye_model")) {
    const bool yes = IsNumber(*flag, 1) || flag->text == "true",
               no = IsNumber(*flag, 0) || flag->text == "false";
    if (yes) claims.push_back({"fisheye_model", flag, OpenCvModel::kFisheye});
    if (no && !xi) claims.push_back({"fisheye_model", flag, OpenCvModel::kBrownConrady});
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
  if (claims.empty()) return OpenCvModel::kBrownConrady;
  if (claims.front().model == OpenCvModel::kOmnidir && !xi) {
    refuse(root.where, "xi",
           fmt::format("must be given, since {} is '{}'", claims.front().key, claims.front().node->text));
    return {};
  }
  return claims.front().model;
}

void FromOpenCv(const ConfigNode& root, const std::optional<cv::Size>& image, Sheet& sheet) {
  const ConfigNode* distortion = Find(root, "distortion_coefficients");
  const ConfigNode* data = distortion ? Find(*distortion, "data") : nullptr;
  const std::size_t count = data ? data->members.size() : 0;
  const std::optional<OpenCvModel> model = OpenCvModelOf(root, count, sheet);
  if (!model) return;
  const bool fisheye = model == OpenCvModel::kFisheye;
  const ConfigNode* xi = model == OpenCvModel::kOmnidir ? Find(root, "xi") : nullptr;

  const ConfigNode& matrix = *Find(root, "camera_matrix");
  const ConfigNode* K = Find(matrix, "data");
  if (!K || K->members.size() != 9) {
    sheet.Excuse({"fx_px", "fy_px", "cx_px", "cy_px"});
    sheet.Wrong(matrix.where, "camera_matrix",
                "is not a matrix of 3 rows and 3 columns with 9 numbers in data");
  } else {
    const auto at = [&](std::size_t i) -> const ConfigNode& { return K->members[i].node; };
    sheet.Set("fx_px", at(0)), sheet.Set("fy_px", at(4)), sheet.Set("cx_px", at(2)),
        sheet.Set("cy_px", at(5));
    if (xi) sheet.Set("skew_px", at(1));
    for (std::size_t i : {1, 3, 6, 7, 8}) {
      if ((i == 1 && xi) || IsNumber(at(i), i == 8)) continue;
      sheet.Wrong(at(i).where, fmt::format("camera_matrix.data.{}", i),
                  fmt::format("'{}' is not valid; valid: {}", at(i).text, i == 8 ? 1 : 0));
    }
  }

  static const Keys kBrown{"k1", "k2", "p1", "p2", "k3"}, kOmni{"k1", "k2", "p1", "p2"},
      kFisheye{"k1", "k2", "k3", "k4"};
  sheet.SetText("model", NameOf(*model), root.where);
  if (xi) {
    const ConfigNode* of_matrix = Find(*xi, "data");
    sheet.Set("xi", of_matrix && of_matrix->members.size() == 1 ? of_matrix->members[0].node : *xi);
  }
  if (!distortion) {
    sheet.Wrong(root.where, "distortion_coefficients", "must be given");
  } else if (xi || fisheye) {
    sheet.SetList(*distortion, "data", xi ? kOmni : kFisheye);
  } else if (count != 4 && count != 5 && count != 8 && count != 12 && count != 14) {
    sheet.Wrong(distortion->where, "distortion_coefficients",
                fmt::format("{} numbers are not valid; valid: 4 or 5: {}", count, fmt::join(kBrown, ", ")));
  } else {
    for (std::size_t i = 0; i < count; ++i) {
      const ConfigNode& number = data->members[i].node;
      if (i < kBrown.size()) {
        sheet.Set(kBrown[i], number);
      } else if (!IsNumber(number, 0)) {
        sheet.Wrong(
            number.where, fmt::format("distortion_coefficients.data.{}", i),
            fmt::format("'{}' belongs to OpenCV's rational, thin prism or tilted model, which is not known "
                        "here; valid: 0, or a calibration with {} alone",
                        number.text, fmt::join(kBrown, ", ")));
      }
    }
  }

  const ConfigNode *width = Find(root, "image_width"), *height = Find(root, "image_height");
  if (image && !width && !height) return SetImageSize(sheet, *image);
  if (width) sheet.Set("width_px", *width);
  if (height) sheet.Set("height_px", *height);
  if (!width) sheet.Excuse({"width_px"}), sheet.Wrong(root.where, "image_width", "must be given");
  if (!height) sheet.Excuse({"height_px"}), sheet.Wrong(root.where, "image_height", "must be given");
}

void FromOwn(const ConfigNode& root, const std::optional<cv::Size>& image, Sheet& sheet) {
  sheet.node = root;
  const auto has = [&](const char* key) { return Find(root, key) != nullptr; };
  if (root.kind == Kind::kMap && !has("model") && !has("width_px") && !has("fx_px")) {
    sheet.mistakes.Add(root.where, "", "is not a camera",
                       "valid: a file of this project (fx_px, ...), a camchain of Kalibr (cam0) or a "
                       "calibration of OpenCV (camera_matrix)");
  }
  if (image && !Find(root, "width_px") && !Find(root, "height_px")) SetImageSize(sheet, *image);
}

CameraModel ReadSheet(const Sheet& sheet) {
  FieldReader reader(sheet.node, sheet.path, sheet.mistakes);
  const std::vector<CameraModel> models = CameraModels();
  Keys names;
  for (const CameraModel& each : models) names.push_back(NameOf(each));
  std::string name = Pinhole::kName;
  reader("model", name, names);
  const auto named = std::find(names.begin(), names.end(), name);
  CameraModel camera = named == names.end() ? CameraModel{} : models[named - names.begin()];
  std::visit([&](auto& each) { Fields(reader, each); }, camera);
  reader.Finish();
  return camera;
}

// The members of a model by their keys, as text.
class ValueWriter final : public FieldVisitor {
 public:
  void Visit(const FieldKey& key, const FieldValue& field) override {
    if (const auto* number = std::get_if<NumberField>(&field))
      Add(key, fmt::format("{}", *number->value));
    else if (const auto* integer = std::get_if<IntegerField>(&field))
      Add(key, fmt::format("{}", *integer->value));
    else if (const auto* optional = std::get_if<OptionalNumberField>(&field); optional && *optional->value)
      Add(key, fmt::format("{}", **optional->value));
  }
  const std::string* Find(std::string_view key) const {
    for (const auto& [name, value] : values_) {
      if (name == key) return &value;
    }
    return nullptr;
  }
  const std::vector<std::pair<std::string, std::string>>& values() const { return values_; }

 private:
  void Add(FieldKey key, std::string value) { values_.emplace_back(key.name, std::move(value)); }

  std::vector<std::pair<std::string, std::string>> values_;
};

ValueWriter ValuesOf(CameraModel camera) {
  ValueWriter writer;
  std::visit([&](auto& each) { Fields(writer, each); }, camera);
  return writer;
}

}  // namespace

CameraModel LoadCamera(const std::filesystem::path& file, Mistakes& mistakes, const std::string& name,
                       const std::optional<cv::Size>& image) {
  const FileContent content = ReadUserFile(file, kMaxTextBytes);
  const std::string_view text = std::string_view(content.bytes).substr(0, 256);
  if (text.starts_with("<?xml") || text.starts_with("<opencv_storage")) {
    mistakes.Add(file.string(), "", "is XML, which is not read",
                 "valid: YAML, which OpenCV writes to a file that ends in .yml");
    return {};
  }
  if (text.find('\0') != std::string_view::npos) {
    mistakes.Add(file.string(), "", "is not a calibration file but an image or the like", "valid: YAML");
    return {};
  }
  return ParseCamera(LoadConfig(file, {}, mistakes), mistakes, name, image);
}

std::vector<std::string> CameraNames(const Config& config) { return CamerasOf(config.root); }

CameraModel ParseCamera(const Config& config, Mistakes& mistakes, const std::string& name,
                        const std::optional<cv::Size>& image) {
  if (!config.readable) return {};
  const ConfigNode& root = config.root;
  const std::size_t before = mistakes.all().size();
  Sheet sheet{{Kind::kMap, "", false, root.where, {}}, "", mistakes};
  if (!CamerasOf(root).empty())
    FromKalibr(root, name, image, sheet);
  else if (!name.empty())
    mistakes.Add(root.where, name, "there is no such camera: only a camchain of Kalibr has several");
  else if (IsOpenCv(root))
    FromOpenCv(root, image, sheet);
  else
    FromOwn(root, image, sheet);
  if (mistakes.all().size() > before && sheet.node.members.empty()) return {};

  const CameraModel camera = ReadSheet(sheet);
  if (mistakes.all().size() > before) return camera;
  const int width = WidthPx(camera), height = HeightPx(camera);
  if (image && (width != image->width || height != image->height)) {
    mistakes.Add(
        Find(sheet.node, "width_px")->where, "",
        fmt::format("it is for images of {} x {} pixels, but these have {} x {}: calibrate at their size",
                    width, height, image->width, image->height));
  } else if (ShareCovered(camera) == 0) {
    mistakes.Add(
        sheet.node.where, "",
        fmt::format("no pixel of the image can be seen through this lens: its field ends {:.3g} deg from the "
                    "axis, at the pixel ({:g}, {:g})",
                    Degrees(MaxAngle(camera)), Parameters(camera)[2], Parameters(camera)[3]));
  }
  return camera;
}

std::string ToCameraYaml(const CameraModel& camera) {
  std::string text = fmt::format("model: {}\n", NameOf(camera));
  const ValueWriter values = ValuesOf(camera);
  for (const auto& [key, value] : values.values()) text += fmt::format("{}: {}\n", key, value);
  return text;
}

std::string ToKalibr(const CameraModel& camera) {
  const ValueWriter values = ValuesOf(camera);
  for (const char* key : {"k3", "skew_px"}) {
    const std::string* value = std::holds_alternative<KannalaBrandt>(camera) ? nullptr : values.Find(key);
    if (value && *value != "0") {
      throw InputError({}, fmt::format("{} = {}: Kalibr's models have no such parameter", key, *value),
                       "valid: 0");
    }
  }
  const auto& forms = KalibrForms();
  const auto form = std::find_if(forms.begin(), forms.end(), [&](const KalibrForm& each) {
    return std::string_view(each.model) == NameOf(camera);
  });
  if (form == forms.end())
    throw InputError({}, fmt::format("model = {}: Kalibr has no such model", NameOf(camera)),
                     fmt::format("valid: {}, {}, {}, {}, {}", Pinhole::kName, BrownConrady::kName,
                                 Unified::kName, KannalaBrandt::kName, DoubleSphere::kName));
  const auto list = [&](const Keys& keys) {
    Keys all;
    for (const std::string& key : keys) all.push_back(*values.Find(key));
    return fmt::format("[{}]", fmt::join(all, ", "));
  };
  const std::string* field = values.Find("field_deg");
  return fmt::format(
      "cam0:\n  cam_overlaps: []\n  camera_model: {}\n  distortion_coeffs: {}\n  distortion_model: {}\n"
      "  intrinsics: {}\n  resolution: {}\n  rostopic: /cam0/image_raw\n{}",
      form->camera_model, list(form->distortion), form->distortion_model, list(form->intrinsics),
      list({"width_px", "height_px"}), field ? fmt::format("  field_deg: {}\n", *field) : "");
}

}  // namespace kestrel::vision
