// SPDX-License-Identifier: Apache-2.0
#include "base/process/end_signals.h"

#include <atomic>
#include <csignal>

namespace kestrel {
namespace {

std::atomic<void (*)(int)> told = nullptr;
std::atomic<bool> asked_once = false;
static_assert(decltype(told)::is_always_lock_free);  // what a signal's handler may use

void Receive(int signal) { told.load()(signal == SIGINT ? SIGINT : SIGTERM); }

}  // namespace

void OnEndSignals(void (*asked)(int signal)) {
  told = asked;
  std::signal(SIGINT, Receive);
  std::signal(SIGTERM, Receive);
  struct sigaction now {};
  sigaction(SIGHUP, nullptr, &now);
  if (now.sa_handler != SIG_IGN) std::signal(SIGHUP, Receive);
}

void EndOnNextSignal() {
  std::signal(SIGINT, SIG_DFL);
  std::signal(SIGTERM, SIG_DFL);
}

const std::atomic<bool>& EndInGoodOrder() {
  asked_once = false;
  OnEndSignals([](int) {
    asked_once = true;
    EndOnNextSignal();
  });
  return asked_once;
}

}  // namespace kestrel
