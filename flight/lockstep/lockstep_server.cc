// SPDX-License-Identifier: Apache-2.0
#include "flight/lockstep/lockstep_server.h"

#include <fmt/format.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>

#include "flight/lockstep/lockstep_socket.h"

namespace kestrel::flight {
namespace {

using Clock = std::chrono::steady_clock;

// Who connects and has not said hello after this is sent away: there is one place.
constexpr double kIntroduction_s = 2;
constexpr auto kLook = std::chrono::milliseconds(100);  // at go_on
// What a client was told last may still be under way when it is sent away.
constexpr auto kLinger = std::chrono::seconds(1);
constexpr std::size_t kLingering = 16;
constexpr std::size_t kHead = 4, kReadBytes = 64 * 1024;

Clock::duration Seconds(double s) {
  return std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(s));
}

std::array<unsigned char, kHead> LengthOf(std::size_t size) {
  std::array<unsigned char, kHead> head{};
  for (std::size_t i = 0; i < kHead; ++i) head[i] = static_cast<unsigned char>(size >> 8 * i & 0xff);
  return head;
}

std::uint32_t LengthIn(const std::string& bytes) {
  std::uint32_t length = 0;
  for (std::size_t i = 0; i < kHead; ++i)
    length |= std::uint32_t{static_cast<unsigned char>(bytes[i])} << 8 * i;
  return length;
}

bool Gone(int client) {
  char next = 0;
  return recv(client, &next, 1, MSG_PEEK | MSG_DONTWAIT) == 0;
}

std::string BytesOf(const LockstepSession::Reply& reply) {
  const auto head = LengthOf(reply.json.size());
  const std::size_t pictures = PictureBytes(reply.pictures);
  std::string bytes;
  bytes.reserve(kHead + reply.json.size() + pictures);
  bytes.append(head.begin(), head.end()).append(reply.json);
  bytes.resize(bytes.size() + pictures);
  if (pictures > 0)
    CopyPictures(reply.pictures, reinterpret_cast<unsigned char*>(bytes.data()) + kHead + reply.json.size());
  return bytes;
}

}  // namespace

// Sent away, and not closed before it has read why: a socket that is closed on unread bytes takes back what it
// sent.
struct LockstepServer::Leaving {
  int descriptor;
  Clock::time_point until;
};

LockstepServer::LockstepServer(LockstepServerOptions options, LockstepOptions flight,
                               const LoadedScenario& loaded)
    : options_(std::move(options)), flight_(std::move(flight)), loaded_(loaded) {
  const LocalListener listener = ListenLocally(options_.address);
  listener_ = listener.descriptor;
  where_ = listener.where;
  file_ = listener.file;
}

LockstepServer::~LockstepServer() {
  for (const Leaving& each : leaving_) close(each.descriptor);
  close(listener_);
  if (!file_.empty()) unlink(file_.c_str());
}

std::optional<records::Summary> LockstepServer::Serve() {
  while (WaitFor(-1, 0, std::nullopt) != Wait::kStop) {
    const int client = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (client < 0) continue;  // it has gone again
    const int yes = 1;
    setsockopt(client, IPPROTO_TCP, TCP_NODELAY, &yes, sizeof yes);  // of Unix sockets it is refused
    const bool introduced = ServeClient(client);
    if (options_.once && introduced) break;
  }
  return summary_;
}

// Until there is something to do with this; without one, until somebody connects.
LockstepServer::Wait LockstepServer::WaitFor(int descriptor, short events, Deadline deadline) {
  for (;;) {
    const auto now = Clock::now();
    std::erase_if(leaving_, [&](const Leaving& each) {
      std::array<char, 4096> unread{};
      const bool over =
          now >= each.until || recv(each.descriptor, unread.data(), unread.size(), MSG_DONTWAIT) == 0;
      if (over) close(each.descriptor);
      return over;
    });
    if (!options_.go_on()) return Wait::kStop;
    if (deadline && now >= *deadline) return Wait::kTimeOut;
    const auto left = deadline ? std::min<Clock::duration>(*deadline - now, kLook) : Clock::duration(kLook);
    std::array<pollfd, 2> polled = {pollfd{listener_, POLLIN, 0}, pollfd{descriptor, events, 0}};
    const int wait_ms = static_cast<int>(std::chrono::ceil<std::chrono::milliseconds>(left).count());
    if (poll(polled.data(), polled.size(), wait_ms) <= 0) continue;
    if (descriptor < 0) return Wait::kReady;
    if ((polled[0].revents & POLLIN) != 0) {
      if (events == POLLIN && Gone(descriptor)) return Wait::kReady;  // then the other one may have its place
      TurnAway();
    }
    if (polled[1].revents != 0) return Wait::kReady;
  }
}

void LockstepServer::TurnAway() {
  const int second = accept4(listener_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
  if (second < 0) return;
  static const std::string busy =
      BytesOf({R"({"ok":false,"answers":null,"token":0,"error":{"kind":"busy","message":)"
               R"("another client flies: this server has one at a time"}})",
               {},
               true});
  (void)!send(second, busy.data(), busy.size(), MSG_NOSIGNAL);
  SendAway(second);
}

void LockstepServer::SendAway(int client) {
  shutdown(client, SHUT_WR);
  if (leaving_.size() == kLingering) {
    close(leaving_.front().descriptor);
    leaving_.erase(leaving_.begin());
  }
  leaving_.push_back({client, Clock::now() + kLinger});
}

std::optional<std::string> LockstepServer::Read(int client, Deadline deadline, std::string& message) {
  for (;;) {
    if (received_.size() >= kHead) {
      const std::uint32_t length = LengthIn(received_);
      if (length == 0 || length > kLongestRequest)
        return fmt::format("a message of {} bytes: valid are 1 to {}", length, kLongestRequest);
      if (received_.size() >= kHead + length) {
        message.assign(received_, kHead, length);
        received_.erase(0, kHead + length);
        return std::nullopt;
      }
    }
    switch (WaitFor(client, POLLIN, deadline)) {
      case Wait::kStop:
        return "the server ends";
      case Wait::kTimeOut:
        return "the client said nothing for too long";
      case Wait::kReady:
        break;
    }
    std::array<char, kReadBytes> bytes;  // NOLINT(cppcoreguidelines-pro-type-member-init): what recv fills
    const ssize_t size = recv(client, bytes.data(), bytes.size(), MSG_DONTWAIT);
    if (size < 0 && (errno == EAGAIN || errno == EINTR)) continue;
    if (size <= 0)
      return received_.empty()
                 ? "the client is gone"
                 : fmt::format("the client is gone in the middle of a message, after {} bytes of it",
                               received_.size());
    received_.append(bytes.data(), static_cast<std::size_t>(size));
  }
}

std::optional<std::string> LockstepServer::Send(int client, const LockstepSession::Reply& reply,
                                                Deadline deadline) {
  const std::string bytes = BytesOf(reply);
  std::size_t sent = 0;
  while (sent < bytes.size()) {
    const ssize_t size = send(client, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL | MSG_DONTWAIT);
    if (size >= 0) {
      sent += static_cast<std::size_t>(size);
    } else if (errno == EAGAIN) {
      const Wait wait = WaitFor(client, POLLOUT, deadline);
      if (wait == Wait::kStop) return "the server ends";
      if (wait == Wait::kTimeOut) return "the client read nothing for too long";
    } else if (errno != EINTR) {
      return "the client is gone";
    }
  }
  return std::nullopt;
}

bool LockstepServer::ServeClient(int client) {
  LockstepSession session(flight_, loaded_);
  received_.clear();
  std::optional<std::string> over;
  bool farewell = false;
  while (!over && !farewell) {
    Deadline deadline;
    if (options_.timeout_s) deadline = Clock::now() + Seconds(*options_.timeout_s);
    if (!session.introduced()) {
      const auto introduction = Clock::now() + Seconds(kIntroduction_s);
      deadline = deadline ? std::min(*deadline, introduction) : introduction;
    }
    std::string message;
    over = Read(client, deadline, message);
    if (over) break;
    const LockstepSession::Reply reply = session.Answer(message);
    farewell = reply.last;
    if (options_.timeout_s) deadline = Clock::now() + Seconds(*options_.timeout_s);
    over = Send(client, reply, deadline);
  }
  if (over) {
    session.Leave(*over);
    // Why it is sent away, as far as it still listens.
    const std::string last = BytesOf(session.Refuse("over", *over));
    (void)!send(client, last.data(), last.size(), MSG_NOSIGNAL | MSG_DONTWAIT);
  }
  if (session.summary()) summary_ = session.summary();
  SendAway(client);
  return session.introduced();
}

}  // namespace kestrel::flight
