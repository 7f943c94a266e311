// SPDX-License-Identifier: Apache-2.0
#include "bench/lockstep/bench_lockstep.h"

#include <fmt/format.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <thread>

#include "base/process/child_process.h"
#include "base/process/own_program.h"
#include "base/statistics.h"
#include "base/stopwatch.h"
#include "flight/stepped/sim.h"
#include "records/summary.h"

namespace kestrel::bench {
namespace {

using Json = nlohmann::json;

constexpr int kSteps = 1'000'000, kFrames = 300;
constexpr double kTarget_ms = 0.2, kPatience_s = 30;
const std::vector<std::string> kOverrides = {"seed=1", "start.settle_s=0", "duration_s=5000"};

std::filesystem::path TemporaryFolder() {
  std::string name = (std::filesystem::temp_directory_path() / "kestrel_XXXXXX").string();
  if (!mkdtemp(name.data())) throw std::runtime_error("no temporary folder: " + name);
  return name;
}

class Client {
 public:
  explicit Client(const std::filesystem::path& at) {
    sockaddr_un place{};
    place.sun_family = AF_UNIX;
    at.string().copy(place.sun_path, sizeof place.sun_path - 1);
    const double until_s = MonotonicNow_s() + kPatience_s;
    for (;;) {
      socket_ = socket(AF_UNIX, SOCK_STREAM, 0);
      if (connect(socket_, reinterpret_cast<sockaddr*>(&place), sizeof place) == 0) break;
      close(socket_);
      if (MonotonicNow_s() > until_s) throw std::runtime_error("no server listens at " + at.string());
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    Ask("hello", {{"version", 1}});
  }
  ~Client() { close(socket_); }
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;

  Json Ask(const char* request, Json keys = Json::object()) {
    keys["request"] = request;
    keys["token"] = token_;
    const std::string json = keys.dump();
    const auto size = static_cast<std::uint32_t>(json.size());
    std::string bytes(sizeof size, '\0');
    std::memcpy(bytes.data(), &size, sizeof size);  // of a processor that is little-endian
    bytes += json;
    if (send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL) != static_cast<ssize_t>(bytes.size()))
      throw std::runtime_error("the server has gone");
    Json reply = Json::parse(Read());
    if (reply["ok"] != true) throw std::runtime_error(reply["error"]["message"]);
    token_ = reply["token"];
    return reply;
  }

 private:
  std::string Read() {
    std::uint32_t size = 0;
    ReadTo(reinterpret_cast<char*>(&size), sizeof size);
    std::string text(size, '\0');
    ReadTo(text.data(), size);
    return text;
  }
  void ReadTo(char* to, std::size_t size) {
    while (size > 0) {
      const ssize_t more = recv(socket_, to, size, 0);
      if (more <= 0) throw std::runtime_error("the server has gone");
      to += more;
      size -= static_cast<std::size_t>(more);
    }
  }

  int socket_ = -1;
  std::uint64_t token_ = 0;
};

// Each another, so that a step which is lost or doubled flies another flight.
control::VelocitySetpoint SetpointOf(int step) { return {{0.3 * std::sin(1e-3 * step), 0, 0}, 0}; }
Json JsonOf(const control::VelocitySetpoint& s) {
  return {
      {"kind", "velocity"}, {"v_H_m_s", {s.v_H.x(), s.v_H.y(), s.v_H.z()}}, {"yaw_rate_rad_s", s.yaw_rate}};
}

void AddTrips(const std::string& what, const std::vector<double>& trips_ms,
              std::vector<records::Figure>& table) {
  table.push_back({what + ", median", Quantile(trips_ms, 0.5), "ms", kTarget_ms, false, ""});
  table.push_back({what + ", mean", Mean(trips_ms), "ms", {}, false, ""});
  table.push_back({what + ", 99th percentile", Quantile(trips_ms, 0.99), "ms", {}, false, ""});
}

// Of each request what it took beside the simulator.
template <class Ask>
void Trip(std::vector<double>& trips_ms, Ask ask) {
  const auto began = std::chrono::steady_clock::now();
  const Json reply = ask();
  trips_ms.push_back(1e3 * (SecondsSince(began) - reply["simulator_s"].get<double>()));
}

void BenchSteps(Client& client, std::vector<records::Figure>& table) {
  Json now = client.Ask("reset", {{"images", false}, {"records", false}});
  const double dt_s = now["dt_s"], from_s = now["t_s"];
  std::vector<double> trips_ms;
  trips_ms.reserve(kSteps);
  const auto began = std::chrono::steady_clock::now();
  for (int i = 0; i < kSteps; ++i)
    Trip(trips_ms, [&] {
      now = client.Ask("advance", {{"duration_s", dt_s}, {"setpoint", JsonOf(SetpointOf(i))}});
      return now;
    });
  const double by_socket_s = SecondsSince(began);
  const double flown = (now["t_s"].get<double>() - from_s) / dt_s;
  const Json summary = client.Ask("summary")["summary"];

  SimOptions options;
  options.overrides = kOverrides;
  options.images = false;
  Sim sim("hover", options);
  sim.Reset();
  const auto began_alone = std::chrono::steady_clock::now();
  for (int i = 0; i < kSteps; ++i) sim.Advance(sim.dt_s(), SetpointOf(i));
  const double alone_s = SecondsSince(began_alone);

  AddTrips("one step of the physics, no images: round trip", trips_ms, table);
  table.push_back({"the same by the time of all beside a Sim alone",
                   1e3 * (by_socket_s - alone_s) / kSteps,
                   "ms",
                   {},
                   false,
                   ""});
  table.push_back({"steps of the physics, by socket", kSteps / by_socket_s, "1/s", {}, false, ""});
  table.push_back({"the same by a Sim alone", kSteps / alone_s, "1/s", {}, false, ""});
  table.push_back({fmt::format("steps lost or doubled of {}", kSteps), std::abs(std::round(flown) - kSteps),
                   "", 0, false, ""});
  const bool same = summary["state_hash"] == Json::parse(records::ToJson(sim.Summarise()))["state_hash"];
  table.push_back({"hash of all states as of a Sim alone", same ? 1.0 : 0.0, "of 1", 1, true, ""});
}

void BenchFrames(Client& client, std::vector<records::Figure>& table) {
  Json now = client.Ask("reset", {{"records", false}});
  std::vector<double> trips_ms;
  for (int i = 0; i < kFrames; ++i)
    Trip(trips_ms, [&] {
      now = client.Ask("step", {{"setpoint", JsonOf(SetpointOf(i))}});
      return now;
    });
  AddTrips(
      fmt::format("one frame of {} x {}, shared memory: round trip",
                  now["frame"]["image"]["shape"][1].get<int>(), now["frame"]["image"]["shape"][0].get<int>()),
      trips_ms, table);
}

}  // namespace

void BenchLockstep(std::vector<records::Figure>& table) {
  const std::filesystem::path folder = TemporaryFolder(), at = folder / "socket";
  {
    std::vector<std::string> command = {OwnProgram(), "serve", "hover", "--once", "--lockstep", at};
    for (const std::string& each : kOverrides) command.insert(command.end(), {"--set", each});
    ChildProcess server(command, {}, folder / "said.txt");
    Client client(at);
    BenchFrames(client, table);
    BenchSteps(client, table);
    client.Ask("bye");
  }
  std::filesystem::remove_all(folder);
}

}  // namespace kestrel::bench
