// SPDX-License-Identifier: Apache-2.0
#include "flight/flight_subject.h"

#include "base/process/shell_word.h"
#include "base/version.h"
#include "vision/aircraft/ground_camera.h"

namespace kestrel::flight {

records::FlightSubject SubjectOf(const FlightKeys& keys, const mission::MissionParts& parts,
                                 const std::string& mode, const std::string& description) {
  records::FlightSubject subject;
  subject.scenario = subject.title = keys.name;
  subject.seed = keys.seed;
  subject.mode = mode;
  subject.mission = keys.mission;
  subject.wanted = description.empty() ? keys.flight.type().summary : description;
  subject.version = Version();
  subject.camera = records::CameraOf(keys.camera, parts.camera, parts.X_BC);
  if (parts.ground)
    subject.ground_camera = records::CameraOf(keys.ground_camera->camera, parts.ground->camera,
                                              vision::CameraPose(vision::MastPose(parts.ground->place), {}));
  const vision::PadReference& pad = parts.pad;
  if (!pad.levels.empty())
    subject.pad = {{pad.length_m, pad.width_m}, {}, records::PictureOf(pad.levels.front().image)};
  return subject;
}

records::FlightMessageOptions MessageOptionsOf(const mission::MissionParts& parts) {
  records::FlightMessageOptions options;
  if (!parts.pad.levels.empty()) options.outline = parts.pad.Outline();
  options.camera = parts.camera;
  options.X_BC = parts.X_BC;
  return options;
}

std::string CommandOf(const std::string& name_or_file, const std::vector<std::string>& overrides) {
  constexpr std::string_view kSeed = "seed=";
  std::string command = "kestrel run " + ShellWord(name_or_file);
  for (const std::string& each : overrides)
    command += each.starts_with(kSeed) ? " --seed " + ShellWord(each.substr(kSeed.size()))
                                       : " --set " + ShellWord(each);
  return command;
}

}  // namespace kestrel::flight
