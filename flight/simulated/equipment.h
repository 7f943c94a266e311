// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "base/yaml/config.h"
#include "base/yaml/fields.h"
#include "sim/camera/carried/carried_camera.h"
#include "sim/instrument/instrument_parameters.h"

// What an aircraft carries beside what it flies by: further cameras, and instruments.
namespace kestrel::flight {

inline constexpr char kMainCamera[] = "main";  // by which the flight is flown
inline constexpr char kFreeRunning[] = "free";

// A further camera, as a scenario has it.
struct CameraKeys {
  std::string name;
  std::string camera = "thesis_6mm", camera_name;
  vision::CameraMount mount;
  sim::ImageParameters image;
  std::string trigger = kFreeRunning;
  sim::CameraTiming timing;
};

inline void Fields(FieldVisitor& v, CameraKeys& k) {
  v(Required("name",
             "name of the camera, of no other; not main, which is the camera that the flight is flown by"),
    k.name);
  v({"camera", "camera: a name in models/cameras, or a calibration file of Kestrel, Kalibr or OpenCV"},
    k.camera);
  v({"camera_name", "which camera of a file of Kalibr; empty: its first"}, k.camera_name);
  v({"mount", "position and orientation of the camera on the aircraft"}, k.mount);
  v({"image", "image sensor and lens; the frame rate of a camera that is triggered is that of its trigger"},
    k.image);
  v({"trigger",
     "free: by its own clock; main or the name of another of these cameras: by the clock of that, at the "
     "very "
     "instants, whether its own frames come or not"},
    k.trigger);
  v({"phase_s", "first exposure of a camera with a clock of its own"}, k.timing.phase_s, 0.0, 10.0);
  v({"drift_ppm", "how much faster its clock goes than the flight's, millionths"}, k.timing.drift_ppm,
    -10000.0, 10000.0);
}

// The further cameras of a scenario with what they name. keys: those that are triggered get the rate of their
// trigger. image: of the main camera. beside: where files are looked for.
std::vector<sim::CarriedCameraParameters> LoadCameras(std::vector<CameraKeys>& keys,
                                                      const sim::ImageParameters& image,
                                                      const std::filesystem::path& beside,
                                                      const Config& config, Mistakes& mistakes);

// The IMU of a scenario as far as its key `file` says, before the scenario's own words: with the whole path.
// None: there is no such key.
std::optional<sim::ImuParameters> ImuOfFile(const Config& scenario, const std::filesystem::path& beside,
                                            Mistakes& mistakes);

// What their numbers do not allow together.
void CheckInstruments(const sim::InstrumentParameters& instruments, const Place& where, Mistakes& mistakes);

}  // namespace kestrel::flight
