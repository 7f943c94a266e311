// SPDX-License-Identifier: Apache-2.0
#include "control/link/session_socket.h"

#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <string>
#include <vector>

namespace kestrel::control {
namespace {

using boost::asio::ip::udp;
using boost::system::error_code;

constexpr int kFlood = 4000;  // more than a queue holds
const auto kLoopback = boost::asio::ip::make_address("127.0.0.1");

boost::asio::io_context& Io() {
  static boost::asio::io_context io;
  return io;
}

struct Peer {
  explicit Peer(const udp::endpoint& to_, const udp::endpoint& at = {kLoopback, 0})
      : to(to_), socket(Io(), at) {}
  void Say(const std::string& what) {
    error_code ignored;
    socket.send_to(boost::asio::buffer(what), to, 0, ignored);
  }
  udp::endpoint Where() const { return socket.local_endpoint(); }
  udp::endpoint to;
  udp::socket socket;
};

std::string Text(const std::optional<SessionSocket::Datagram>& datagram) {
  return datagram ? std::string(datagram->bytes.begin(), datagram->bytes.end()) : "nothing";
}

// Whether a program may listen there too that allows others all that there is to allow.
bool MayBind(const udp::endpoint& at) {
  udp::socket socket(Io(), at.protocol());
  const int yes = 1;
  setsockopt(socket.native_handle(), SOL_SOCKET, SO_REUSEADDR, &yes, sizeof yes);
  setsockopt(socket.native_handle(), SOL_SOCKET, SO_REUSEPORT, &yes, sizeof yes);
  error_code error;
  socket.bind(at, error);
  return !error;
}

struct SessionSocketTest : testing::Test {
  SessionSocketTest() {
    error_code error;
    socket.Open({kLoopback, 0}, error);
    EXPECT_FALSE(error) << error.message();
  }
  SessionSocket socket{Io()};
};

TEST_F(SessionSocketTest, WhatTheOwnerSaysIsFoundHoweverMuchOthersSay) {
  Peer owner(socket.Where()), other(socket.Where());
  socket.Own(owner.Where());
  for (int i = 0; i < kFlood; ++i) other.Say("mine");
  for (const char* said : {"1", "2", "3"}) owner.Say(said);
  for (const char* said : {"1", "2", "3", "nothing"}) EXPECT_EQ(Text(socket.FromOwner()), said);
  EXPECT_EQ(Text(socket.FromOthers()), "mine");
}

TEST_F(SessionSocketTest, WhatTheOwnerSaidBeforeItWasOneComesFirstAndInItsOrder) {
  Peer owner(socket.Where()), other(socket.Where());
  for (const char* said : {"open", "1", "2"}) owner.Say(said), other.Say("mine");
  const auto first = socket.FromOthers();
  socket.Own(first->from);
  EXPECT_EQ(Text(first), "open");  // still
  owner.Say("3");
  for (const char* said : {"1", "2", "3", "nothing"}) EXPECT_EQ(Text(socket.FromOwner()), said);
  EXPECT_EQ(Text(socket.FromOthers()), "nothing");
}

TEST_F(SessionSocketTest, ASessionGoesFromOneToAnother) {
  Peer first(socket.Where()), second(socket.Where());
  for (Peer* owner : {&first, &second, &first}) {
    socket.Own(owner->Where());
    first.Say("first"), second.Say("second");
    EXPECT_EQ(Text(socket.FromOwner()), owner == &first ? "first" : "second");
    EXPECT_EQ(Text(socket.FromOthers()), owner == &first ? "second" : "first");
  }
  socket.Release();
  EXPECT_FALSE(socket.owner());
  first.Say("first");
  EXPECT_EQ(Text(socket.FromOwner()), "nothing");
  EXPECT_EQ(Text(socket.FromOthers()), "first");
}

TEST_F(SessionSocketTest, AnswersComeFromThePortThatWasAsked) {
  Peer owner(socket.Where());
  socket.Own(owner.Where());
  const std::vector<std::uint8_t> answer{'y'};
  EXPECT_FALSE(socket.Send(answer, owner.Where()));
  char byte = 0;
  udp::endpoint from;
  owner.socket.receive_from(boost::asio::buffer(&byte, 1), from);
  EXPECT_EQ(from, socket.Where());
}

TEST_F(SessionSocketTest, AnOwnerThatIsNotThereHidesNobody) {
  udp::endpoint gone;
  {
    const Peer owner(socket.Where());
    gone = owner.Where();
  }
  socket.Own(gone);
  socket.Send(std::vector<std::uint8_t>{1}, gone);  // and is told that nobody was at home
  Peer back(socket.Where(), gone);
  back.Say("back");
  EXPECT_EQ(Text(socket.FromOwner()), "back");
}

TEST_F(SessionSocketTest, NobodyElseMayListenThere) {
  const Peer owner(socket.Where());
  EXPECT_FALSE(MayBind(socket.Where()));
  socket.Own(owner.Where());
  EXPECT_FALSE(MayBind(socket.Where()));
  socket.Release();
  EXPECT_FALSE(MayBind(socket.Where()));
}

TEST_F(SessionSocketTest, NotEvenWhileASessionBeginsMayAnotherUser) {
  if (getuid() != 0) GTEST_SKIP() << "only root can be another user";
  const Peer owner(socket.Where());
  int ready[2];
  ASSERT_EQ(pipe(ready), 0);
  const pid_t child = fork();
  if (child == 0) {
    if (setuid(65534) != 0) _exit(2);
    for (char once = 1;; once = 0) {
      if (MayBind(socket.Where())) _exit(1);
      if (once && write(ready[1], &once, 1) != 1) _exit(2);
    }
  }
  char byte = 0;
  EXPECT_EQ(read(ready[0], &byte, 1), 1);
  for (int i = 0; i < 2000; ++i) socket.Own(owner.Where());
  kill(child, SIGKILL);
  int status = 0;
  ASSERT_EQ(waitpid(child, &status, 0), child);
  EXPECT_TRUE(WIFSIGNALED(status)) << WEXITSTATUS(status);
  close(ready[0]), close(ready[1]);
}

TEST(SessionSocket, EveryKindOfAddressHasSessions) {
  struct Case {
    const char *server, *peer, *seen;
  };
  for (const Case& c : {Case{"0.0.0.0", "127.0.0.1", "127.0.0.1"}, Case{"::1", "::1", "::1"},
                        Case{"::", "::1", "::1"}, Case{"::", "127.0.0.1", "::ffff:127.0.0.1"}}) {
    SCOPED_TRACE(std::string(c.server) + " " + c.peer);
    const auto at = boost::asio::ip::make_address(c.server), from = boost::asio::ip::make_address(c.peer);
    SessionSocket socket(Io());
    error_code error;
    socket.Open({at, 0}, error);
    if (error && at.is_v6()) GTEST_SKIP() << "no IPv6 here: " << error.message();
    ASSERT_FALSE(error) << error.message();
    const udp::endpoint where(from, socket.Where().port());
    Peer owner(where, {from, 0}), other(where, {from, 0});
    owner.Say("open");
    const auto first = socket.FromOthers();
    ASSERT_TRUE(first);
    EXPECT_EQ(first->from.address(), boost::asio::ip::make_address(c.seen));
    socket.Own(first->from);
    for (int i = 0; i < kFlood; ++i) other.Say("mine");
    owner.Say("1");
    EXPECT_EQ(Text(socket.FromOwner()), "1");
    EXPECT_EQ(Text(socket.FromOthers()), "mine");
    EXPECT_FALSE(socket.Send(std::vector<std::uint8_t>{'y'}, first->from));
    char byte = 0;
    EXPECT_EQ(owner.socket.receive(boost::asio::buffer(&byte, 1)), 1U);
  }
}

}  // namespace
}  // namespace kestrel::control
