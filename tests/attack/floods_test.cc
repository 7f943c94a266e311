// SPDX-License-Identifier: Apache-2.0
// Who sends more than anybody listens to, to programs that fly. Their memory stays what it was, and who has
// the session keeps it.
#include <arpa/inet.h>
#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdint>
#include <functional>
#include <random>
#include <string>
#include <thread>
#include <vector>

#include "tests/support/content.h"
#include "tests/support/temporary_folder.h"

namespace kestrel {
namespace {

using Bytes = std::vector<std::uint8_t>;

// A socket on this computer that speaks to a port of it.
class Sender {
 public:
  explicit Sender(int port) {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    to.sin_port = htons(static_cast<std::uint16_t>(port));
    EXPECT_EQ(connect(socket_, reinterpret_cast<const sockaddr*>(&to), sizeof to), 0);
  }
  ~Sender() { close(socket_); }
  Sender(const Sender&) = delete;
  Sender& operator=(const Sender&) = delete;
  void Send(const Bytes& bytes) const { send(socket_, bytes.data(), bytes.size(), MSG_DONTWAIT); }
  std::string Receive(int within_ms) const {
    pollfd wait{socket_, POLLIN, 0};
    if (poll(&wait, 1, within_ms) != 1) return {};
    std::string text(4096, ' ');
    const ssize_t size = recv(socket_, text.data(), text.size(), MSG_DONTWAIT);
    text.resize(size > 0 ? static_cast<std::size_t>(size) : 0);
    return text;
  }

 private:
  const int socket_ = socket(AF_INET, SOCK_DGRAM, 0);
};

int FreePort() {
  const int probe = socket(AF_INET, SOCK_DGRAM, 0);
  sockaddr_in at{};
  at.sin_family = AF_INET;
  at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  socklen_t size = sizeof at;
  EXPECT_EQ(bind(probe, reinterpret_cast<sockaddr*>(&at), size), 0);
  EXPECT_EQ(getsockname(probe, reinterpret_cast<sockaddr*>(&at), &size), 0);
  close(probe);
  return ntohs(at.sin_port);
}

class FloodsTest : public InTemporaryFolder {
 protected:
  // Until it listens at a UDP port of the loopback address.
  void Start(const std::string& program, const std::string& arguments, int port) {
    const std::string command =
        fmt::format("cd {} && exec {} {} >said.txt 2>&1 </dev/null", folder_.string(), program, arguments);
    child_ = fork();
    if (child_ == 0) {
      execl("/bin/sh", "sh", "-c", command.c_str(), nullptr);
      _exit(127);
    }
    const std::string listens = fmt::format("0100007F:{:04X} ", port);
    for (int i = 0; i < 3000 && Content("/proc/net/udp").find(listens) == std::string::npos; ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(10));
    ASSERT_NE(Content("/proc/net/udp").find(listens), std::string::npos) << Content(folder_ / "said.txt");
  }
  void TearDown() override {
    if (child_ > 0) {
      kill(child_, SIGKILL);
      waitpid(child_, nullptr, 0);
    }
    InTemporaryFolder::TearDown();
  }
  double HeldMib() const {
    const std::string status = Content(fmt::format("/proc/{}/status", child_));
    const std::size_t at = status.find("VmRSS:");
    return at == std::string::npos ? -1 : std::stod(status.substr(at + 6)) / 1024;
  }
  pid_t child_ = -1;
};

TEST_F(FloodsTest, WhatIsSentToACamerasPortAndIsNoImageIsNotKept) {
  const int port = FreePort();
  Start(KESTREL_HARDWARE_PROGRAM,
        fmt::format("fly hover --dry-run --no-video --for 600 --out flown --camera rtp://127.0.0.1:{} "
                    "--autopilot mavlink:udpin://127.0.0.1:{}",
                    port, FreePort()),
        port);
  const Sender attacker(port);
  std::mt19937 random(1);
  const auto flood = [&](int count, std::size_t size, const std::function<void(Bytes&)>& make) {
    Bytes bytes(size);
    for (int i = 0; i < count; ++i) {
      for (std::size_t k = 0; k < std::min<std::size_t>(size, 64); ++k)
        bytes[k] = static_cast<std::uint8_t>(random());
      make(bytes);
      attacker.Send(bytes);
      if (i % 64 == 0) std::this_thread::sleep_for(std::chrono::microseconds(200));  // that it can be taken
    }
    std::this_thread::sleep_for(std::chrono::milliseconds(200));
    return HeldMib();
  };
  const double before = flood(100, 20, [](Bytes&) {});
  ASSERT_GT(before, 0);
  const double by_text = flood(300000, 20, [](Bytes& b) { b[0] = 'x'; });
  EXPECT_LT(by_text - before, 20) << "text";
  const double by_type = flood(50000, 200, [](Bytes& b) { b[0] = 0x80, b[1] = 97; });
  EXPECT_LT(by_type - before, 20) << "RTP of another type";
  // What the decoder's own buffers take is not much, and once.
  const double by_rtp = flood(100000, 200, [](Bytes& b) { b[0] = 0x80, b[1] = b[1] % 2 == 0 ? 26 : 154; });
  EXPECT_LT(by_rtp - before, 150) << "RTP of its type";
  const double by_size = flood(5000, 60000, [](Bytes& b) { b[0] = 0x80, b[1] = 26; });
  EXPECT_LT(by_size - before, 150) << "large";
  for (const auto& [name, value] : {std::pair{"before", before},
                                    {"text", by_text},
                                    {"type", by_type},
                                    {"rtp", by_rtp},
                                    {"size", by_size}})
    RecordProperty(name, fmt::format("{:.1f}", value));
}

// ArduPilot's servo packet: 16 channels.
Bytes Servos(std::uint32_t count, int pwm_us) {
  Bytes bytes;
  const auto put = [&](std::uint32_t value, int size) {
    for (int i = 0; i < size; ++i) bytes.push_back(static_cast<std::uint8_t>(value >> (8 * i)));
  };
  put(18458, 2), put(400, 2), put(count, 4);
  for (int i = 0; i < 16; ++i) put(static_cast<std::uint32_t>(pwm_us), 2);
  return bytes;
}

TEST_F(FloodsTest, ThePeerOfServedPhysicsIsHeardWhileOthersSend) {
  const int port = FreePort();
  Start(KESTREL_PROGRAM, fmt::format("serve hover --physics ardupilot --physics-port {} --for 600", port),
        port);
  const Sender peer(port), attacker(port);
  const auto time_of = [](const std::string& line) {
    const std::size_t at = line.find("\"timestamp\":");
    return at == std::string::npos ? -1 : std::stod(line.substr(at + 12));
  };
  // As ArduPilot does: again until it is answered. What was asked again is answered again: the time of an
  // answer that is later than the last, or -1.
  const auto exchange = [&](std::uint32_t count, double last_s) {
    for (int tries = 0; tries < 40; ++tries) {
      peer.Send(Servos(count, 1000));
      for (std::string line; !(line = peer.Receive(500)).empty();)
        if (const double t_s = time_of(line); t_s > last_s) return t_s;
    }
    return -1.0;
  };
  double last_s = exchange(0, -1);
  ASSERT_GE(last_s, 0);
  std::atomic<bool> over = false;
  std::thread flood([&] {
    for (std::uint32_t i = 0; !over; ++i) {
      attacker.Send(Servos(i, 2000));
      if (i % 64 == 0) std::this_thread::sleep_for(std::chrono::microseconds(100));
    }
  });
  // For longer than a silent peer keeps its flight.
  std::uint32_t count = 1;
  bool onward = true;
  const auto until = std::chrono::steady_clock::now() + std::chrono::seconds(5);
  while (onward && std::chrono::steady_clock::now() < until) {
    const double t_s = exchange(count++, last_s);
    onward = t_s > last_s;
    last_s = t_s;
  }
  over = true;
  flood.join();
  EXPECT_TRUE(onward) << "after " << count << " exchanges";
  EXPECT_EQ(attacker.Receive(0), "");
  EXPECT_GT(count, 2U);
}

}  // namespace
}  // namespace kestrel
