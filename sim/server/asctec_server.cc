// SPDX-License-Identifier: Apache-2.0
#include "sim/server/asctec_server.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <system_error>

namespace kestrel::sim {
namespace {

[[noreturn]] void Fail(const char* what) { throw std::system_error(errno, std::generic_category(), what); }

}  // namespace

AscTecServer::AscTecServer(const AscTecProcessorOptions& options) : processor_(options) {
  try {
    master_ = posix_openpt(O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
    if (master_ < 0 || grantpt(master_) != 0 || unlockpt(master_) != 0) Fail("pseudo-terminal");
    std::array<char, 128> name{};
    if (ptsname_r(master_, name.data(), name.size()) != 0) Fail("pseudo-terminal");
    device_ = name.data();
    // Held open, so that a client that goes away leaves the line as it is; raw, so that no byte is changed.
    slave_ = open(device_.c_str(), O_RDWR | O_NOCTTY | O_CLOEXEC);
    termios line{};
    if (slave_ < 0 || tcgetattr(slave_, &line) != 0) Fail(device_.c_str());
    cfmakeraw(&line);
    if (tcsetattr(slave_, TCSANOW, &line) != 0 || fchmod(slave_, S_IRUSR | S_IWUSR) != 0)
      Fail(device_.c_str());
  } catch (...) {
    if (slave_ >= 0) close(slave_);
    if (master_ >= 0) close(master_);
    throw;
  }
}

AscTecServer::~AscTecServer() {
  close(slave_);
  close(master_);
}

void AscTecServer::Serve(double now_s, control::Autopilot& aircraft) {
  std::array<std::uint8_t, 256> block{};
  constexpr int kMost = 64;  // blocks at once, lest a flood stops the flight
  ssize_t count = 0;
  for (int i = 0; i < kMost && (count = read(master_, block.data(), block.size())) > 0; ++i)
    processor_.Receive(now_s, std::span(block).first(static_cast<std::size_t>(count)));
  const control::wire::Bytes bytes = processor_.Step(now_s, aircraft);
  if (!bytes.empty() && write(master_, bytes.data(), bytes.size()) < 0) return;  // nobody reads: lost
}

}  // namespace kestrel::sim
