// SPDX-License-Identifier: Apache-2.0
#include "flight/served/wire_flight.h"

#include <fmt/format.h>
#include <netinet/in.h>
#include <signal.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <limits>
#include <map>
#include <memory>
#include <mutex>
#include <set>
#include <sstream>
#include <thread>

#include "base/diagnostics.h"
#include "base/file/model_files.h"
#include "base/process/child_process.h"
#include "base/process/own_program.h"
#include "base/real_time.h"
#include "base/stopwatch.h"
#include "control/link/network_address.h"
#include "control/wire/asctec_units.h"
#include "flight/served/serve_arguments.h"
#include "flight/served/serve_flight.h"
#include "flight/simulated/scenario.h"
#include "sim/server/camera_server.h"
#include "sim/server/udp_relay.h"
#include "vision/capture/rtp_stream.h"

namespace kestrel::flight {
namespace {

constexpr double kMaxFlight_s = 120;  // of a flight
constexpr int kMaxStarts = 3;         // of a program whose check list is not met by a machine that is busy
constexpr double kReleases_s = 20;    // an interrupted program's release of the aircraft, and its records
constexpr double kBegins_s = 60;      // until the program's first setpoint is followed, check list and all

// A port that nobody listens on, and that is not given out again.
int FreePort() {
  static std::mutex mutex;
  static std::set<int> given;
  const std::lock_guard lock(mutex);
  for (;;) {
    const int probe = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    socklen_t size = sizeof address;
    const bool bound = probe >= 0 && bind(probe, reinterpret_cast<sockaddr*>(&address), size) == 0 &&
                       getsockname(probe, reinterpret_cast<sockaddr*>(&address), &size) == 0;
    if (probe >= 0) close(probe);
    if (!bound) throw std::runtime_error("no UDP port is free");
    if (given.insert(ntohs(address.sin_port)).second) return ntohs(address.sin_port);
  }
}

sim::LineFaults OnTheLine(WireFault fault) {
  switch (fault) {
    case WireFault::kLinkCut:
      return {.cut = true};
    case WireFault::kLost:
      return {.lost = 0.3};
    case WireFault::kDoubled:
      return {.doubled = 1};
    case WireFault::kReordered:
      return {.scatter_s = 0.05};
    case WireFault::kDelayed:
      return {.delay_s = 0.2};
    default:
      return {};
  }
}

bool Same(const control::Setpoint& a, const control::Setpoint& b) {
  if (a.index() != b.index()) return false;
  if (const auto* v = std::get_if<control::VelocitySetpoint>(&a)) {
    const auto& w = std::get<control::VelocitySetpoint>(b);
    return v->v_H == w.v_H && v->yaw_rate == w.yaw_rate;
  }
  if (const auto* p = std::get_if<control::PositionSetpoint>(&a)) {
    const auto& q = std::get<control::PositionSetpoint>(b);
    return p->p_N == q.p_N && p->yaw == q.yaw;
  }
  if (const auto* r = std::get_if<control::RateSetpoint>(&a)) {
    const auto& s = std::get<control::RateSetpoint>(b);
    return r->w_B == s.w_B && r->thrust == s.thrust;
  }
  const auto &t = std::get<control::AttitudeSetpoint>(a), &u = std::get<control::AttitudeSetpoint>(b);
  return t.roll == u.roll && t.pitch == u.pitch && t.yaw_rate == u.yaw_rate && t.thrust == u.thrust;
}

// A server that is listened to, and that may be unplugged.
class OverheardServer final : public sim::AutopilotServer {
 public:
  OverheardServer(sim::AutopilotServer& server, std::vector<ReceivedSetpoint>& heard)
      : server_(server), heard_(heard) {}

  void Serve(double now_s, control::Autopilot& aircraft) override {
    time_.Due(now_s, std::exchange(served_t_s_, aircraft.State().t_s));
    Ear ear(*this, aircraft);
    if (!unplugged) server_.Serve(now_s, ear);
  }
  void SetPilot(bool allows) override { server_.SetPilot(allows); }
  const sim::WireCounts& Received() const override { return server_.Received(); }
  std::string Where() const override { return server_.Where(); }

  void Begin() { time_ = RealTime(MonotonicNow_s()); }  // when the serving loop's clock does
  double WallOf(double t_s) const { return time_.WallOf(t_s); }
  std::optional<double> first_s;  // when the first setpoint was followed
  bool unplugged = false;

 private:
  struct Ear final : control::Autopilot {
    Ear(OverheardServer& its, control::Autopilot& the_aircraft) : whose(its), aircraft(the_aircraft) {}
    control::VehicleState State() const override { return aircraft.State(); }
    void Send(const control::Setpoint& setpoint) override {
      const double now_s = MonotonicNow_s();
      if (!whose.first_s) whose.first_s = now_s;
      if (whose.heard_.empty() || !Same(whose.heard_.back().setpoint, setpoint))
        whose.heard_.push_back({now_s, setpoint});
      aircraft.Send(setpoint);
    }
    void Aid(const control::AttitudeAid& aid) override { aircraft.Aid(aid); }
    OverheardServer& whose;
    control::Autopilot& aircraft;
  };

  sim::AutopilotServer& server_;
  std::vector<ReceivedSetpoint>& heard_;
  RealTime time_{0};  // as the serving loop has it
  double served_t_s_ = 0;
};

ServeArguments ServerFor(const WireFlightOptions& o) {
  ServeArguments a;
  a.scenario = o.scenario;
  a.seed = fmt::format("{}", o.seed);
  a.overrides = o.overrides;
  if (o.wire == Wire::kMavlink) a.mavlink = o.dialect, a.mavlink_port = 0;
  if (o.wire == Wire::kAfcs) a.afcs = "127.0.0.1:0";
  a.asctec = o.wire == Wire::kAscTec;
  return a;
}

LoadedScenario Load(const WireFlightOptions& o) {
  std::vector<std::string> overrides = o.overrides;
  overrides.push_back(fmt::format("seed={}", o.seed));
  overrides.push_back(fmt::format("duration_s={}", kMaxFlight_s));
  return LoadScenario(o.scenario, overrides);
}

double BeforeStamp_s(const LoadedScenario& loaded) {
  return loaded.scenario.image.latency_s + vision::RtpDelay_s(vision::RtpStream::Coding::kJpeg);
}

std::unique_ptr<ChildProcess> StartProgram(const WireFlightOptions& o, const std::string& autopilot,
                                           int camera_port, double before_stamp_s) {
  std::vector<std::string> command = {HardwareProgram(),
                                      "fly",
                                      o.scenario,
                                      "--camera",
                                      fmt::format("rtp://127.0.0.1:{}", camera_port),
                                      "--no-video",
                                      "--out",
                                      o.folder / "flown",
                                      "--for",
                                      fmt::format("{}", kMaxFlight_s),
                                      "--set-aircraft",
                                      fmt::format("camera.exposure_before_stamp_s={:.4f}", before_stamp_s)};
  if (o.wire == Wire::kMavlink) command.push_back("--take-control");
  if (o.wire == Wire::kAfcs) command.push_back("--pilot-untold");
  for (const std::string& each : o.plan) {
    command.push_back("--set");
    command.push_back(each);
  }
  for (const std::string& each : o.aircraft) {
    command.push_back("--set-aircraft");
    command.push_back(each);
  }
  command.push_back("--autopilot");
  command.push_back(fmt::format("{}:{}", NameOf(o.wire), autopilot));
  return std::make_unique<ChildProcess>(command, std::vector{"KESTREL_ROOT=" + Root().string()},
                                        o.folder / "flown.txt");
}

std::vector<std::vector<std::string>> ReadTable(const std::filesystem::path& file) {
  std::vector<std::vector<std::string>> table;
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    std::vector<std::string>& row = table.emplace_back();
    std::istringstream words(line);
    for (std::string word; std::getline(words, word, ',');) row.push_back(word);
  }
  return table;
}

double NumberOf(const std::string& text) {
  return text.empty() ? std::numeric_limits<double>::quiet_NaN() : std::strtod(text.c_str(), nullptr);
}

void ReadEvents(const std::filesystem::path& file, WireFlown& flown) {
  std::ifstream in(file);
  for (std::string line; std::getline(in, line);) {
    const std::size_t unit = line.find(" s  "), colon = line.find(": ");
    if (unit == std::string::npos || colon == std::string::npos || colon < unit) continue;
    flown.events.push_back(
        {NumberOf(line.substr(0, unit)), line.substr(unit + 4, colon - unit - 4), line.substr(colon + 2)});
  }
}

// What the program left behind, on the monotonic clock.
void ReadRecords(const std::filesystem::path& folder, double before_stamp_s, WireFlown& flown) {
  ReadEvents(folder / "events.log", flown);
  double begun_s = std::numeric_limits<double>::quiet_NaN();
  for (const FlownEvent& event : flown.events)
    if (event.what == "clock") begun_s = NumberOf(event.is);
  for (FlownEvent& event : flown.events) event.t_s += begun_s;

  const auto table = ReadTable(folder / "telemetry.csv");
  if (table.empty()) return;
  std::map<std::string, std::size_t> column;
  for (const std::string& name : table.front()) column.emplace(name, column.size());
  for (std::size_t i = 1; i < table.size(); ++i) {
    const auto cell = [&](const char* name) {
      const std::size_t k = column.at(name);
      return k < table[i].size() ? table[i][k] : std::string();
    };
    FlownImage image;
    image.sequence = static_cast<std::int64_t>(NumberOf(cell("sequence")));
    image.came_s = begun_s + NumberOf(cell("exposure_t_s")) + before_stamp_s;
    image.decided_s = begun_s + NumberOf(cell("t_s"));
    image.phase = cell("phase");
    if (!cell("setpoint_vx_m_s").empty())
      image.setpoint =
          control::VelocitySetpoint{{NumberOf(cell("setpoint_vx_m_s")), NumberOf(cell("setpoint_vy_m_s")),
                                     NumberOf(cell("setpoint_vz_m_s"))},
                                    NumberOf(cell("setpoint_yaw_rate_deg_s")) * M_PI / 180};
    flown.images.push_back(std::move(image));
  }
}

void EndProgram(ChildProcess& program, WireFlown& flown) {
  program.Signal(SIGINT);
  flown.status = program.Wait(20);
  flown.output = program.Output();
}

// The simulator in this process.
WireFlown FlyHere(const WireFlightOptions& o) {
  const LoadedScenario loaded = Load(o);
  const double before_stamp_s = BeforeStamp_s(loaded);
  Mistakes mistakes;
  const std::vector<NamedServer> servers = MakeServers(ServerFor(o), loaded, nullptr, mistakes);
  mistakes.ThrowIfAny();
  WireFlown flown;
  OverheardServer server(*servers.front().server, flown.heard);
  std::string where = server.Where();
  std::unique_ptr<sim::UdpRelay> relay;
  if (o.wire != Wire::kAscTec && o.fault != WireFault::kNone) {
    const control::UdpAddress address = control::ParseUdpAddress(where);
    relay = std::make_unique<sim::UdpRelay>(address.host, address.port, o.seed);
    where = fmt::format("udp://127.0.0.1:{}", relay->port());
  }
  vision::RtpStream stream;
  stream.port = FreePort();
  const vision::CameraModel& model = loaded.simulator.camera;
  sim::CameraServer camera(stream, {vision::WidthPx(model), vision::HeightPx(model)},
                           loaded.scenario.image.rate_hz, loaded.simulator.image.colour);
  bool camera_cut = false;
  std::vector<double> frames_s;  // when each was there, also of a camera that is cut

  std::unique_ptr<ChildProcess> program;
  std::optional<double> ended_s;
  ServeOptions options;
  options.folder = o.folder / "served";
  options.servers = {&server};
  options.publish = [&](const vision::Frame& frame) {
    const double now_s = MonotonicNow_s();
    frames_s.push_back(now_s);
    if (camera_cut) return;
    const std::int64_t before = camera.overwritten();
    camera.Publish(frame.image);
    // The one before had not been sent yet, and is not any more.
    if (camera.overwritten() > before && !flown.published.empty()) flown.published.pop_back();
    flown.published.push_back({server.WallOf(frame.t_s + loaded.scenario.image.latency_s), now_s});
  };
  const double made_s = MonotonicNow_s();
  options.begun = [&] {
    server.Begin();
    program = StartProgram(o, where, stream.port, before_stamp_s);
  };
  options.go_on = [&] {
    const double now_s = MonotonicNow_s();
    if (!server.first_s && now_s > made_s + kBegins_s) return false;
    if (o.fault != WireFault::kNone && !flown.fault_s && server.first_s &&
        now_s >= *server.first_s + o.fault_after_s) {
      flown.fault_s = now_s;
      if (relay) relay->Set(OnTheLine(o.fault));
      if (o.fault == WireFault::kLinkCut) server.unplugged = true;
      if (o.fault == WireFault::kCameraCut) camera_cut = true;
    }
    if (!flown.stopped_s && o.stop_after_s && server.first_s && now_s >= *server.first_s + *o.stop_after_s) {
      flown.stopped_s = now_s;
      program->Signal(SIGINT);
    }
    if (flown.stopped_s) {
      if (!flown.ended_s && program->Ended()) flown.ended_s = now_s;
      return now_s < flown.ended_s.value_or(*flown.stopped_s + kReleases_s) + kWatchEnd_s;
    }
    if (flown.fault_s && o.end_after_s && now_s >= *flown.fault_s + *o.end_after_s) return false;
    // Having landed, it leaves first, and the aircraft is watched while it stands.
    if (program->Ended() && !server.first_s && flown.starts < kMaxStarts) {
      ++flown.starts;
      program = StartProgram(o, where, stream.port, before_stamp_s);
    }
    if (!ended_s && program->Ended()) ended_s = now_s;
    return !ended_s || (*program->Ended() == 0 && now_s < *ended_s + 10);
  };
  FlightResult result = ServeFlight(loaded, options);
  if (!program) throw std::runtime_error(result.summary.error);
  EndProgram(*program, flown);
  flown.served = std::move(result.summary);
  for (std::size_t i = 0; i < std::min(frames_s.size(), result.rows.size()); ++i)
    flown.truth.push_back(
        {frames_s[i], result.rows[i].now.v_N, result.rows[i].now.touching, result.rows[i].now.X_NB.p});
  ReadRecords(o.folder / "flown", before_stamp_s, flown);
  return flown;
}

void Sleep() { std::this_thread::sleep_for(std::chrono::milliseconds(10)); }

// The simulator in a process of its own, which is killed.
WireFlown FlyAgainstProcess(const WireFlightOptions& o) {
  const LoadedScenario loaded = Load(o);
  const int camera_port = FreePort();
  const char* given = std::getenv("KESTREL_PROGRAM");
  std::vector<std::string> command = {given ? given : OwnProgram().string(),
                                      "serve",
                                      o.scenario,
                                      "--seed",
                                      fmt::format("{}", o.seed),
                                      "--camera",
                                      fmt::format("rtp:{}", camera_port),
                                      "--out",
                                      o.folder / "served"};
  for (const std::string& each : o.overrides) {
    command.push_back("--set");
    command.push_back(each);
  }
  if (o.wire == Wire::kMavlink)
    command.insert(command.end(), {"--mavlink", o.dialect, "--mavlink-port", "0"});
  if (o.wire == Wire::kAfcs) command.insert(command.end(), {"--afcs", "127.0.0.1:0"});
  if (o.wire == Wire::kAscTec) command.push_back("--asctec");
  ChildProcess server(command, {"KESTREL_ROOT=" + Root().string()}, o.folder / "served.txt");

  const auto until = [&](const std::string& said, double max_s) {
    const double until_s = MonotonicNow_s() + max_s;
    while (server.Output().find(said) == std::string::npos) {
      if (server.Ended() || MonotonicNow_s() > until_s) return false;
      Sleep();
    }
    return true;
  };
  const std::string key = fmt::format("--autopilot {}:", NameOf(o.wire));
  if (!until("to fly it:", kBegins_s) || !until(key, 1))
    throw std::runtime_error("the serving process did not begin: " + server.Output());
  const std::string said = server.Output();
  std::istringstream rest(said.substr(said.find(key) + key.size()));
  std::string where;
  rest >> where;
  WireFlown flown;
  const double before_stamp_s = BeforeStamp_s(loaded);
  const auto program = StartProgram(o, where, camera_port, before_stamp_s);
  if (until("client: its first setpoint", kBegins_s)) {
    const double kill_s = MonotonicNow_s() + o.fault_after_s;
    while (MonotonicNow_s() < kill_s && !server.Ended() && !program->Ended()) Sleep();
    flown.fault_s = MonotonicNow_s();
    server.Signal(SIGKILL);
    const double end_s = *flown.fault_s + o.end_after_s.value_or(1);
    while (MonotonicNow_s() < end_s && !program->Ended()) Sleep();
  }
  EndProgram(*program, flown);
  ReadRecords(o.folder / "flown", before_stamp_s, flown);
  return flown;
}

}  // namespace

const char* NameOf(Wire wire) {
  switch (wire) {
    case Wire::kMavlink:
      return "mavlink";
    case Wire::kAfcs:
      return "afcs";
    case Wire::kAscTec:
      return "asctec";
  }
  return "?";
}

bool WireFlown::Landed() const { return served.outcome == "landed"; }

double WireFlown::TouchdownError_m() const {
  const auto found = served.metrics.find("touchdown_error_m");
  return found != served.metrics.end() ? found->second : std::numeric_limits<double>::infinity();
}

double WireFlown::Motion_m(std::optional<double> from_s, std::optional<double> until_s, bool upright) const {
  double motion_m = std::numeric_limits<double>::quiet_NaN();
  if (!from_s || !until_s) return motion_m;
  std::optional<Eigen::Vector3d> from_N;
  for (const TruthSample& sample : truth) {
    if (sample.t_s < *from_s || sample.t_s > *until_s) continue;
    if (!from_N) from_N = sample.p_NB, motion_m = 0;
    const Eigen::Vector3d way = sample.p_NB - *from_N;
    motion_m = std::max(motion_m, upright ? std::abs(way.z()) : way.norm());
  }
  return motion_m;
}

double WireFlown::Stretched_s() const {
  const auto found = served.metrics.find("stretched_s");
  return found != served.metrics.end() ? found->second : 0;
}

std::filesystem::path HardwareProgram() {
  std::vector<std::filesystem::path> programs;
  if (const char* given = std::getenv("KESTREL_HARDWARE_PROGRAM")) {
    programs = {given};
  } else {
    programs = {OwnProgram().parent_path() / "kestrel-fly"};
  }
  for (const auto& program : programs)
    if (access(program.c_str(), X_OK) == 0) return program;
  throw InputError(programs.back().string(), "the program for real aircraft is not there",
                   "`./kestrel fly --help` builds it, or say in KESTREL_HARDWARE_PROGRAM where it is");
}

WireFlown FlyOverWire(const WireFlightOptions& options) {
  HardwareProgram();
  std::filesystem::create_directories(options.folder);
  return options.fault == WireFault::kServerKilled ? FlyAgainstProcess(options) : FlyHere(options);
}

std::vector<double> AddedLatency_s(const WireFlown& flown, Wire wire) {
  constexpr double kSlack_s = 0.001;   // between the decision's own time and the sending
  constexpr double kRecognised = 0.1;  // m/s, beyond what the wire rounds off
  const double line_s =
      wire == Wire::kAscTec ? control::wire::LineTime_s(control::wire::kCtrlInputBytes) : -kSlack_s;
  const auto& images = flown.images;
  const auto& published = flown.published;
  if (images.empty() || published.empty()) return {};

  // The number of each among the published. Images can be lost on the way, never made.
  std::vector<std::int64_t> number(images.size());
  std::int64_t offset = std::numeric_limits<std::int64_t>::max();
  for (std::size_t k = images.size(); k-- > 0;) {
    const auto after = std::upper_bound(published.begin(), published.end(), images[k].came_s,
                                        [](double t_s, const PublishedImage& p) { return t_s < p.t_s; });
    offset = std::min(offset, after - published.begin() - 1 - images[k].sequence);
    number[k] = images[k].sequence + offset;
  }
  std::vector<bool> done(images.size(), false);
  std::vector<double> latency_s;
  for (const ReceivedSetpoint& heard : flown.heard) {
    const auto after = std::upper_bound(images.begin(), images.end(), heard.t_s - line_s,
                                        [](double t_s, const FlownImage& i) { return t_s < i.decided_s; });
    std::optional<std::size_t> best;
    double least = kRecognised;
    const std::size_t newest = static_cast<std::size_t>(after - images.begin());
    for (std::size_t back = 1; back <= 3 && back <= newest; ++back) {
      const std::size_t k = newest - back;
      if (!images[k].setpoint) break;
      if (std::holds_alternative<control::AttitudeSetpoint>(heard.setpoint)) {
        best = k;
        break;
      }
      const auto* velocity = std::get_if<control::VelocitySetpoint>(&heard.setpoint);
      if (!velocity) break;
      const double difference = (velocity->v_H - images[k].setpoint->v_H).norm() +
                                std::abs(velocity->yaw_rate - images[k].setpoint->yaw_rate);
      if (difference < least) least = difference - 1e-6, best = k;
    }
    if (!best || done[*best]) continue;
    done[*best] = true;
    if (number[*best] < 0) continue;
    latency_s.push_back(heard.t_s - published[static_cast<std::size_t>(number[*best])].t_s);
  }
  return latency_s;
}

}  // namespace kestrel::flight
