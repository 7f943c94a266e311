// SPDX-License-Identifier: Apache-2.0
#include "flight/simulated/equipment.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "base/file/model_files.h"
#include "base/user_file.h"
#include "flight/simulated/check/check_image.h"
#include "sim/instrument/kalibr_imu.h"
#include "vision/camera/calibration_file.h"

namespace kestrel::flight {
namespace {

namespace fs = std::filesystem;

const ConfigNode* Member(const ConfigNode* node, std::string_view key) {
  if (!node) return nullptr;
  const auto found = std::find_if(node->members.begin(), node->members.end(),
                                  [&](const auto& member) { return member.key == key; });
  return found == node->members.end() ? nullptr : &found->node;
}

// One camera of the list in the file: where it says what, and how its keys are called.
class InFile {
 public:
  InFile(const Config& config, std::size_t i, Mistakes& mistakes)
      : path_(fmt::format("cameras.{}", i)), mistakes_(mistakes) {
    const ConfigNode* list = Find(config, "cameras");
    where_ = list ? list->where : Place();
    node_ = Member(list, std::to_string(i));
    if (node_) where_ = node_->where;
  }

  const ConfigNode* Key(std::string_view key) const { return Member(node_, key); }
  Place Where(std::string_view key) const { return Key(key) ? Key(key)->where : where_; }
  void Wrong(std::string_view key, std::string_view what, std::string_view remedy) {
    mistakes_.Add(Where(key), fmt::format("{}.{}", path_, key), what, remedy);
  }
  // Those that were found without knowing which camera it is.
  void Wrong(const Mistakes& of_it) {
    for (Diagnostic each : of_it.all()) {
      each.key = path_ + '.' + each.key;
      mistakes_.Add(std::move(each));
    }
  }

 private:
  std::string path_;
  Mistakes& mistakes_;
  Place where_;
  const ConfigNode* node_;
};

void CheckNames(const std::vector<CameraKeys>& keys, const Config& config, Mistakes& mistakes) {
  for (std::size_t i = 0; i < keys.size(); ++i) {
    const std::string& name = keys[i].name;
    InFile file(config, i, mistakes);
    if (name.empty() || name == kMainCamera || name == kFreeRunning || name.find('/') != std::string::npos)
      file.Wrong("name", fmt::format("'{}' cannot name a further camera", name),
                 fmt::format("valid: any but '{}', '{}' and the empty one, without a slash", kMainCamera,
                             kFreeRunning));
    const auto same = [&](const CameraKeys& other) { return other.name == name; };
    if (std::any_of(keys.begin(), keys.begin() + static_cast<std::ptrdiff_t>(i), same))
      file.Wrong("name", fmt::format("'{}' is the name of an earlier one", name), "valid: a name for each");
  }
}

// The clock that triggers a camera.
struct TriggerClock {
  double rate_hz;
  sim::CameraTiming timing;
};

// By following the triggers; none: a mistake.
std::optional<TriggerClock> ClockOf(std::size_t i, const std::vector<CameraKeys>& keys,
                                    const sim::ImageParameters& main, InFile& file) {
  std::string trigger = keys[i].trigger;
  TriggerClock clock{keys[i].image.rate_hz, keys[i].timing};
  for (std::size_t followed = 0; trigger != kFreeRunning; ++followed) {
    if (trigger == kMainCamera) return TriggerClock{main.rate_hz, {}};
    const auto next =
        std::find_if(keys.begin(), keys.end(), [&](const CameraKeys& each) { return each.name == trigger; });
    if (next == keys.end()) {
      std::vector<std::string> valid = {kFreeRunning, kMainCamera};
      for (const CameraKeys& each : keys)
        if (each.name != keys[i].name) valid.push_back(each.name);
      if (trigger == keys[i].trigger)  // otherwise it is said of whose it is
        file.Wrong("trigger", fmt::format("there is no camera '{}'", trigger),
                   fmt::format("valid: {}", fmt::join(valid, ", ")));
      return std::nullopt;
    }
    if (followed == keys.size()) {
      file.Wrong("trigger",
                 fmt::format("'{}' leads back to itself, so that nobody's clock triggers '{}'",
                             keys[i].trigger, keys[i].name),
                 fmt::format("valid: one of the cameras has '{}' or '{}'", kFreeRunning, kMainCamera));
      return std::nullopt;
    }
    clock = {next->image.rate_hz, next->timing};
    trigger = next->trigger;
  }
  return clock;
}

// What a triggered camera says of a clock that it does not have.
void CheckTriggered(const CameraKeys& keys, const TriggerClock& clock, InFile& file) {
  const std::string by = fmt::format("but it is triggered by '{}'", keys.trigger);
  if (Member(file.Key("image"), "rate_hz") && keys.image.rate_hz != clock.rate_hz)
    file.Wrong("image", fmt::format("rate_hz is {:g}, {}", keys.image.rate_hz, by),
               fmt::format("valid: no rate_hz, or {:g}", clock.rate_hz));
  if (keys.timing.phase_s != 0)
    file.Wrong("phase_s", fmt::format("{:g}, {}", keys.timing.phase_s, by), "valid: 0");
  if (keys.timing.drift_ppm != 0)
    file.Wrong("drift_ppm", fmt::format("{:g}, {}", keys.timing.drift_ppm, by), "valid: 0");
}

}  // namespace

std::vector<sim::CarriedCameraParameters> LoadCameras(std::vector<CameraKeys>& all,
                                                      const sim::ImageParameters& main,
                                                      const fs::path& beside, const Config& config,
                                                      Mistakes& mistakes) {
  constexpr double kFastest_hz = 500;  // one exposure for each step of the physics
  CheckNames(all, config, mistakes);
  const std::vector<CameraKeys> as_given = all;
  std::vector<sim::CarriedCameraParameters> cameras;
  for (std::size_t i = 0; i < all.size(); ++i) {
    CameraKeys& keys = all[i];
    InFile file(config, i, mistakes);
    const auto clock = ClockOf(i, as_given, main, file);
    if (clock && keys.trigger != kFreeRunning) {
      CheckTriggered(keys, *clock, file);
      keys.image.rate_hz = clock->rate_hz;
    }
    if (clock && clock->rate_hz * (1 + 1e-6 * clock->timing.drift_ppm) > kFastest_hz)
      file.Wrong(
          "drift_ppm",
          fmt::format("with {:g} the clock is faster than {:g} Hz", clock->timing.drift_ppm, kFastest_hz),
          "valid: less, or a lower image.rate_hz");
    sim::CarriedCameraParameters camera{
        keys.name, {}, keys.mount, keys.image, clock ? clock->timing : sim::CameraTiming{}};
    Mistakes own;
    const std::size_t before = mistakes.all().size();
    const auto model = ModelFile(Model::kCamera, keys.camera, beside, file.Where("camera"), own);
    if (model) camera.camera = vision::LoadCamera(*model, mistakes, keys.camera_name);
    const bool known = model && mistakes.all().size() == before;
    CheckMount(keys.mount, file.Where("mount"), own);
    CheckImage(keys.image, known ? &camera.camera : nullptr, file.Where("image"), own);
    file.Wrong(own);
    cameras.push_back(std::move(camera));
  }
  return cameras;
}

std::optional<sim::ImuParameters> ImuOfFile(const Config& scenario, const fs::path& beside,
                                            Mistakes& mistakes) {
  const ConfigNode* file = Member(Member(Find(scenario, "instruments"), "imu"), "file");
  if (!file || file->kind != ConfigNode::Kind::kText || file->text.empty()) return std::nullopt;
  sim::ImuParameters imu;
  for (const fs::path& candidate : {beside / file->text, fs::path(file->text)}) {
    if (!IsFile(candidate)) continue;
    imu.file = fs::absolute(candidate).lexically_normal().string();
    sim::ReadKalibrImu(LoadConfig(imu.file, {}, mistakes), imu, mistakes);
    return imu;
  }
  mistakes.Add(file->where, "instruments.imu.file", NoSuchFile(file->text), "valid: an imu.yaml of Kalibr");
  return std::nullopt;
}

void CheckInstruments(const sim::InstrumentParameters& instruments, const Place& where, Mistakes& mistakes) {
  const auto& rangefinder = instruments.rangefinder;
  if (!rangefinder) return;
  if (rangefinder->direction.norm() < 1e-6)
    mistakes.Add(where, "instruments.rangefinder.direction", "has no length",
                 "valid: such as [0, 0, 1], down");
  if (rangefinder->max_m <= rangefinder->min_m)
    mistakes.Add(where, "instruments.rangefinder.max_m",
                 fmt::format("{:g} is not above min_m = {:g}", rangefinder->max_m, rangefinder->min_m));
}

}  // namespace kestrel::flight
