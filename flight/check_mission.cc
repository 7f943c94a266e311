// SPDX-License-Identifier: Apache-2.0
#include "flight/check_mission.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <vector>

#include "base/file/model_files.h"
#include "base/nearest_name.h"
#include "base/yaml/config.h"
#include "vision/landmark/features/features.h"
#include "vision/landmark/seen_heights.h"

namespace kestrel::flight {
namespace {

// Where the file has a dotted key, or the nearest of what holds it.
Place WhereOfDotted(const ConfigNode& node, std::string_view key, const Place& holder) {
  const std::string_view first = key.substr(0, key.find('.'));
  for (const auto& [name, member] : node.members)
    if (name == first)
      return first == key ? member.where : WhereOfDotted(member, key.substr(first.size() + 1), member.where);
  return holder;
}

// What is wrong with a flight as a whole, each at its own key.
void AddAtKeys(const Mistakes& of_flight, const Config& config, Mistakes& mistakes) {
  for (const Diagnostic& each : of_flight.all())
    mistakes.Add(WhereOfDotted(config.root, each.key, each.place()), each.key, each.what, each.remedy);
}

}  // namespace

void CheckMissionExists(Config& config, const Place& where, Mistakes& mistakes) {
  const ConfigNode* named = Find(config, "mission");
  const std::vector<std::string> names = mission::MissionNames();
  if (!named || std::find(names.begin(), names.end(), named->text) != names.end()) return;
  mistakes.Add(WhereOf(config, "mission", where), "mission",
               fmt::format("there is no mission {}", Shown(*named)),
               RemedyForName(named->text, names) +
                   ", or the mission of a plug-in, whose file --plugin or KESTREL_PLUGINS names");
  for (auto& [key, node] : config.root.members) {
    if (key != "mission") continue;
    node.kind = ConfigNode::Kind::kText;
    node.text = names.front();
  }
  std::erase_if(config.root.members,
                [](const auto& member) { return member.key == "flight" || member.key == "criteria"; });
}

void CheckMission(const mission::Flight& flight, bool colour, const Config& config, const Place& where,
                  Mistakes& mistakes) {
  if (flight.type().needs_colour && !colour)
    mistakes.Add(WhereOf(config, "image", where), "image.colour",
                 fmt::format("false, but the mission '{}' tells its target by colour", flight.type().name),
                 "valid: true");
  Mistakes of_flight;
  flight->Check(WhereOf(config, "flight", where), of_flight);
  AddAtKeys(of_flight, config, mistakes);
}

void CheckLimits(const mission::Flight& flight, const mission::AircraftLimits& limits, const Config& config,
                 const Place& where, Mistakes& mistakes) {
  Mistakes of_flight;
  flight->CheckLimits(limits, WhereOf(config, "flight", where), of_flight);
  AddAtKeys(of_flight, config, mistakes);
}

void CheckView(const mission::Flight& flight, const std::string& camera_name,
               const vision::CameraModel& camera, const vision::CameraMount& mount, const Config& config,
               const Place& where, Mistakes& mistakes) {
  if (flight.type().looks_for_pad && !mission::TrackersCamera(camera)) {
    const Eigen::VectorXd numbers = vision::Parameters(camera);
    mistakes.Add(
        WhereOf(config, "camera", where), "camera",
        fmt::format(
            "'{}' does not see along its own optical axis, where these flights look for the pad: its "
            "principal point ({:g}, {:g}) is too near to the edge of the image of {} x {} px or beyond it",
            camera_name, numbers[2], numbers[3], vision::WidthPx(camera), vision::HeightPx(camera)),
        "valid: a camera that has it well within");
  }
  flight->CheckView(camera, mount, WhereOf(config, "flight", where), WhereOf(config, "mount", where),
                    mistakes);
}

void CheckPilot(const mission::Flight& flight, const mission::PilotParameters& pilot, const Config& config,
                const Place& where, Mistakes& mistakes) {
  const auto detector = vision::FeatureDetectorNamed(pilot.tracker.features);
  if (flight.type().looks_for_pad && detector && !vision::IsAvailable(*detector))
    mistakes.Add(WhereOf(config, "pilot", where), "pilot.tracker.features",
                 fmt::format("'{}', and this build has no dlib", pilot.tracker.features),
                 "valid: sift, orb, akaze, or build anew with Debian's libdlib-dev and libblas-dev");
}

void CheckPadHeights(const mission::Flight& flight, const vision::PadReference& pad,
                     const vision::CameraModel& camera, const vision::PadTrackerOptions& tracker,
                     std::optional<double> start_m, const Config& config, const Place& where,
                     Mistakes& mistakes, std::string& note) {
  const auto view = mission::TrackersCamera(camera);
  if (!flight.type().looks_for_pad || !view || pad.levels.empty()) return;
  const std::vector<vision::SeenHeights> seen = vision::HeightsSeen(pad, *view, tracker);
  if (seen.empty()) {
    mistakes.Add(
        WhereOf(config, "pad", where), "pad.name", "this camera sees the pad well enough from no height",
        "valid: a larger pad, one with more corners, pilot.tracker.method: icia, or a camera with more "
        "pixels");
    return;
  }
  std::vector<std::string> ranges;
  for (const vision::SeenHeights& range : seen)
    ranges.push_back(fmt::format("{:.2g} to {:.3g} m", range.min_m, range.max_m));
  note = fmt::format("the camera can see the pad from {} above it", fmt::join(ranges, " and from "));
  const auto begins = std::find_if(seen.begin(), seen.end(), [&](const vision::SeenHeights& range) {
    return !start_m || (*start_m >= range.min_m && *start_m <= range.max_m);
  });
  if (begins == seen.end()) {
    mistakes.Add(WhereOf(config, "start", where), "start.height_m",
                 fmt::format("{:g}, and the camera sees the pad from {} above it", *start_m,
                             fmt::join(ranges, " and from ")),
                 "valid: a height within, a larger or smaller pad, or another camera");
    return;
  }
  flight->CheckPad(begins->min_m, WhereOf(config, "flight", where), mistakes);
}

void CheckHasPad(const mission::Flight& flight, const Config& config, const Place& where,
                 Mistakes& mistakes) {
  if (flight.type().looks_for_pad)
    mistakes.Add(WhereOf(config, "pad", where), "pad.name",
                 fmt::format("none, but the mission '{}' looks for a pad", flight.type().name),
                 fmt::format("valid: {}", fmt::join(ModelNames(Model::kPad), ", ")));
}

}  // namespace kestrel::flight
