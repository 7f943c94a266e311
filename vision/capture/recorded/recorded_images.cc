// SPDX-License-Identifier: Apache-2.0
#include "vision/capture/recorded/recorded_images.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <system_error>
#include <utility>

#include "base/nearest_name.h"
#include "base/user_file.h"
#include "vision/capture/recorded/image_files.h"
#include "vision/capture/recorded/image_table.h"
#include "vision/capture/recorded/mcap_images.h"
#include "vision/capture/recorded/stamp.h"
#include "vision/capture/recorded/stamped_table.h"

namespace kestrel::vision {
namespace {

namespace fs = std::filesystem;

fs::path IfThere(const fs::path& file) { return IsFile(file) ? file : fs::path(); }

RecordedImages FromFiles(std::vector<std::string> names, std::vector<std::int64_t> stamps_ns) {
  RecordedImages recorded;
  recorded.names = std::move(names), recorded.stamps_ns = std::move(stamps_ns);
  const auto files = std::make_shared<const std::vector<std::string>>(recorded.names);
  recorded.reader = [files] {
    return [files](std::size_t i, ImageColours colours) { return ReadImageFile((*files)[i], colours); };
  };
  return recorded;
}

RecordedImages FromTable(const std::vector<StampedImage>& images) {
  std::vector<std::string> names;
  std::vector<std::int64_t> stamps_ns;
  for (const StampedImage& each : images)
    names.push_back(each.file.string()), stamps_ns.push_back(each.stamp_ns);
  return FromFiles(std::move(names), std::move(stamps_ns));
}

// Which of several cameras is asked for, by the names of their folders. Null: a mistake says which there are.
const fs::path* CameraOf(const fs::path& recording, const std::vector<fs::path>& cameras,
                         const std::string& topic, const std::string& usual, Mistakes& mistakes) {
  std::vector<std::string> names;
  for (const fs::path& each : cameras) names.push_back(each.filename().string());
  const std::string wanted = !topic.empty() ? topic : names.size() == 1 ? names.front() : usual;
  const auto found = std::find(names.begin(), names.end(), wanted);
  if (found != names.end()) return &cameras[static_cast<std::size_t>(found - names.begin())];
  const std::string valid = fmt::format("valid: {}", fmt::join(names, ", "));
  if (topic.empty()) {
    mistakes.Add(recording.string(), "topic", "several cameras were recorded, and none is named", valid);
  } else {
    const auto near = NearestName(topic, names);
    mistakes.Add(recording.string(), "topic", fmt::format("it has no camera '{}'", topic),
                 near ? fmt::format("did you mean {}? {}", *near, valid) : valid);
  }
  return nullptr;
}

// A topic is of no use where there is but one camera, unless it is that one's name.
void RefuseTopic(const fs::path& recording, const std::string& topic, Mistakes& mistakes) {
  if (!topic.empty() && topic != recording.filename().string())
    mistakes.Add(recording.string(), "topic", fmt::format("'{}': it has one camera only", topic),
                 "valid: without it");
}

bool IsEurocCamera(const fs::path& folder) {
  std::error_code none;
  return IsFile(folder / "data.csv") && fs::is_directory(folder / "data", none);
}

std::optional<RecordedImages> FromEuroc(const fs::path& recording, const std::string& topic,
                                        Mistakes& mistakes) {
  fs::path camera;
  if (IsEurocCamera(recording)) {
    RefuseTopic(recording, topic, mistakes);
    camera = recording;
  } else {
    std::error_code none;
    const fs::path of_all = fs::is_directory(recording / "mav0", none) ? recording / "mav0" : recording;
    std::vector<fs::path> cameras;
    for (const fs::path& each : FoldersIn(of_all))
      if (each.filename().string().starts_with("cam") && IsFile(each / "data.csv")) cameras.push_back(each);
    if (cameras.empty()) return std::nullopt;
    const fs::path* found = CameraOf(recording, cameras, topic, "cam0", mistakes);
    if (!found) return RecordedImages();
    camera = *found;
  }
  RecordedImages recorded = FromTable(ReadEurocTable(camera, mistakes));
  recorded.topic = camera.filename().string();
  recorded.calibration = IfThere(camera / "sensor.yaml");
  recorded.gyro = IfThere(fs::weakly_canonical(camera / "..") / "imu0" / "data.csv");
  return recorded;
}

// A folder of images and its times.txt, or a sequence with several such folders.
std::optional<RecordedImages> FromKitti(const fs::path& recording, const std::string& topic,
                                        Mistakes& mistakes) {
  fs::path images = recording, table = recording / "times.txt";
  if (!IsFile(table)) {
    table = fs::weakly_canonical(recording / "..") / "times.txt";
    if (!recording.filename().string().starts_with("image_") || !IsFile(table)) return std::nullopt;
    RefuseTopic(recording, topic, mistakes);
  } else {
    std::vector<fs::path> cameras;
    for (const fs::path& each : FoldersIn(recording))
      if (each.filename().string().starts_with("image_")) cameras.push_back(each);
    if (cameras.empty()) {
      RefuseTopic(recording, topic, mistakes);
    } else {
      const fs::path* found = CameraOf(recording, cameras, topic, "", mistakes);
      if (!found) return RecordedImages();
      images = *found;
    }
  }
  return FromTable(ReadKittiTable(table, ImageFilesOf(images), mistakes));
}

// Whose names are stamps, or none is one.
RecordedImages FromNames(const fs::path& recording, Mistakes& mistakes) {
  const std::vector<fs::path> files = ImageFilesOf(recording);
  std::vector<StampedImage> stamped;
  std::vector<std::string> names, without;
  for (const fs::path& file : files) {
    names.push_back(file.string());
    if (const auto stamp = StampOfName(file.stem().string()))
      stamped.push_back({*stamp, file});
    else
      without.push_back(file.filename().string());
  }
  if (stamped.empty()) return FromFiles(std::move(names), {});
  if (!without.empty())
    mistakes.Add(
        recording.string(), "",
        fmt::format("the names of {} images are stamps, and those of {} are none, the first of them {}",
                    stamped.size(), without.size(), without.front()),
        "valid: names that are all stamps in ns (19 digits) or in s (with a point), or none");
  std::sort(stamped.begin(), stamped.end(),
            [](const StampedImage& a, const StampedImage& b) { return a.stamp_ns < b.stamp_ns; });
  StampOrder order;
  for (const StampedImage& each : stamped)
    if (const std::string wrong = order.Next(each.stamp_ns, each.file.stem().string()); !wrong.empty())
      mistakes.Add(each.file.string(), "", wrong, "valid: each stamp once");
  return FromTable(stamped);
}

RecordedImages Open(const fs::path& recording, const std::string& topic, Mistakes& mistakes) {
  std::error_code none;
  if (fs::is_directory(recording, none)) {
    if (auto euroc = FromEuroc(recording, topic, mistakes)) return *euroc;
    if (auto kitti = FromKitti(recording, topic, mistakes)) return *kitti;
    RefuseTopic(recording, topic, mistakes);
    if (IsFile(recording / "rgb.txt")) return FromTable(ReadTumTable(recording / "rgb.txt", mistakes));
  } else if (IsMcap(recording)) {
    return OpenMcapImages(recording, topic, mistakes);
  } else {
    RefuseTopic(recording, topic, mistakes);
  }
  return FromNames(recording, mistakes);
}

}  // namespace

bool IsRecording(const fs::path& file) {
  std::error_code none;
  return fs::is_directory(file, none) || IsMcap(file);
}

double RecordedImages::Time_s(std::size_t index) const {
  return static_cast<double>(stamps_ns[index] - stamps_ns.front()) / 1e9;
}

double RecordedImages::Rate_hz() const {
  return stamps_ns.size() < 2 ? 0 : static_cast<double>(stamps_ns.size() - 1) / Time_s(stamps_ns.size() - 1);
}

RecordedImages OpenRecordedImages(const fs::path& given, const std::string& topic, Mistakes& mistakes) {
  const std::size_t before = mistakes.all().size();
  const fs::path recording = given.has_filename() ? given : given.parent_path();  // "mav0/cam0/"
  RecordedImages recorded = Open(recording, topic, mistakes);
  if (mistakes.all().size() > before) return {};
  if (recorded.size() == 0)
    mistakes.Add(recording.string(), "", "no images are in it",
                 "valid: a folder of images, a data set of EuRoC, TUM or KITTI, or an MCAP");
  return recorded;
}

}  // namespace kestrel::vision
