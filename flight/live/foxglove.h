// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "flight/live/conversation.h"
#include "mission/log_row.h"
#include "records/mcap/flight_messages.h"

namespace kestrel::flight {

class FoxgloveClient;

// A flight for clients of Foxglove's WebSocket protocol (github.com/foxglove/ws-protocol, version 1): the
// topics, schemas and bytes that flight.mcap has. Messages are made while somebody has subscribed to them. A
// client that is slow misses the oldest.
class Foxglove {
 public:
  static constexpr const char* kSubprotocols[] = {"foxglove.websocket.v1", "foxglove.sdk.v1"};

  Foxglove();
  ~Foxglove();
  // A flight begins; its channels are new. messages: none: nothing is offered.
  void Begin(const std::string& name, const std::optional<records::FlightMessageOptions>& messages);
  void Row(const mission::LogRow& row, const cv::Mat& image);
  void Event(double t_s, std::string_view what, std::string_view is);

  std::unique_ptr<Conversation> Join();  // must be gone before this is
  bool watched() const { return !clients_.empty(); }
  bool wants_images() const;

 private:
  friend class FoxgloveClient;
  struct Channel {
    std::uint32_t id;
    std::string topic, type;
  };
  class Messages;

  const Channel& ChannelOf(const std::string& topic, const char* type);
  const Channel* Find(std::uint32_t id) const;
  // The newest row, for who has just subscribed.
  void Repeat(FoxgloveClient& client, std::uint32_t channel);

  std::string info_;
  std::vector<Channel> channels_;
  std::uint32_t next_id_ = 1;
  std::unique_ptr<Messages> messages_;
  std::optional<mission::LogRow> last_;
  cv::Mat last_image_;
  std::set<FoxgloveClient*> clients_;
  int sessions_ = 0;
};

}  // namespace kestrel::flight
