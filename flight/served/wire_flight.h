// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "control/autopilot.h"
#include "geometry/truth.h"
#include "records/telemetry/flight_log.h"

// A flight of the simulated aircraft, in real time, by the program for real aircraft: another process, which
// knows the aircraft by its wire and its camera by the video stream alone; and what may befall either.
namespace kestrel::flight {

enum class Wire { kMavlink, kAfcs, kAscTec };
inline constexpr Wire kWires[] = {Wire::kMavlink, Wire::kAfcs, Wire::kAscTec};
const char* NameOf(Wire wire);  // as `kestrel fly` has it: "mavlink"

enum class WireFault {
  kNone,
  kLinkCut,       // nothing passes any more between the autopilot and the program
  kCameraCut,     // no image comes any more
  kServerKilled,  // both, at once: the simulator's process is killed
  kLost,          // of datagrams in both directions, 30 %
  kDoubled,       // each one
  kReordered,     // each late by something between 0 and 50 ms: most are overtaken
  kDelayed,       // each by 200 ms
};

struct WireFlightOptions {
  Wire wire = Wire::kMavlink;
  std::string dialect = "px4";  // of MAVLink; or "ardupilot"
  std::uint64_t seed = 1;
  std::string scenario = "landing";
  std::vector<std::string> overrides;  // of the scenario that is served, "key.path=value"
  std::vector<std::string> plan;       // of the one that the program flies, as its --set
  std::vector<std::string> aircraft;   // of the program's aircraft, as its --set-aircraft
  WireFault fault = WireFault::kNone;
  double fault_after_s = 1;           // since the program's first setpoint was followed
  std::optional<double> end_after_s;  // the same since the fault; none: once it has landed
  // The program is interrupted, as by Ctrl-C, so long after its first setpoint was followed; then the aircraft is
  // watched for kWatchEnd_s after it has ended. None: it is not.
  std::optional<double> stop_after_s;
  std::filesystem::path folder;  // served/ and flown/ come to lie there
};
inline constexpr double kWatchEnd_s = 4;  // longer than any time-out of an autopilot (ArduPilot, 3 s)

// Times of this computer's monotonic clock.
struct PublishedImage {
  double due_s = 0, t_s = 0;  // when it should have been given to the stream, and when it was
};
struct ReceivedSetpoint {  // that differs from the one before, handed to the emulated aircraft
  double t_s = 0;
  control::Setpoint setpoint;
};
struct FlownImage {  // a line of the program's telemetry
  std::int64_t sequence = 0;
  double came_s = 0, decided_s = 0;
  std::optional<control::VelocitySetpoint> setpoint;  // as it was handed to the safety layer
  std::string phase;
};
struct FlownEvent {  // a line of the program's events.log
  double t_s = 0;
  std::string what, is;
};
struct TruthSample {
  double t_s = 0;
  Eigen::Vector3d v_N = Eigen::Vector3d::Zero();
  bool touching = false;
  Eigen::Vector3d p_NB = Eigen::Vector3d::Zero();
};

struct WireFlown {
  // Of the serving side; of one that was killed nothing.
  records::Summary served;
  std::vector<PublishedImage> published;
  std::vector<ReceivedSetpoint> heard;
  std::vector<TruthSample> truth;   // at each image's due time
  std::optional<double> fault_s;    // when it began; none: the flight was over before
  std::optional<double> stopped_s;  // when the program was interrupted
  std::optional<double> ended_s;    // when it was gone after that: the wire was silent then
  // Of the program.
  std::optional<int> status;  // its exit; none: it had to be killed
  int starts = 1;             // it is started again where its check list is not met
  std::vector<FlownImage> images;
  std::vector<FlownEvent> events;
  std::string output;

  bool Landed() const;
  double TouchdownError_m() const;  // infinite: it never touched
  // How far the aircraft came from where it was at the one time until the other, by the truth; upright: up and down
  // alone. NaN: it was not watched between them.
  double Motion_m(std::optional<double> from_s, std::optional<double> until_s, bool upright) const;
  double Stretched_s() const;  // given up by a machine that was too slow
};

// The program for real aircraft: KESTREL_HARDWARE_PROGRAM of the environment, or kestrel-fly beside this program.
// Throws InputError with the remedy: it is not there.
std::filesystem::path HardwareProgram();

// Throws InputError and std::runtime_error: it could not even begin.
WireFlown FlyOverWire(const WireFlightOptions& options);

// The latency that the path from an image to the setpoint made of it adds, in s, one for each image whose
// setpoint was recognised. From when the image was given to the stream until the first setpoint made of it
// was handed to the emulated aircraft; both on the serving side, by one clock.
//
// Which image it was is told by order: the program numbers the images that come, in the order in which they
// were sent, and each is the latest one for which neither it nor a later one has come before it was sent. An
// image lost on the way makes none seem faster; an image is taken for a later one only where all that follow,
// to the end of the flight, have taken longer than a period to come.
// Which setpoint it was is told by values: the first that differs from the one before and is nearest to what
// the program's telemetry says of that image, of those that it had decided on by then. AscTec's CTRL_INPUTs
// are attitudes, made anew of each state: there it is the first that can have left after the decision, by the
// time that it takes on the line of 57600 baud; one already waiting for the reader may be taken for it, which
// is too early by 2 ms at most.
//
// Left out: how late the simulator gives its images (PublishedImage tells it), and images whose setpoint
// cannot be told from the one before.
std::vector<double> AddedLatency_s(const WireFlown& flown, Wire wire);

}  // namespace kestrel::flight
