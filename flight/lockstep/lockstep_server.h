// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <chrono>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "flight/lockstep/lockstep_session.h"

namespace kestrel::flight {

struct LockstepServerOptions {
  std::string address;              // "tcp:PORT" on loopback, 0: any; or the file of a Unix socket
  std::optional<double> timeout_s;  // for which a client may say nothing; none: for ever
  bool once = false;                // ends after the first client that says hello
  std::function<bool()> go_on;      // false ends the flight and the serving; asked every 0.1 s
};

// Of this user, where no address is given.
std::string DefaultLockstepAddress();
// What is wrong with an address by itself; empty: nothing.
std::string LockstepAddressMistake(const std::string& address);

// Serves the lockstep protocol to one client at a time: a request at a time is read, answered, and the answer
// sent before the next is read, so that a client can neither hurry it nor fill its memory. Who comes beside it
// is told that it is busy. What cannot be a message is told, and its client sent away; then the next may come.
class LockstepServer {
 public:
  // Listens. Throws std::runtime_error with the address and the reason.
  LockstepServer(LockstepServerOptions options, LockstepOptions flight, const LoadedScenario& loaded);
  ~LockstepServer();
  LockstepServer(const LockstepServer&) = delete;
  LockstepServer& operator=(const LockstepServer&) = delete;

  const std::string& where() const { return where_; }  // "tcp:4573", "/run/user/1000/kestrel.sock"
  // Until it is to end. The summary of the last flight; none: there was none.
  std::optional<records::Summary> Serve();

 private:
  struct Leaving;
  enum class Wait { kReady, kTimeOut, kStop };
  using Deadline = std::optional<std::chrono::steady_clock::time_point>;

  Wait WaitFor(int descriptor, short events, Deadline deadline);
  void TurnAway();  // who has just connected
  void SendAway(int client);
  bool ServeClient(int client);  // whether it said hello
  // Why it is over; none: the message is there.
  std::optional<std::string> Read(int client, Deadline deadline, std::string& message);
  std::optional<std::string> Send(int client, const LockstepSession::Reply& reply, Deadline deadline);

  LockstepServerOptions options_;
  LockstepOptions flight_;
  const LoadedScenario& loaded_;
  std::string where_, file_;  // file: to be removed
  int listener_ = -1;
  std::string received_;  // of the client, not answered yet
  std::vector<Leaving> leaving_;
  std::optional<records::Summary> summary_;
};

}  // namespace kestrel::flight
