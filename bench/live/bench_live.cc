// SPDX-License-Identifier: Apache-2.0
#include "bench/live/bench_live.h"

#include <fmt/format.h>

#include <algorithm>
#include <boost/asio/io_context.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/websocket.hpp>
#include <cmath>
#include <cstdint>
#include <list>
#include <memory>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <thread>
#include <utility>

#include "base/statistics.h"
#include "base/stopwatch.h"
#include "flight/live/live.h"
#include "flight/live/pace.h"
#include "flight/simulated/runner.h"

namespace kestrel::bench {
namespace {

namespace beast = boost::beast;
namespace websocket = beast::websocket;
using boost::asio::ip::tcp;
using Json = nlohmann::json;

constexpr char kScenario[] = "hover";
constexpr int kPairs = 5;
constexpr double kMostDelay_ms = 100, kMostCost_percent = 3;

// The number in http://ADDRESS:PORT/.
std::string PortOf(const std::string& url) {
  const std::size_t colon = url.rfind(':');
  return url.substr(colon + 1, url.find('/', colon) - colon - 1);
}

// When each row came to a viewer who takes all that there is.
class Viewer {
 public:
  struct Come {
    double t_s, at_s;  // of the flight, and of the clock
  };

  explicit Viewer(const std::string& port) : stream_(io_) {
    Connect(port);
    thread_ = std::thread([this] { Read(); });
  }
  ~Viewer() {
    if (thread_.joinable()) thread_.join();
  }
  // Once the server has gone.
  std::vector<Come> Rows() {
    thread_.join();
    std::vector<Come> rows;
    std::size_t time = 0;  // its column
    for (const auto& [text, at_s] : texts_) {
      const Json message = Json::parse(text);
      if (message["op"] == "columns") {
        const Json& names = message["names"];
        time = static_cast<std::size_t>(std::find(names.begin(), names.end(), "t_s") - names.begin());
      }
      if (message["op"] != "rows") continue;
      for (const Json& row : message["rows"]) rows.push_back({row.at(time).get<double>(), at_s});
    }
    return rows;
  }

 private:
  void Connect(const std::string& port) {
    tcp::resolver resolver(io_);
    boost::asio::connect(beast::get_lowest_layer(stream_), resolver.resolve("127.0.0.1", port));
    stream_.read_message_max(0);
    stream_.handshake("127.0.0.1:" + port, "/live");
  }
  // What is to be measured is not what it makes of them.
  void Read() {
    try {
      for (;;) {
        beast::flat_buffer buffer;
        stream_.read(buffer);
        const double at_s = MonotonicNow_s();
        if (stream_.got_text()) texts_.emplace_back(beast::buffers_to_string(buffer.data()), at_s);
      }
    } catch (const beast::system_error&) {}
  }

  boost::asio::io_context io_;
  websocket::stream<tcp::socket> stream_;
  std::vector<std::pair<std::string, double>> texts_;  // and when they came
  std::thread thread_;
};

// One who asks for the flight and takes nothing of it.
class FrozenViewer {
 public:
  explicit FrozenViewer(const std::string& port) : stream_(io_) {
    tcp::socket& socket = beast::get_lowest_layer(stream_);
    socket.open(tcp::v4());
    socket.set_option(boost::asio::socket_base::receive_buffer_size(4096));
    socket.connect({boost::asio::ip::address_v4::loopback(), static_cast<std::uint16_t>(std::stoi(port))});
    stream_.handshake("127.0.0.1:" + port, "/live");
  }

 private:
  boost::asio::io_context io_;
  websocket::stream<tcp::socket> stream_;
};

struct Flown {
  double real_time_factor = 0;
  std::uint64_t state_hash = 0, image_hash = 0;
  std::vector<double> delays_ms;  // of each row to each viewer
};

struct Watched {
  int viewers = 0, frozen = 0;
  double speed = flight::Pace::kAsFast;
};

// watched: null: nobody could.
Flown Fly(const flight::LoadedScenario& loaded, const std::filesystem::path& folder, const Watched* watched) {
  flight::RunOptions options;
  options.folder = folder;
  options.video = false;
  std::list<Viewer> viewers;  // who end when the server has gone
  std::list<FrozenViewer> frozen;
  std::unique_ptr<flight::Live> live;
  if (watched) {
    flight::LiveOptions of_live;
    of_live.server.port = 0;
    of_live.speed = watched->speed;
    live = std::make_unique<flight::Live>(of_live);
    options.live = live.get();
    for (int i = 0; i < watched->viewers; ++i) viewers.emplace_back(PortOf(live->url()));
    for (int i = 0; i < watched->frozen; ++i) frozen.emplace_back(PortOf(live->url()));
  }
  std::vector<Viewer::Come> made;
  options.progress = [&](const records::LogRow& row) {
    made.push_back({row.now.t_s, MonotonicNow_s()});
    return true;
  };
  const records::Summary summary = flight::RunFlight(loaded, options).summary;
  if (!summary.complete) throw std::runtime_error("the flight broke off: " + summary.error);
  live.reset();  // which ends the viewers
  Flown flown{summary.sim_s / summary.wall_s, summary.state_hash, summary.image_hash, {}};
  for (Viewer& each : viewers)
    for (const Viewer::Come& row : each.Rows()) {
      const auto when = std::ranges::find_if(
          made, [&](const Viewer::Come& one) { return std::abs(one.t_s - row.t_s) < 1e-6; });
      if (when != made.end()) flown.delays_ms.push_back((row.at_s - when->at_s) * 1e3);
    }
  return flown;
}

// What it costs, in percent of the real-time factor: the fastest of such flights against the fastest of those between
// them that nobody could watch, since whatever else the machine does only slows them down.
double Cost_percent(const flight::LoadedScenario& loaded, const std::filesystem::path& folder,
                    const Watched& watched, bool& same) {
  double with = 0, without = 0;
  for (int i = 0; i < kPairs; ++i) {
    const Flown alone = Fly(loaded, folder, nullptr), seen = Fly(loaded, folder, &watched);
    same = same && alone.state_hash == seen.state_hash && alone.image_hash == seen.image_hash;
    without = std::max(without, alone.real_time_factor);
    with = std::max(with, seen.real_time_factor);
  }
  return 100 * (1 - with / without);
}

}  // namespace

void BenchLive(const flight::SeedRange& seeds, const std::filesystem::path& folder,
               std::vector<records::Figure>& table) {
  const flight::LoadedScenario loaded =
      flight::LoadScenario(kScenario, {fmt::format("seed={}", seeds.first)});
  bool same = true;
  const Watched real_time{.viewers = 1, .speed = 1};
  const Flown shown = Fly(loaded, folder, &real_time);
  const auto add = [&](const char* name, double value, const char* unit, std::optional<double> target,
                       bool at_least = false) {
    table.push_back({std::string("live: ") + name, value, unit, target, at_least, ""});
  };
  if (shown.delays_ms.empty()) throw std::runtime_error("no row came to the viewer");
  add("a row on its way to a viewer, in real time: median", Quantile(shown.delays_ms, 0.5), "ms", {});
  add("the same, 99 %", Quantile(shown.delays_ms, 0.99), "ms", kMostDelay_ms);
  add("the same, longest", *std::ranges::max_element(shown.delays_ms), "ms", {});
  add("a server and no viewer cost the flight", Cost_percent(loaded, folder, {}, same), "%",
      kMostCost_percent);
  add("three viewers cost the flight", Cost_percent(loaded, folder, {.viewers = 3}, same), "%",
      kMostCost_percent);
  add("a frozen viewer costs the flight", Cost_percent(loaded, folder, {.frozen = 1}, same), "%",
      kMostCost_percent);
  const Flown alone = Fly(loaded, folder, nullptr);
  same = same && alone.state_hash == shown.state_hash && alone.image_hash == shown.image_hash;
  add("the same flight with viewers, bit for bit", same ? 1.0 : 0.0, "", 1, true);
}

}  // namespace kestrel::bench
