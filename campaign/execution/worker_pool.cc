// SPDX-License-Identifier: Apache-2.0
#include "campaign/execution/worker_pool.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <deque>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <utility>

#include "base/process/own_program.h"
#include "base/stopwatch.h"
#include "base/version.h"
#include "campaign/execution/worker_wire.h"

namespace kestrel::campaign {
namespace {

namespace fs = std::filesystem;

constexpr int kMaxKilledStarts = 50;    // by someone else
constexpr int kMaxDeaths = 2;           // of a run by its own hand
constexpr int kMaxKilled = 5;           // of a run from without
constexpr double kMaxStart_s = 60;      // until a worker greets
constexpr int kMaxStarts = 3;           // of workers in a row that cannot fly
constexpr std::size_t kLogTail = 4096;  // bytes

// The end of what a worker said since its order, as UTF-8.
std::string TailOf(const fs::path& log) {
  std::ifstream in(log, std::ios::binary | std::ios::ate);
  if (!in) return {};
  const auto size = static_cast<std::size_t>(in.tellg());
  std::string tail(std::min(size, kLogTail), '\0');
  in.seekg(static_cast<std::streamoff>(size - tail.size()));
  in.read(tail.data(), static_cast<std::streamsize>(tail.size()));
  std::erase(tail, '\0');
  using nlohmann::json;
  return json::parse(json(tail).dump(-1, ' ', false, json::error_handler_t::replace)).get<std::string>();
}

// How a process ended, in words.
std::string NameOfEnd(int status) {
  if (WIFSIGNALED(status)) {
    const int signal = WTERMSIG(status);
    const char* name = sigabbrev_np(signal);
    const char* meaning = sigdescr_np(signal);
    return fmt::format("killed by SIG{} ({})", name ? name : std::to_string(signal), meaning ? meaning : "");
  }
  return fmt::format("ended with status {}", WEXITSTATUS(status));
}

// Of a program, which may be known by a descriptor.
std::string FileOf(const std::string& program) {
  std::error_code error;
  const fs::path file = fs::canonical(program, error);
  return error ? program : file.string();
}

bool EndedFromWithout(int status) {
  if (!WIFSIGNALED(status)) return false;
  const int signal = WTERMSIG(status);
  return signal == SIGKILL || signal == SIGTERM || signal == SIGHUP || signal == SIGINT;
}

}  // namespace

struct WorkerPool::Workers {
  struct Worker {
    int number = 0;
    fs::path log;
    pid_t process = -1;
    int wire = -1;
    bool ready = false;  // it has greeted
    std::string received;
    std::optional<RunOrder> order;
    int deaths = 0, killed = 0;       // of the order
    double given_s = 0, until_s = 0;  // of the order: first given, and when this flight of it is too long
  };

  std::vector<std::string> command;
  double limit_s = 0;
  std::vector<Worker> all;
  std::deque<RunResult> ended;
  int failed_starts = 0, killed_starts = 0;

  ~Workers() {
    for (Worker& w : all) End(w);
  }

  void Start(Worker& w);
  int End(Worker& w);  // by force; its status
  void Send(Worker& w);
  void Receive(Worker& w);
  void Died(Worker& w, const std::string& of = {});  // of: what it did wrong; else of itself
  void TookTooLong(Worker& w);
  void Report(Worker& w, RunResult result);
  void ReportBadEnd(Worker& w, RunStatus status, std::string outcome);
};

void WorkerPool::Workers::Start(Worker& w) {
  std::vector<char*> arguments;
  for (std::string& each : command) arguments.push_back(each.data());
  arguments.push_back(nullptr);
  int ends[2];
  if (socketpair(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0, ends) != 0)
    throw std::runtime_error(fmt::format("cannot start a worker: {}", std::strerror(errno)));
  const int log = open(w.log.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_APPEND | O_CLOEXEC, 0644);
  if (log < 0) {
    const int reason = errno;
    close(ends[0]), close(ends[1]);
    throw std::runtime_error(fmt::format("cannot write {}: {}", w.log.string(), std::strerror(reason)));
  }
  const pid_t parent = getpid();
  w.process = fork();
  if (w.process == 0) {
    // Its own group: the terminal's interrupt is the parent's business, and what it starts ends with it.
    setpgid(0, 0);
    prctl(PR_SET_PDEATHSIG, SIGKILL);
    if (getppid() != parent) _exit(1);  // which ended before that was said
    signal(SIGINT, SIG_IGN);
    signal(SIGPIPE, SIG_DFL);
    dup2(ends[1], STDIN_FILENO);
    dup2(ends[1], STDOUT_FILENO);
    dup2(log, STDERR_FILENO);
    execv(arguments[0], arguments.data());
    dprintf(STDERR_FILENO, "%s: %s\n", arguments[0], strerror(errno));
    _exit(127);
  }
  const int reason = errno;
  close(ends[1]), close(log);
  if (w.process < 0) {
    close(ends[0]);
    throw std::runtime_error(fmt::format("cannot start a worker: {}", std::strerror(reason)));
  }
  setpgid(w.process, w.process);  // by whoever is first
  w.wire = ends[0];
  w.ready = false;
  w.received.clear();
}

int WorkerPool::Workers::End(Worker& w) {
  int status = 0;
  if (w.process > 0) {
    kill(-w.process, SIGKILL);
    kill(w.process, SIGKILL);  // should it have no group of its own yet
    while (waitpid(w.process, &status, 0) < 0 && errno == EINTR) {}
    w.process = -1;
  }
  if (w.wire >= 0) close(std::exchange(w.wire, -1));
  return status;
}

void WorkerPool::Workers::Send(Worker& w) {
  w.until_s = MonotonicNow_s() + (w.ready ? limit_s : kMaxStart_s);
  // Its log is of this order alone, and of its start if that is under way.
  if (w.ready) std::ofstream(w.log, std::ios::trunc);
  const std::string line = OrderLine(*w.order);
  for (std::size_t done = 0; done < line.size();) {
    const ssize_t n = send(w.wire, line.data() + done, line.size() - done, MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) return;  // it died: its wire will say so
    done += static_cast<std::size_t>(n);
  }
}

void WorkerPool::Workers::Report(Worker& w, RunResult result) {
  const double wall_s = MonotonicNow_s() - w.given_s;
  result.execution.orchestration_s = wall_s - std::exchange(result.execution.wall_s, wall_s);
  result.execution.worker = w.number;
  if (w.order->folder) result.execution.recording = w.order->folder->string();
  w.order.reset();
  ended.push_back(std::move(result));
}

void WorkerPool::Workers::ReportBadEnd(Worker& w, RunStatus status, std::string outcome) {
  RunResult result;
  result.row = w.order->row;
  result.status = status;
  result.outcome = std::move(outcome);
  result.execution.wall_s = MonotonicNow_s() - w.given_s;  // all of it was spent on trying
  result.execution.log = TailOf(w.log);
  Report(w, std::move(result));
}

void WorkerPool::Workers::Died(Worker& w, const std::string& of) {
  // Whoever has closed the wire and yet lives is ended; one that was ending has its own status.
  const int status = End(w);
  const std::string why = of.empty() ? NameOfEnd(status) : of;
  const bool from_without = of.empty() && EndedFromWithout(status);
  if (!w.ready) {
    ++(from_without ? killed_starts : failed_starts);
    if (failed_starts >= kMaxStarts || killed_starts >= kMaxKilledStarts)
      throw std::runtime_error(
          fmt::format("workers cannot be started: {}: {}\n{}", FileOf(command.front()), why, TailOf(w.log)));
  } else if (w.order) {
    ++(from_without ? w.killed : w.deaths);
    if (w.deaths >= kMaxDeaths || w.killed >= kMaxKilled) ReportBadEnd(w, RunStatus::kCrashed, why);
  }
  Start(w);
  if (w.order) Send(w);
}

void WorkerPool::Workers::TookTooLong(Worker& w) {
  const std::string why =
      fmt::format("took longer than the {:g} s of wall time that it may", w.ready ? limit_s : kMaxStart_s);
  if (!w.ready) return Died(w, why);
  End(w);
  ReportBadEnd(w, RunStatus::kTimedOut, why);
  Start(w);
}

void WorkerPool::Workers::Receive(Worker& w) {
  char bytes[1 << 16];
  const ssize_t n = recv(w.wire, bytes, sizeof bytes, MSG_DONTWAIT);
  if (n < 0 && (errno == EINTR || errno == EAGAIN)) return;
  if (n <= 0) return Died(w);
  w.received.append(bytes, static_cast<std::size_t>(n));
  for (std::size_t end; (end = w.received.find('\n')) != std::string::npos;) {
    const std::string line = w.received.substr(0, end);
    w.received.erase(0, end + 1);
    if (!w.ready && IsGreeting(line)) {
      w.ready = true;
      w.until_s = MonotonicNow_s() + limit_s;  // starting costs the run none of its time
      failed_starts = killed_starts = 0;
      continue;
    }
    try {
      RunResult result = ReportOf(line);
      if (!w.ready || !w.order || result.row != w.order->row)
        return Died(w, fmt::format("reported row {}, which it was not asked for", result.row));
      if (result.status != RunStatus::kPassed && result.status != RunStatus::kFailed)
        result.execution.log = TailOf(w.log);
      Report(w, std::move(result));
    } catch (const std::runtime_error& e) {
      return Died(w, e.what());
    }
  }
}

std::vector<std::string> WorkerCommand() {
  const std::string program = OwnProgram().replace_filename("kestrel-worker");
  // Held, so that workers are started from the file that was there first, should another build replace it.
  static const int held = open(program.c_str(), O_PATH | O_CLOEXEC);
  const std::string by_descriptor = fmt::format("/proc/self/fd/{}", held);
  return {access(by_descriptor.c_str(), X_OK) == 0 ? by_descriptor : program, Version()};
}

WorkerPool::WorkerPool(int workers, double limit_s, const fs::path& logs,
                       const std::vector<std::string>& command)
    : workers_(std::make_unique<Workers>()) {
  std::error_code error;
  fs::create_directories(logs, error);
  if (error) throw std::runtime_error(fmt::format("cannot write {}: {}", logs.string(), error.message()));
  workers_->command = command;
  workers_->limit_s = limit_s;
  for (int i = 0; i < workers; ++i) {
    auto& worker = workers_->all.emplace_back();
    worker.number = i;
    worker.log = logs / fmt::format("worker-{}.log", i);
    workers_->Start(worker);
  }
}

WorkerPool::~WorkerPool() = default;

bool WorkerPool::Idle() const {
  return std::any_of(workers_->all.begin(), workers_->all.end(), [](const auto& w) { return !w.order; });
}

void WorkerPool::Give(const RunOrder& order) {
  const auto idle =
      std::find_if(workers_->all.begin(), workers_->all.end(), [](const auto& w) { return !w.order; });
  if (idle == workers_->all.end()) throw std::logic_error("no worker is idle");
  idle->order = order;
  idle->deaths = idle->killed = 0;
  idle->given_s = MonotonicNow_s();
  workers_->Send(*idle);
}

std::size_t WorkerPool::under_way() const {
  return workers_->ended.size() +
         static_cast<std::size_t>(std::count_if(workers_->all.begin(), workers_->all.end(),
                                                [](const auto& w) { return w.order.has_value(); }));
}

std::optional<RunResult> WorkerPool::WaitForResult(double max_s) {
  const double until_s = MonotonicNow_s() + max_s;
  for (;;) {
    if (!workers_->ended.empty()) {
      RunResult result = std::move(workers_->ended.front());
      workers_->ended.pop_front();
      return result;
    }
    const double now_s = MonotonicNow_s();
    double next_s = until_s;
    std::vector<pollfd> wires;
    for (auto& w : workers_->all) {
      wires.push_back({w.wire, POLLIN, 0});
      if (w.order) next_s = std::min(next_s, w.until_s);
    }
    const int count = poll(wires.data(), wires.size(),
                           static_cast<int>(std::ceil(std::clamp(next_s - now_s, 0.0, 3600.0) * 1e3)));
    if (count < 0) return std::nullopt;
    for (std::size_t i = 0; i < wires.size(); ++i)
      if (wires[i].revents != 0) workers_->Receive(workers_->all[i]);
    for (auto& w : workers_->all) {
      if (!w.order || MonotonicNow_s() < w.until_s) continue;
      workers_->TookTooLong(w);
    }
    if (workers_->ended.empty() && MonotonicNow_s() >= until_s) return std::nullopt;
  }
}

}  // namespace kestrel::campaign
