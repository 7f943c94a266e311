// SPDX-License-Identifier: Apache-2.0
#include "flight/dataset/plan.h"

#include <fmt/format.h>

#include <algorithm>
#include <sstream>
#include <utility>

#include "base/file/files.h"
#include "base/file/model_files.h"
#include "base/user_file.h"
#include "base/version.h"
#include "base/yaml/yaml_fields.h"
#include "flight/dataset/trajectory/check_trajectory.h"
#include "flight/dataset/trajectory/pose_file.h"
#include "geometry/tait_bryan.h"
#include "sim/machine.h"
#include "vision/camera/camera_mount.h"

namespace kestrel::flight {
namespace {

namespace fs = std::filesystem;

// What a trajectory is flown in where no scenario is named: one that asks nothing of its camera and its pad.
constexpr const char* kPlainScenario = "stabilise";
const std::vector<std::string> kPlain{"mount.vibration=[]", "criteria={}", "image.rate_hz=20",
                                      "image.noise_grey=0", "pad.name=helipad"};

// An IMU without errors, where a scenario has none.
std::string PerfectImu(double rate_hz) {
  return fmt::format(
      "instruments.imu={{rate_hz: {}, accelerometer_noise_density: 0, "
      "accelerometer_random_walk: 0, "
      "accelerometer_turn_on_m_s2: 0, gyroscope_noise_density: 0, "
      "gyroscope_random_walk: 0, "
      "gyroscope_turn_on_rad_s: 0}}",
      rate_hz);
}

bool IsWay(const fs::path& file) {
  if (!HasEnding(file, {".yaml", ".yml"}) || !IsFile(file)) return false;
  Mistakes none;
  const Config config = LoadConfig(file, {}, none);
  return Find(config, "way") != nullptr;
}

std::string SettingsOf(const DatasetPlan& plan) {
  const DatasetArguments& a = plan.arguments;
  std::string text = fmt::format("# {}\n", Version());
  for (const auto& [name, value] : sim::ThisMachine()) text += fmt::format("# {} {}\n", name, value);
  text += fmt::format(
      "format: {}\ncount: {}\nframes: {}\nduration_s: "
      "{}\nimu_rate_hz: {}\ncolour: {}\ndepth: {}\nflow: {}\n"
      "segmentation: {}\nboxes: {}\n",
      a.format, a.count, a.frames.value_or(0), a.duration_s.value_or(0), a.imu_rate_hz.value_or(0),
      a.extras.colour, a.extras.depth, a.extras.flow, a.extras.segmentation, a.extras.boxes);
  if (plan.trajectory) text += fmt::format("trajectory: |\n{}\n", ReadFile(a.source));
  return text + ToYaml(plan.first.scenario);
}

bool HoldsFiles(const fs::path& folder) {
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder, error))
    if (entry.path().filename() != ".lock") return true;  // which the writer leaves
  return false;
}

// Of two texts, the first line in which they differ, as it stands in the one and in the other.
std::string FirstDifference(const std::string& there, const std::string& here) {
  std::istringstream a(there), b(here);
  std::string x, y;
  while (x == y && (a || b)) {
    if (!std::getline(a, x)) x.clear();
    if (!std::getline(b, y)) y.clear();
  }
  return fmt::format("'{}' there, '{}' here", x, y);
}

void CheckFolder(const DatasetPlan& plan, Mistakes& mistakes) {
  const fs::path& out = plan.arguments.out;
  CheckWritableFolder(out, "--out", mistakes);
  const fs::path settings = out / "settings.txt";
  if (IsFile(settings)) {
    if (const std::string there = ReadFile(settings); there != plan.settings)
      mistakes.Add(
          "--out", "",
          fmt::format("{} holds a data set of other settings, another version or another machine: {}",
                      out.string(), FirstDifference(there, plan.settings)),
          "valid: another folder, or that one removed");
  } else if (HoldsFiles(out)) {
    mistakes.Add("--out", "", fmt::format("'{}' is not an empty folder", out.string()),
                 "valid: a new one, or one with a data set that was broken off");
  }
}

}  // namespace

LoadedScenario ScenarioOf(const DatasetPlan& plan, int number) {
  if (number == 0) return plan.first;
  std::vector<std::string> overrides = plan.overrides;
  overrides.push_back(fmt::format("seed={}", plan.first.scenario.seed + static_cast<std::uint64_t>(number)));
  return LoadScenario(plan.scenario, overrides, false);
}

Sequence BeginSequence(const DatasetPlan& plan, const LoadedScenario& loaded, int number) {
  const sim::SimulatorParameters& simulator = loaded.simulator;
  Sequence s;
  s.number = number;
  if (plan.arguments.count > 1) s.folder = fmt::format("{}/", loaded.scenario.seed);
  s.extras = plan.arguments.extras;
  s.cameras.push_back(
      MakeRigCamera(simulator.camera, vision::MountPose(simulator.mount), simulator.image.rate_hz));
  for (const sim::CarriedCameraParameters& camera : simulator.cameras)
    s.cameras.push_back(MakeRigCamera(camera.camera, vision::MountPose(camera.mount), camera.image.rate_hz));
  s.frames.resize(s.cameras.size());
  s.imu_parameters = *simulator.instruments.imu;
  const sim::ImuParameters& imu = s.imu_parameters;
  s.X_BI.R = Eigen::Quaterniond(
      RotationFromTaitBryan({Radians(imu.yaw_deg), Radians(imu.pitch_deg), Radians(imu.roll_deg)}));
  s.X_BI.p = imu.position_m;
  return s;
}

DatasetPlan LoadDatasetPlan(const DatasetArguments& arguments) {
  DatasetPlan plan;
  plan.arguments = arguments;
  const DatasetArguments& a = plan.arguments;
  const bool poses = IsPoseFile(a.source), way = !poses && IsWay(a.source);
  Mistakes mistakes;
  if (!a.in.empty() && !poses && !way)
    mistakes.Add("--in", "", fmt::format("'{}' is no trajectory, and flies in its own world", a.source),
                 "valid: without, or the file of a way or of poses");
  const bool flown = !poses && !way;
  std::vector<std::string>& overrides = plan.overrides;
  if (!flown && a.in.empty()) overrides = kPlain;
  overrides.insert(overrides.end(), a.overrides.begin(), a.overrides.end());
  if (a.extras.colour || a.format == "tum") overrides.emplace_back("image.colour=true");
  if (a.duration_s && flown) overrides.push_back(fmt::format("duration_s={}", *a.duration_s));
  plan.scenario = flown ? a.source : a.in.empty() ? kPlainScenario : a.in;
  bool has_scenario = false;
  try {
    const LoadedScenario loaded = LoadScenario(plan.scenario, overrides);
    if (!loaded.simulator.instruments.imu)
      overrides.push_back(PerfectImu(a.imu_rate_hz.value_or(200)));
    else if (a.imu_rate_hz)
      overrides.push_back(fmt::format("instruments.imu.rate_hz={}", *a.imu_rate_hz));
    plan.first = LoadScenario(plan.scenario, overrides, false);
    has_scenario = true;
  } catch (const InputError& e) {
    mistakes.Add(e);
  }
  try {
    // Without a scenario it is not known where the camera is, and what else is wrong does not ask for it.
    const Pose X_BC = vision::MountPose(plan.first.simulator.mount);
    if (poses) plan.trajectory = LoadPoses(a.source, X_BC);
    if (way) plan.trajectory = LoadWay(a.source);
  } catch (const InputError& e) {
    mistakes.Add(e);
  }
  if (has_scenario) {
    if (plan.trajectory) CheckTrajectory(*plan.trajectory, plan.first.simulator, mistakes);
    plan.format = MakeFormat(a.format);
    plan.format->Check(BeginSequence(plan, plan.first, a.count - 1), mistakes);
    plan.settings = SettingsOf(plan);
    CheckFolder(plan, mistakes);
  }
  mistakes.ThrowIfAny();
  return plan;
}

}  // namespace kestrel::flight
