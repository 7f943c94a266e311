// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <string_view>

namespace kestrel::flight {

struct LiveMessage {
  std::shared_ptr<const std::string> bytes;  // shared by all viewers that get it
  bool binary = false;
};

inline LiveMessage TextMessage(std::string text) {
  return {std::make_shared<const std::string>(std::move(text)), false};
}

// What is said with one viewer, whatever carries it. All on the server's thread.
class Conversation {
 public:
  virtual ~Conversation() = default;
  virtual void Hear(std::string_view message, bool binary) = 0;
  // That it says too much to be heeded.
  virtual void Refuse(const std::string& why) = 0;
  // What it is to be told next; asked again whenever it has been told, so that a slow viewer has no queue that
  // grows. None: nothing for now.
  virtual std::optional<LiveMessage> Next() = 0;
};

}  // namespace kestrel::flight
