// SPDX-License-Identifier: Apache-2.0
// What is done to the server by its socket: clients that die, cut, flood, and come two at a time.
#include "flight/lockstep/lockstep_server.h"

#include <fmt/format.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <atomic>
#include <fstream>
#include <nlohmann/json.hpp>
#include <thread>

#include "records/summary.h"
#include "tests/support/temporary_folder.h"

namespace kestrel::flight {
namespace {

using ::testing::HasSubstr;
using ::testing::ThrowsMessage;
using Json = nlohmann::json;

std::string Framed(const std::string& json) {
  const auto size = static_cast<std::uint32_t>(json.size());
  std::string bytes(4, '\0');
  for (std::size_t i = 0; i < 4; ++i) bytes[i] = static_cast<char>(size >> 8 * i & 0xff);
  return bytes + json;
}

constexpr char kHello[] = R"({"request":"hello","version":1})";

// A client that may do as it likes.
class Peer {
 public:
  explicit Peer(const std::string& where) {
    if (where.starts_with("tcp:")) {
      sockaddr_in at{};
      at.sin_family = AF_INET;
      at.sin_port = htons(static_cast<std::uint16_t>(std::stoi(where.substr(4))));
      at.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
      Connect(AF_INET, reinterpret_cast<sockaddr*>(&at), sizeof at);
    } else {
      sockaddr_un at{};
      at.sun_family = AF_UNIX;
      where.copy(at.sun_path, sizeof at.sun_path - 1);
      Connect(AF_UNIX, reinterpret_cast<sockaddr*>(&at), sizeof at);
    }
  }
  ~Peer() { close(socket_); }
  Peer(const Peer&) = delete;
  Peer& operator=(const Peer&) = delete;

  // false: it is not taken any more.
  bool Send(const std::string& bytes) {
    return send(socket_, bytes.data(), bytes.size(), MSG_NOSIGNAL) == static_cast<ssize_t>(bytes.size());
  }
  void EndSending() { shutdown(socket_, SHUT_WR); }
  // The next reply; null: the server has closed.
  Json Receive() {
    std::string head = Read(4);
    if (head.size() < 4) return nullptr;
    std::uint32_t size = 0;
    for (std::size_t i = 0; i < 4; ++i) size |= std::uint32_t{static_cast<unsigned char>(head[i])} << 8 * i;
    Json reply = Json::parse(Read(size));
    token = reply["token"];
    if (reply.contains("bytes")) pictures = Read(reply["bytes"]);
    return reply;
  }
  Json Ask(const std::string& request, const std::string& keys = "") {
    EXPECT_TRUE(Send(Framed(fmt::format(R"({{"request":"{}","token":{}{}}})", request, token, keys))));
    return Receive();
  }
  Json Hello(const std::string& keys = "") { return Ask("hello", R"(,"version":1)" + keys); }

  std::uint64_t token = 0;
  std::string pictures;

 private:
  void Connect(int family, const sockaddr* at, socklen_t size) {
    socket_ = socket(family, SOCK_STREAM, 0);
    EXPECT_EQ(connect(socket_, at, size), 0);
    const timeval patience{20, 0};
    setsockopt(socket_, SOL_SOCKET, SO_RCVTIMEO, &patience, sizeof patience);
  }
  std::string Read(std::size_t size) {
    std::string bytes(size, '\0');
    std::size_t have = 0;
    while (have < size) {
      const ssize_t more = recv(socket_, bytes.data() + have, size - have, 0);
      if (more <= 0) break;
      have += static_cast<std::size_t>(more);
    }
    bytes.resize(have);
    return bytes;
  }

  int socket_ = -1;
};

constexpr char kBlind[] = R"(,"images":false)";
constexpr char kBlindUnrecorded[] = R"(,"images":false,"records":false)";

class LockstepServerTest : public InTemporaryFolder {
 protected:
  void SetUp() override {
    InTemporaryFolder::SetUp();
    flight_.scenario = "hover";
    flight_.sim.overrides = {"duration_s=5", "start.settle_s=0"};
    flight_.folder = [this](std::uint64_t) { return folder_ / "flight"; };
    flight_.video = false;
    flight_.say = [](const std::string&) {};
    loaded_ = LoadScenario("hover", flight_.sim.overrides, false);
    options_.address = folder_ / "socket";
    options_.go_on = [this] { return go_on_.load(); };
  }
  void TearDown() override {
    End();
    InTemporaryFolder::TearDown();
  }
  void Begin() {
    server_.emplace(options_, flight_, *loaded_);
    thread_ = std::jthread([this] { last_ = server_->Serve(); });
  }
  void End() {
    go_on_ = false;
    if (thread_.joinable()) thread_.join();
    server_.reset();
  }
  // That the next client is served as if nothing had been.
  void ExpectServes() {
    Json hello;
    for (int i = 0; i < 200 && (hello.is_null() || hello["error"]["kind"] == "busy"); ++i) {
      if (i > 0)
        std::this_thread::sleep_for(std::chrono::milliseconds(10));  // until it has seen who has gone
      next_.emplace(server_->where());
      hello = next_->Hello();
      if (hello["ok"] == true) break;
    }
    ASSERT_EQ(hello["ok"], true) << hello;
    EXPECT_EQ(next_->Ask("reset", kBlindUnrecorded)["ok"], true);
    EXPECT_EQ(next_->Ask("step")["ok"], true);
    EXPECT_EQ(next_->Ask("bye")["ok"], true);
    EXPECT_EQ(next_->Receive(), nullptr);
  }

  LockstepServerOptions options_;
  LockstepOptions flight_;
  std::optional<LoadedScenario> loaded_;
  std::atomic<bool> go_on_ = true;
  std::optional<LockstepServer> server_;
  std::jthread thread_;
  std::optional<records::Summary> last_;
  std::optional<Peer> next_;
};

TEST_F(LockstepServerTest, ServesOneClientAfterTheOther) {
  Begin();
  ExpectServes();
  ExpectServes();
}

TEST_F(LockstepServerTest, ServesByTcpWithImagesInline) {
  options_.address = "tcp:0";
  Begin();
  Peer peer(server_->where());
  EXPECT_EQ(peer.Hello(R"(,"inline":true)")["version"], 1);
  const Json frame = peer.Ask("reset", R"(,"records":false)")["frame"];
  const Json& shape = frame["image"]["shape"];
  EXPECT_GE(peer.pictures.size(), shape[0].get<std::size_t>() * shape[1].get<std::size_t>());
  EXPECT_EQ(peer.Ask("bye")["ok"], true);
}

TEST_F(LockstepServerTest, ASecondClientIsToldThatItIsBusy) {
  Begin();
  Peer first(server_->where());
  first.Hello();
  for (int i = 0; i < 30; ++i) {  // and does not hold the first one up, however many come
    Peer second(server_->where());
    EXPECT_EQ(second.Receive()["error"]["kind"], "busy");
    EXPECT_EQ(second.Receive(), nullptr);
  }
  EXPECT_EQ(first.Ask("reset", kBlindUnrecorded)["ok"], true);
}

TEST_F(LockstepServerTest, EveryPrefixOfAMessageAndThenTheEndLeavesAServerThatServes) {
  Begin();
  const std::string message = Framed(kHello);
  for (std::size_t length = 0; length < message.size(); ++length) {
    Json told;
    for (int i = 0; i < 500; ++i) {
      Peer peer(server_->where());
      peer.Send(message.substr(0, length));
      peer.EndSending();
      told = peer.Receive();
      if (told["error"]["kind"] != "busy") break;
      std::this_thread::sleep_for(std::chrono::milliseconds(2));
    }
    EXPECT_EQ(told["error"]["message"],
              length == 0 ? "the client is gone"
                          : fmt::format("the client is gone in the middle of a message, after {} bytes of it",
                                        length));
  }
  ExpectServes();
}

TEST_F(LockstepServerTest, AClientThatDiesInAMessageLeavesTheRecordOfItsFlight) {
  Begin();
  {
    Peer peer(server_->where());
    peer.Hello();
    peer.Ask("reset", kBlind);
    peer.Ask("step");
    peer.Send(Framed(R"({"request":"step","token":3})").substr(0, 9));
  }
  ExpectServes();
  const records::Summary left = records::ReadSummary(folder_ / "flight/summary.json");
  EXPECT_EQ(left.outcome, "broke off");
  EXPECT_THAT(left.error, HasSubstr("in the middle of a message, after 9 bytes"));
}

TEST_F(LockstepServerTest, WhatIsNoMessageIsToldAndTheNextOneIsServed) {
  Begin();
  {
    Peer peer(server_->where());
    peer.Hello();
    // In its frame it harms nobody.
    peer.Send(Framed("\xff\xfe\x00 garbage"));
    EXPECT_EQ(peer.Receive()["error"]["kind"], "message");
    peer.Send(Framed(std::string(kLongestRequest, 'x')));
    EXPECT_EQ(peer.Receive()["error"]["kind"], "message");
    EXPECT_EQ(peer.Ask("reset", kBlindUnrecorded)["ok"], true);
    // Whose frame is none, nothing can be read behind it.
    peer.Send("GET / HTTP/1.1\r\n\r\n");
    EXPECT_THAT(peer.Receive()["error"]["message"], HasSubstr("a message of 542393671 bytes"));
    EXPECT_EQ(peer.Receive(), nullptr);
  }
  for (const std::string& bytes :
       {std::string(4, '\0'), std::string(4, '\xff'), std::string("\x01\x00\x01\x00", 4)}) {
    Json told;
    do {
      Peer peer(server_->where());
      peer.Send(bytes);
      told = peer.Receive();
    } while (told["error"]["kind"] == "busy");
    EXPECT_THAT(told["error"]["message"], HasSubstr("valid are 1 to 65536"));
  }
  ExpectServes();
}

TEST_F(LockstepServerTest, AFloodOfRequestsWithOneTokenFliesOneStep) {
  Begin();
  Peer peer(server_->where());
  peer.Hello();
  peer.Ask("reset", kBlindUnrecorded);
  const double from_s = peer.Ask("truth")["now"]["t_s"];
  const std::string step =
      Framed(fmt::format(R"({{"request":"advance","token":{},"duration_s":0.1}})", peer.token));
  constexpr int kFlood = 500;
  std::jthread flood([&] {
    for (int i = 0; i < kFlood; ++i) peer.Send(step);
  });
  EXPECT_EQ(peer.Receive()["ok"], true);
  for (int i = 1; i < kFlood; ++i)
    ASSERT_THAT(peer.Receive()["error"]["message"], HasSubstr("was used before"));
  flood.join();
  EXPECT_NEAR(peer.Ask("truth")["now"]["t_s"], from_s + 0.1, 1e-9);
}

TEST_F(LockstepServerTest, AClientThatReadsNothingFillsNoMemoryAndIsSentAway) {
  options_.timeout_s = 0.3;
  Begin();
  Peer peer(server_->where());
  peer.Hello();
  const std::string request = Framed(R"({"request":"step","token":0})");
  std::size_t taken = 0;
  while (peer.Send(request) && taken < 100'000'000) taken += request.size();
  EXPECT_LT(taken, 100'000'000u);  // what the system keeps of a socket, and no more
  ExpectServes();
}

TEST_F(LockstepServerTest, AClientThatHangsEndsItsFlight) {
  options_.timeout_s = 0.2;
  Begin();
  Peer peer(server_->where());
  peer.Hello();
  peer.Ask("reset", kBlind);
  EXPECT_THAT(peer.Receive()["error"]["message"], HasSubstr("said nothing for too long"));
  EXPECT_EQ(peer.Receive(), nullptr);
  ExpectServes();
  EXPECT_THAT(records::ReadSummary(folder_ / "flight/summary.json").error, HasSubstr("said nothing"));
}

TEST_F(LockstepServerTest, AnEndFromOutsideEndsTheFlightAndTellsTheClient) {
  Begin();
  Peer peer(server_->where());
  peer.Hello();
  peer.Ask("reset", kBlind);
  End();
  EXPECT_EQ(peer.Receive()["error"]["message"], "the server ends");
  ASSERT_TRUE(last_);
  EXPECT_FALSE(last_->complete);
  EXPECT_FALSE(std::filesystem::exists(folder_ / "socket"));
}

TEST_F(LockstepServerTest, WithOnceItEndsAfterItsFirstClient) {
  options_.once = true;
  Begin();
  {
    Peer peer(server_->where());
    peer.Hello();
    peer.Ask("reset", kBlindUnrecorded);
    peer.Ask("finish", R"(,"outcome":"tired")");
    peer.Ask("bye");
  }
  thread_.join();
  ASSERT_TRUE(last_);
  EXPECT_EQ(last_->outcome, "tired");
}

TEST_F(LockstepServerTest, WhoConnectsAndSaysNothingIsNotTheClientOfOnce) {
  options_.once = true;
  Begin();
  { Peer probe(server_->where()); }
  Peer peer(server_->where());
  EXPECT_EQ(peer.Hello()["ok"], true);
  peer.Ask("reset", kBlindUnrecorded);
  peer.Ask("finish", R"(,"outcome":"tired")");
  peer.Ask("bye");
  thread_.join();
  ASSERT_TRUE(last_);
  EXPECT_EQ(last_->outcome, "tired");
}

TEST_F(LockstepServerTest, WhoLeavesMakesRoomAtOnce) {
  Begin();
  for (int i = 0; i < 30; ++i) EXPECT_EQ(Peer(server_->where()).Hello()["ok"], true);
}

TEST_F(LockstepServerTest, RecordsThatFailBreakTheFlightOffAndItsSummaryHasWhy) {
  options_.once = true;
  std::string said;
  flight_.say = [&](const std::string& what) { said += what + "\n"; };
  Begin();
  {
    Peer peer(server_->where());
    peer.Hello();
    peer.Ask("reset", kBlind);
    std::filesystem::rename(folder_ / "flight", folder_ / "elsewhere");
    EXPECT_EQ(peer.Ask("finish", R"(,"outcome":"tired")")["error"]["kind"], "broke off");
    peer.Ask("bye");
  }
  thread_.join();
  ASSERT_TRUE(last_);
  EXPECT_FALSE(last_->complete);
  EXPECT_THAT(last_->error, HasSubstr("cannot write"));
  EXPECT_THAT(said, HasSubstr("cannot write"));
}

TEST_F(LockstepServerTest, ListensWhereItMayAndSaysWhereNot) {
  const auto listen = [&] { LockstepServer(options_, flight_, *loaded_); };
  std::ofstream(folder_ / "socket") << "precious";
  EXPECT_THAT(listen, ThrowsMessage<std::runtime_error>(HasSubstr("no socket has that name")));
  EXPECT_TRUE(std::filesystem::exists(folder_ / "socket"));
  std::filesystem::remove(folder_ / "socket");
  Begin();
  struct stat there {};
  ASSERT_EQ(stat((folder_ / "socket").c_str(), &there), 0);
  EXPECT_EQ(there.st_mode & 0777, 0600u);  // of this user alone
  EXPECT_THAT(listen, ThrowsMessage<std::runtime_error>(HasSubstr("another server listens there")));
  EXPECT_THAT(LockstepAddressMistake("tcp:nine"), HasSubstr("has no port"));
  EXPECT_THAT(LockstepAddressMistake(std::string(200, 'x')), HasSubstr("longer than"));
}

TEST_F(LockstepServerTest, TakesTheNameOfAServerThatWasKilled) {
  const int dead = socket(AF_UNIX, SOCK_STREAM, 0);
  sockaddr_un at{};
  at.sun_family = AF_UNIX;
  (folder_ / "socket").string().copy(at.sun_path, sizeof at.sun_path - 1);
  ASSERT_EQ(bind(dead, reinterpret_cast<sockaddr*>(&at), sizeof at), 0);
  close(dead);
  Begin();
  ExpectServes();
}

}  // namespace
}  // namespace kestrel::flight
