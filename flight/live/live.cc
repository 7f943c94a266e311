// SPDX-License-Identifier: Apache-2.0
#include "flight/live/live.h"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <boost/asio/post.hpp>
#include <chrono>
#include <condition_variable>
#include <deque>
#include <mutex>
#include <nlohmann/json.hpp>
#include <opencv2/imgcodecs.hpp>
#include <thread>
#include <utility>
#include <vector>

#include "base/html/html.h"
#include "base/process/print_note.h"
#include "base/stopwatch.h"
#include "flight/live/access.h"
#include "flight/live/foxglove.h"
#include "flight/live/live_server.h"
#include "flight/live/pace.h"
#include "records/page/flight_json.h"
#include "records/page/flight_page.h"

namespace kestrel::flight {
namespace {

using Seconds = std::chrono::duration<double>;

// How often pictures are taken, and what is new is handed to the viewers. To draw a picture takes the flight a few ms,
// which one that goes as fast as it can has not to spare.
struct Periods {
  double picture_s, drain_s;
};
constexpr Periods kInRealTime{0.05, 0.02}, kAsFast{0.25, 0.06};
constexpr double kStatePeriod_s = 0.25;
constexpr double kPoll_s = 0.05;
constexpr double kGone_s = 2;  // without a viewer: one who loads the page again comes back within it
constexpr std::size_t kMaxWaiting = 2048, kMaxCommands = 64;
constexpr int kJpegQuality = 80;
constexpr int kNice = 5;  // behind the flight, where processors are few

// What is missing for it is told in its place; the flight goes on.
std::string PageOf(const LiveFlight& flight) {
  try {
    return records::LiveFlightPage(flight.subject, flight.scene_glb);
  } catch (const std::exception& e) {
    return Escaped(e.what());
  }
}

// No more often than a period, and on average as often.
class Beat {
 public:
  bool Due(double now_s) const { return now_s >= next_s_; }
  void Take(double now_s, double period_s) { next_s_ = std::max(next_s_ + period_s, now_s); }

 private:
  double next_s_ = 0;
};

}  // namespace

struct Live::State {
  explicit State(const LiveOptions& options)
      : now_s(options.now_s ? options.now_s : MonotonicNow_s),
        open(!IsLoopback(options.server.address)),
        awaits(options.await_viewer),
        pace(options.speed),
        drain(io),
        server(
            io, options.server, now_s, [this] { return page; },
            [this](bool foxglove_client) { return Join(foxglove_client); }) {
    as_fast = pace.speed() == Pace::kAsFast;
    pages.command = [this](LiveCommand command) {
      const std::lock_guard lock(mutex);
      if (commands.size() >= kMaxCommands) return false;
      commands.push_back(std::move(command));
      asked.notify_one();
      return true;
    };
    thread = std::thread([this] { Run(); });
  }
  ~State() {
    boost::asio::post(io, [this] {
      server.End();
      drain.cancel();
      io.stop();
    });
    thread.join();
  }

  // Of the server's thread.
  void Run() {
    setpriority(PRIO_PROCESS, static_cast<id_t>(gettid()), kNice);
    for (;;) try {
        io.run();
        return;
      } catch (const std::exception& e) {  // a mistake of the program; the flight goes on
        pages.feed.AddEvent(0, "live", e.what());
      }
  }
  std::unique_ptr<Conversation> Join(bool foxglove_client) {
    std::unique_ptr<Conversation> joined =
        foxglove_client ? foxglove.Join() : std::make_unique<PageConversation>(pages);
    Refresh();
    return joined;
  }
  void Refresh() {
    const bool page_watches = !pages.all.empty();
    for (std::size_t kind = 0; kind < wants.size(); ++kind)
      wants[kind] = page_watches && pages.feed.picture_taken(static_cast<Picture>(kind));
    wants_image = foxglove.wants_images();
    viewers = server.viewers();
  }
  void Drain() {
    std::deque<std::function<void()>> taken;
    {
      const std::lock_guard lock(mutex);
      taken.swap(waiting);
      posted = false;
    }
    drained_s = now_s();
    for (const auto& each : taken) each();
    server.Kick();
    Refresh();
  }

  // Of the flight's. must: not one of many that are alike.
  void Do(std::function<void()> job, bool must) {
    {
      const std::lock_guard lock(mutex);
      if (waiting.size() >= kMaxWaiting && !must) return;
      waiting.push_back(std::move(job));
      if (std::exchange(posted, true)) return;
    }
    boost::asio::post(io, [this] {
      const double wait_s = drained_s + periods().drain_s - now_s();
      if (wait_s <= 0) return Drain();
      drain.expires_after(std::chrono::duration_cast<std::chrono::nanoseconds>(Seconds(wait_s)));
      drain.async_wait([this](boost::system::error_code wrong) {
        if (!wrong) Drain();
      });
    });
  }
  void TellState() {
    told_s = now_s();
    Do([this, paused = pace.paused(), speed = pace.speed(),
        factor = pace.real_time_factor()] { pages.feed.SetState(paused, speed, factor); },
       false);
  }
  void Refuse(const LiveCommand& command, const std::string& why) {
    Do(
        [this, viewer = command.from, key = command.key, why] {
          const auto found = pages.all.find(viewer);
          if (found != pages.all.end()) found->second->Refuse(why, key);
        },
        true);
  }
  void Obey(const LiveCommand& command) {
    using Op = LiveCommand::Op;
    switch (command.op) {
      case Op::kPause:
        return pace.Pause();
      case Op::kResume:
        return pace.Resume();
      case Op::kStep:
        return pace.Step();
      case Op::kSpeed:
        pace.SetSpeed(command.speed);
        as_fast = pace.speed() == Pace::kAsFast;
        return;
      case Op::kChange:
        break;
    }
    if (!change) return Refuse(command, "nothing of this flight can be changed");
    const LiveAnswer answer = change(command.key, command.value);
    if (!answer.refused.empty()) return Refuse(command, answer.refused);
    Do([this, command,
        answer] { pages.feed.AddChange(command.key, command.value, answer.t_s, answer.again); },
       true);
  }
  void ObeyAll() {
    std::deque<LiveCommand> taken;
    {
      const std::lock_guard lock(mutex);
      taken.swap(commands);
    }
    for (const LiveCommand& each : taken) Obey(each);
    if (!taken.empty() || now_s() >= told_s + kStatePeriod_s) TellState();
  }

  std::function<double()> now_s;
  bool open;  // to more than this computer

  // Of both threads.
  std::mutex mutex;
  std::condition_variable asked;
  std::deque<std::function<void()>> waiting;
  bool posted = false;
  std::deque<LiveCommand> commands;
  std::array<std::atomic<bool>, 2> wants{};
  std::atomic<bool> wants_image = false;
  std::atomic<int> viewers = 0;
  std::atomic<bool> as_fast = false;
  const Periods& periods() const { return as_fast ? kAsFast : kInRealTime; }

  // Of the flight's.
  bool awaits;
  Pace pace;
  bool paced = true;
  std::function<LiveAnswer(const std::string&, const std::string&)> change;
  records::TelemetryOptions telemetry;
  std::array<Beat, 2> beats;
  Beat image_beat;
  double told_s = 0;

  // Of the server's. What it holds of viewers is destroyed before what they are told of.
  Pages pages;
  Foxglove foxglove;
  std::shared_ptr<const std::string> page;
  double drained_s = 0;
  boost::asio::io_context io{1};
  boost::asio::steady_timer drain;
  LiveServer server;
  std::thread thread;
};

Live::Live(const LiveOptions& options) : state_(std::make_unique<State>(options)) {}
Live::~Live() = default;

bool Live::open_to_others() const { return state_->open; }
std::string Live::url() const { return state_->server.url(); }
int Live::viewers() const { return state_->viewers; }

void Live::Begin(LiveFlight flight) {
  State& s = *state_;
  s.change = std::move(flight.change);
  s.telemetry = flight.telemetry;
  s.paced = flight.refusals.pace.empty();
  s.Do(
      [&s, flight = std::move(flight)] {
        s.page = std::make_shared<const std::string>(PageOf(flight));
        s.pages.refusals = flight.refusals;
        nlohmann::json told = records::LiveJson(flight.subject);
        told["refusals"] = {{"pace", flight.refusals.pace}, {"change", flight.refusals.change}};
        s.pages.feed.Begin(std::move(told), records::TelemetryHeader(flight.telemetry));
        s.foxglove.Begin("Kestrel", flight.messages);
      },
      true);
  s.TellState();
}

bool Live::WantsPicture(Picture kind) const {
  const auto index = static_cast<std::size_t>(kind);
  return state_->wants[index] && state_->beats[index].Due(state_->now_s());
}

bool Live::WantsImage() const { return state_->wants_image && state_->image_beat.Due(state_->now_s()); }

void Live::Row(const mission::LogRow& row, const cv::Mat& image) {
  State& s = *state_;
  if (!image.empty()) s.image_beat.Take(s.now_s(), s.periods().picture_s);
  s.Do(
      [&s, row, image, telemetry = s.telemetry] {
        s.pages.feed.AddRow(records::TelemetryLine(row, telemetry));
        s.foxglove.Row(row, image);
      },
      false);
}

void Live::Show(Picture kind, double t_s, const cv::Mat& bgr) {
  State& s = *state_;
  if (bgr.empty()) return;
  const auto index = static_cast<std::size_t>(kind);
  s.beats[index].Take(s.now_s(), s.periods().picture_s);
  s.wants[index] = false;  // until somebody has taken it
  s.Do(
      [&s, kind, t_s, bgr] {
        std::vector<unsigned char> jpeg;
        if (cv::imencode(".jpg", bgr, jpeg, {cv::IMWRITE_JPEG_QUALITY, kJpegQuality}))
          s.pages.feed.AddPicture(kind, t_s, {reinterpret_cast<const char*>(jpeg.data()), jpeg.size()});
      },
      false);
}

void Live::Event(double t_s, std::string_view what, std::string_view is) {
  state_->Do(
      [&s = *state_, t_s, what = std::string(what), is = std::string(is)] {
        s.pages.feed.AddEvent(t_s, what, is);
        s.foxglove.Event(t_s, what, is);
      },
      true);
}

bool Live::Wait(double t_s, const std::function<bool()>& go_on) {
  State& s = *state_;
  while (s.awaits) {
    s.Do([] {}, true);  // viewers are counted again
    s.awaits = viewers() == 0;
    if (s.awaits && !go_on()) return false;
    if (s.awaits) std::this_thread::sleep_for(Seconds(kPoll_s));
  }
  s.pace.Flown(s.now_s(), t_s);
  bool told = false;
  for (double seen_s = s.now_s();;) {
    s.ObeyAll();
    if (!s.pace.paused() || viewers() > 0) seen_s = s.now_s();
    if (s.now_s() - seen_s > kGone_s && !std::exchange(told, true))
      PrintNote("the flight is paused, and nobody watches: {} lets it fly on\n", url());
    const double wait_s = s.paced ? s.pace.Wait_s(s.now_s(), t_s) : 0;
    if (!(wait_s > 0)) return true;
    if (!go_on()) return false;
    std::unique_lock lock(s.mutex);
    s.asked.wait_for(lock, Seconds(std::min(wait_s, kPoll_s)), [&s] { return !s.commands.empty(); });
  }
}

void Live::End(const records::Summary& summary) {
  State& s = *state_;
  s.change = nullptr;
  {
    const std::lock_guard lock(s.mutex);
    s.commands.clear();
  }
  s.Do([&s, summary] { s.pages.feed.End(records::OutcomeJson(summary)); }, true);
}

bool Live::Linger(const std::function<bool()>& go_on) {
  State& s = *state_;
  double seen_s = -kGone_s;
  for (bool first = true;; first = false) {
    s.Do([] {}, true);  // those who have gone are counted again
    if (viewers() > 0) seen_s = s.now_s();
    if (first && viewers() == 0) return true;
    if (s.now_s() - seen_s > kGone_s) return true;
    if (!go_on()) return false;
    std::this_thread::sleep_for(Seconds(kPoll_s));
  }
}

}  // namespace kestrel::flight
