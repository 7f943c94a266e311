// SPDX-License-Identifier: Apache-2.0
#include "control/link/asctec_link.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <sys/sysmacros.h>
#include <termios.h>

#include "base/stopwatch.h"

// clang-format off
#include <utility>  // before Boost.Asio, which in 1.74 forgets it
// clang-format on
#include <array>
#include <boost/asio.hpp>
#include <cerrno>
#include <chrono>
#include <cstring>
#include <mutex>
#include <thread>

namespace kestrel::control {
namespace {

namespace asio = boost::asio;
using boost::system::error_code;

constexpr auto kAscTecTick = std::chrono::milliseconds(2);
constexpr double kReopen_s = 0.2;
constexpr std::size_t kMaxUnwritten = 512;  // a port that takes no more than this is stuck

// Two that command one aircraft are none that does. The lock holds for programs that ask for it, as this
// one does, and ends with the process, however that ends; exclusive mode keeps out every other. Not of a
// pseudo-terminal, whose other end may keep it in that mode when the process is gone. Empty: it is ours.
std::string Reserve(int device) {
  fcntl(device, F_SETFD, FD_CLOEXEC);  // a child would hold the lock
  if (flock(device, LOCK_EX | LOCK_NB) != 0)
    return errno == EWOULDBLOCK ? "in use by another program" : std::strerror(errno);
  struct stat status {};
  constexpr unsigned kFirstPty = 136, kLastPty = 143;  // major numbers, Documentation/admin-guide/devices.txt
  const bool known = fstat(device, &status) == 0;
  const bool pty = known && major(status.st_rdev) >= kFirstPty && major(status.st_rdev) <= kLastPty;
  if (!pty && ioctl(device, TIOCEXCL) != 0) return std::strerror(errno);
  return {};
}

}  // namespace

class AscTecLink::Port {
 public:
  explicit Port(const AscTecOptions& options)
      : device_(options.device), session_(options), serial_(io_), timer_(io_), thread_([this] { Run(); }) {}
  ~Port() {
    io_.stop();
    thread_.join();
  }

  auto Locked(auto use) {
    const std::lock_guard lock(mutex_);
    return use(session_);
  }

 private:
  void Run() {
    Tick();
    io_.run();
  }

  void Tick() {
    if (!serial_.is_open() && MonotonicNow_s() >= reopen_s_) Open();
    if (serial_.is_open()) {
      const wire::Bytes due = Locked([](AscTecSession& s) { return s.Say(MonotonicNow_s()); });
      unwritten_.insert(unwritten_.end(), due.begin(), due.end());
      if (unwritten_.size() > kMaxUnwritten)
        Close("the device takes no bytes");
      else
        Write();
    }
    timer_.expires_after(kAscTecTick);
    timer_.async_wait([this](error_code e) {
      if (!e) Tick();
    });
  }

  void Open() {
    error_code e;
    serial_.open(device_, e);
    if (e == boost::system::errc::device_or_resource_busy) return Close("in use by another program");
    // Before its settings are touched, which are the other program's then.
    if (!e) {
      if (const std::string why = Reserve(serial_.native_handle()); !why.empty()) return Close(why);
    }
    using Option = asio::serial_port_base;
    if (!e) serial_.set_option(Option::baud_rate(57600), e);
    if (!e) serial_.set_option(Option::character_size(8), e);
    if (!e) serial_.set_option(Option::parity(Option::parity::none), e);
    if (!e) serial_.set_option(Option::stop_bits(Option::stop_bits::one), e);
    if (!e) serial_.set_option(Option::flow_control(Option::flow_control::none), e);
    if (e) return Close(e.message());
    tcflush(serial_.native_handle(), TCIOFLUSH);  // what was meant for others
    Locked([](AscTecSession& s) { s.Opened(MonotonicNow_s()); });
    Read();
  }

  void Close(const std::string& why) {
    error_code ignored;
    serial_.close(ignored);
    ++opening_;
    unwritten_.clear();
    writing_ = false;
    reopen_s_ = MonotonicNow_s() + kReopen_s;
    Locked([&](AscTecSession& s) { s.Closed(device_ + ": " + why); });
  }

  // Of an operation that was begun before the device was closed, nothing counts.
  void Read() {
    serial_.async_read_some(asio::buffer(read_), [this, opening = opening_](error_code e, std::size_t count) {
      if (opening != opening_) return;
      if (e) return Close(e.message());
      const double now_s = MonotonicNow_s();
      Locked([&](AscTecSession& s) { s.Receive(now_s, std::span(read_).first(count)); });
      Read();
    });
  }

  void Write() {
    if (writing_ || unwritten_.empty()) return;
    writing_ = true;
    auto bytes = std::make_shared<wire::Bytes>(std::move(unwritten_));
    unwritten_.clear();
    asio::async_write(serial_, asio::buffer(*bytes),
                      [this, bytes, opening = opening_](error_code e, std::size_t) {
                        if (opening != opening_) return;
                        writing_ = false;
                        if (e) return Close(e.message());
                        Write();
                      });
  }

  const std::string device_;
  std::mutex mutex_;  // of the session
  AscTecSession session_;

  asio::io_context io_;
  asio::serial_port serial_;
  asio::steady_timer timer_;
  double reopen_s_ = 0;
  std::uint64_t opening_ = 0;
  std::array<std::uint8_t, 512> read_{};
  wire::Bytes unwritten_;
  bool writing_ = false;
  std::thread thread_;  // last: it uses all of the above
};

AscTecLink::AscTecLink(const AscTecOptions& options) : port_(std::make_unique<Port>(options)) {}
AscTecLink::~AscTecLink() = default;

VehicleState AscTecLink::State() const {
  return port_->Locked([](AscTecSession& s) { return s.State(); });
}
void AscTecLink::Send(const Setpoint& setpoint) {
  port_->Locked([&](AscTecSession& s) { s.Send(MonotonicNow_s(), setpoint); });
}
void AscTecLink::Aid(const AttitudeAid&) {
  port_->Locked([](AscTecSession& s) { s.Aid(); });
}
LinkHealth AscTecLink::Health() const {
  return port_->Locked([](AscTecSession& s) { return s.Health(MonotonicNow_s()); });
}
void AscTecLink::Silence() {
  port_->Locked([](AscTecSession& s) { s.Silence(); });
}

}  // namespace kestrel::control
