// SPDX-License-Identifier: Apache-2.0
#include "vision/camera/calibration_file.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cctype>
#include <sstream>
#include <string_view>

#include "base/diagnostics.h"
#include "base/user_file.h"
#include "base/yaml/fields.h"
#include "base/yaml/yaml_fields.h"
#include "vision/camera/file/camera_forms.h"
#include "vision/camera/file/kalibr.h"
#include "vision/camera/file/on_imu.h"
#include "vision/camera/file/opencv_xml.h"
#include "vision/camera/file/sheet.h"

namespace kestrel::vision {
namespace {

// What a file that says nothing else must be.
void FromOwn(const ConfigNode& root, Sheet& sheet) {
  const auto has = [&](const char* key) { return Find(root, key) != nullptr; };
  if (root.kind != ConfigNode::Kind::kMap || (!has("width_px") && !has("fx_px"))) {
    Keys programs;
    for (const CameraForm& each : CameraForms()) programs.emplace_back(each.written_by);
    return sheet.mistakes.Add(root.where, "", "is not a camera",
                              fmt::format("valid: a file of this project (fx_px, ...) or a calibration of {}",
                                          fmt::join(programs, ", ")));
  }
  sheet.node = root;
}

// Of what rostopic prints of a camera_info, one message after another, the first; all of any other text.
std::string FirstMessage(const std::string& text) {
  const bool printed = text.find("\nD:") != std::string::npos || text.find("\nd:") != std::string::npos;
  const std::size_t first_key = text.find_first_of("abcdefghijklmnopqrstuvwxyz");
  return printed ? text.substr(0, text.find("\n---", std::min(first_key, text.size()))) : text;
}

// OpenCV reads "key:2" as "key: 2", and the files that ORB-SLAM came with have such lines.
std::string WithSpaceAfterColons(const std::string& text) {
  if (!text.starts_with("%YAML")) return text;
  const auto in_key = [](unsigned char c) { return std::isalnum(c) || c == '.' || c == '_'; };
  std::string spaced;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t end = std::find_if_not(line.begin(), line.end(), in_key) - line.begin();
    if (end > 0 && end + 1 < line.size() && line[end] == ':' &&
        !std::isspace(static_cast<unsigned char>(line[end + 1])))
      line.insert(end + 1, " ");
    spaced += line + '\n';
  }
  return spaced;
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

// What the file says of one of its cameras.
Sheet SheetOf(const Config& config, Mistakes& mistakes, const std::string& name) {
  const ConfigNode& root = config.root;
  Sheet sheet{{ConfigNode::Kind::kMap, "", false, root.where, {}}, "", mistakes};
  const CameraForm* form = FindForm(root);
  const Keys cameras = CameraNames(config);
  const auto named = name.empty() ? cameras.begin() : std::find(cameras.begin(), cameras.end(), name);
  if (!form && !name.empty())
    mistakes.Add(root.where, name, "there is no such camera: the file is of one without a name");
  else if (!form)
    FromOwn(root, sheet);
  else if (named == cameras.end())
    mistakes.Add(root.where, name, "there is no such camera",
                 fmt::format("valid: {}", fmt::join(cameras, ", ")));
  else
    form->read(root, named - cameras.begin(), sheet);
  return sheet;
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

Config LoadCalibration(const std::filesystem::path& file, Mistakes& mistakes) {
  FileContent content = ReadUserFile(file, kMaxTextBytes);
  if (!content.error.empty()) {
    mistakes.Add(file.string(), "", content.error);
    return {};
  }
  std::string& text = content.bytes;
  if (IsXml(text)) return ParseOpenCvXml(text, file.string(), mistakes);
  if (text.substr(0, 256).find('\0') != std::string::npos) {
    mistakes.Add(file.string(), "", "is not a calibration file but an image or the like",
                 "valid: YAML, JSON or XML");
    return {};
  }
  return ParseConfig(WithSpaceAfterColons(FirstMessage(text)), file.string(), {}, mistakes);
}

}  // namespace

CameraModel LoadCamera(const std::filesystem::path& file, Mistakes& mistakes, const std::string& name,
                       const std::optional<cv::Size>& image) {
  return ParseCamera(LoadCalibration(file, mistakes), mistakes, name, image);
}

std::optional<Pose> LoadPoseOnImu(const std::filesystem::path& file, Mistakes& mistakes,
                                  const std::string& name) {
  const std::size_t before = mistakes.all().size();
  const Config config = LoadCalibration(file, mistakes);
  if (!config.readable) return std::nullopt;
  Sheet sheet = SheetOf(config, mistakes, name);
  return mistakes.all().size() == before ? PoseOnImu(sheet) : std::nullopt;
}

Keys CameraNames(const Config& config) {
  const CameraForm* form = FindForm(config.root);
  return form ? form->cameras(config.root) : Keys();
}

CameraModel ParseCamera(const Config& config, Mistakes& mistakes, const std::string& name,
                        const std::optional<cv::Size>& image) {
  if (!config.readable) return {};
  const std::size_t before = mistakes.all().size();
  Sheet sheet = SheetOf(config, mistakes, name);
  // What is not understood is said once, and not by all that is missing then.
  if (mistakes.all().size() > before) return {};
  const CameraForm* form = FindForm(config.root);
  if (!Find(sheet.node, "width_px") && !Find(sheet.node, "height_px")) {
    if (image) {
      sheet.SetText("width_px", std::to_string(image->width), sheet.node.where);
      sheet.SetText("height_px", std::to_string(image->height), sheet.node.where);
    } else if (form) {
      sheet.Wrong(sheet.node.where, form->size_keys, "must be given: the size of the images");
      return {};
    }
  }

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
  if (form == forms.end()) {
    Keys valid;
    for (const KalibrForm& each : forms)
      if (std::find(valid.begin(), valid.end(), each.model) == valid.end()) valid.emplace_back(each.model);
    throw InputError({}, fmt::format("model = {}: Kalibr has no such model", NameOf(camera)),
                     fmt::format("valid: {}", fmt::join(valid, ", ")));
  }
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
