// SPDX-License-Identifier: Apache-2.0
#include "flight/live/foxglove.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cstring>
#include <nlohmann/json.hpp>

#include "base/nanoseconds.h"
#include "base/printable.h"
#include "base/ros/schemas.h"
#include "base/ros/sensor_messages.h"
#include "flight/live/feed.h"

namespace kestrel::flight {
namespace {

using nlohmann::json;

constexpr std::size_t kMaxWaiting_bytes = 4 << 20;    // of a slow client
constexpr std::size_t kImageWaiting_bytes = 1 << 20;  // with which it gets no further images
constexpr std::size_t kMaxSubscriptions = 256, kMaxTexts = 64;
constexpr char kMessageData = 1, kTime = 2;  // the first byte of a binary message
enum StatusLevel { kInfo = 0, kWarning = 1, kError = 2 };

static_assert(std::endian::native == std::endian::little, "numbers are copied as they are");
template <class T>
void Append(std::string& bytes, T value) {
  bytes.append(reinterpret_cast<const char*>(&value), sizeof value);
}

std::uint64_t LogTime(std::int64_t ns) { return static_cast<std::uint64_t>(std::max<std::int64_t>(0, ns)); }

bool IsId(const json& value) {
  return value.is_number_unsigned() && value.get<std::uint64_t>() <= UINT32_MAX;
}

}  // namespace

class FoxgloveClient final : public Conversation {
 public:
  explicit FoxgloveClient(Foxglove& all) : all_(all) {
    all_.clients_.insert(this);
    Greet();
  }
  ~FoxgloveClient() override { all_.clients_.erase(this); }

  // Of a flight that begins.
  void Greet() {
    channels_.clear();
    data_.clear();
    waiting_bytes_ = 0;
    texts_.clear();
    if (all_.info_.empty()) return;
    texts_.push_back(TextMessage(all_.info_));
    Advertise(all_.channels_);
  }
  void Advertise(const std::vector<Foxglove::Channel>& channels) {
    json all = json::array();
    for (const Foxglove::Channel& each : channels)
      all.push_back({{"id", each.id},
                     {"topic", each.topic},
                     {"encoding", "cdr"},
                     {"schemaName", each.type},
                     {"schemaEncoding", "ros2msg"},
                     {"schema", ros::SchemaOf(each.type)}});
    if (!all.empty()) texts_.push_back(TextMessage(TextOf({{"op", "advertise"}, {"channels", all}})));
  }

  void Hear(std::string_view message, bool binary) override {
    if (binary) return Refuse("this server takes no messages");
    const json parsed = json::parse(message, nullptr, false);
    if (!parsed.is_object() || !parsed.contains("op") || !parsed["op"].is_string())
      return Refuse("that is no object of JSON with an \"op\"");
    const std::string op = parsed["op"];
    if (op == "subscribe")
      ForEach(parsed, "subscriptions", [this](const json& each) { Subscribe(each); });
    else if (op == "unsubscribe")
      ForEach(parsed, "subscriptionIds", [this](const json& each) {
        if (!IsId(each) || channels_.erase(each.get<std::uint32_t>()) == 0)
          Refuse("there is no such subscription");
      });
    else
      Refuse(fmt::format("'{}' is not offered; valid: subscribe, unsubscribe", Printable(op.substr(0, 100))));
  }
  void Refuse(const std::string& why) override { Status(kError, why); }

  std::optional<LiveMessage> Next() override {
    if (!texts_.empty()) {
      LiveMessage text = std::move(texts_.front());
      texts_.pop_front();
      return text;
    }
    if (data_.empty()) return std::nullopt;
    LiveMessage message = std::move(data_.front());
    data_.pop_front();
    waiting_bytes_ -= message.bytes->size();
    return message;
  }

  bool Wants(std::uint32_t channel) const {
    return std::ranges::any_of(channels_, [&](const auto& each) { return each.second == channel; });
  }
  bool keeps_up() const { return waiting_bytes_ < kImageWaiting_bytes; }
  void Message(std::uint32_t channel, std::int64_t log_time_ns, const std::string& cdr) {
    for (const auto& [subscription, of] : channels_) {
      if (of != channel) continue;
      std::string bytes(1, kMessageData);
      Append(bytes, subscription);
      Append(bytes, LogTime(log_time_ns));
      Push(bytes + cdr);
    }
  }
  void Time(std::int64_t t_ns) {
    std::string bytes(1, kTime);
    Append(bytes, LogTime(t_ns));
    Push(std::move(bytes));
  }

 private:
  void Push(std::string bytes) {
    waiting_bytes_ += bytes.size();
    data_.push_back({std::make_shared<const std::string>(std::move(bytes)), true});
    while (waiting_bytes_ > kMaxWaiting_bytes && data_.size() > 1) {
      waiting_bytes_ -= data_.front().bytes->size();
      data_.pop_front();
    }
  }
  void Status(StatusLevel level, const std::string& message) {
    if (texts_.size() < kMaxTexts)
      texts_.push_back(
          TextMessage(TextOf({{"op", "status"}, {"level", static_cast<int>(level)}, {"message", message}})));
  }
  template <class Do>
  void ForEach(const json& message, const char* key, const Do& act) {
    const auto list = message.find(key);
    if (list == message.end() || !list->is_array()) return Refuse(fmt::format("it has no list '{}'", key));
    for (const json& each : *list) act(each);
  }
  void Subscribe(const json& wanted) {
    if (!wanted.is_object() || !wanted.contains("id") || !wanted.contains("channelId") ||
        !IsId(wanted["id"]) || !IsId(wanted["channelId"]))
      return Refuse("a subscription has an \"id\" and a \"channelId\"");
    const std::uint32_t id = wanted["id"], channel = wanted["channelId"];
    if (!all_.Find(channel)) return Refuse(fmt::format("there is no channel {}", channel));
    if (channels_.size() >= kMaxSubscriptions) return Refuse("these are too many subscriptions");
    if (!channels_.try_emplace(id, channel).second)
      return Refuse(fmt::format("there is a subscription {} already", id));
    all_.Repeat(*this, channel);
  }

  Foxglove& all_;
  std::map<std::uint32_t, std::uint32_t> channels_;  // by subscription
  std::deque<LiveMessage> texts_, data_;
  std::size_t waiting_bytes_ = 0;
};

class Foxglove::Messages final : public records::FlightMessages {
 public:
  Messages(Foxglove& all, const records::FlightMessageOptions& options)
      : FlightMessages(options), all_(all) {}

  struct Only {
    FoxgloveClient* client;
    std::uint32_t channel;
  };
  std::optional<Only> only;  // what is made is for this one

 private:
  bool Wants(const std::string& topic, const char* type) override {
    const std::uint32_t id = all_.ChannelOf(topic, type).id;
    if (only) return only->channel == id;
    return std::ranges::any_of(all_.clients_, [&](const FoxgloveClient* each) { return each->Wants(id); });
  }
  void WriteCdr(const std::string& topic, const char* type, std::int64_t log_time_ns, std::int64_t,
                const std::string& cdr) override {
    const std::uint32_t id = all_.ChannelOf(topic, type).id;
    if (only) return only->client->Message(id, log_time_ns, cdr);
    for (FoxgloveClient* each : all_.clients_) each->Message(id, log_time_ns, cdr);
  }

  Foxglove& all_;
};

Foxglove::Foxglove() = default;
Foxglove::~Foxglove() = default;

void Foxglove::Begin(const std::string& name, const std::optional<records::FlightMessageOptions>& options) {
  channels_.clear();
  last_.reset();
  last_image_.release();
  messages_ = options ? std::make_unique<Messages>(*this, *options) : nullptr;
  info_ = TextOf({{"op", "serverInfo"},
                  {"name", name},
                  {"capabilities", json::array({"time"})},
                  {"supportedEncodings", json::array()},
                  {"metadata", json::object()},
                  {"sessionId", std::to_string(++sessions_)}});
  for (FoxgloveClient* each : clients_) each->Greet();
}

std::unique_ptr<Conversation> Foxglove::Join() {
  auto client = std::make_unique<FoxgloveClient>(*this);
  if (messages_ && last_) messages_->Write(*last_, last_image_);  // what channels there are
  return client;
}

const Foxglove::Channel& Foxglove::ChannelOf(const std::string& topic, const char* type) {
  const auto found = std::ranges::find(channels_, topic, &Channel::topic);
  if (found != channels_.end()) return *found;
  channels_.push_back({next_id_++, topic, type});
  for (FoxgloveClient* each : clients_) each->Advertise({channels_.back()});
  return channels_.back();
}

const Foxglove::Channel* Foxglove::Find(std::uint32_t id) const {
  const auto found = std::ranges::find(channels_, id, &Channel::id);
  return found == channels_.end() ? nullptr : &*found;
}

void Foxglove::Repeat(FoxgloveClient& client, std::uint32_t channel) {
  if (!messages_ || !last_) return;
  messages_->only = Messages::Only{&client, channel};
  messages_->Write(*last_, last_image_);
  messages_->only.reset();
}

void Foxglove::Row(const mission::LogRow& row, const cv::Mat& image) {
  last_ = row;
  last_image_ = image;
  if (!messages_ || !watched()) return;
  for (FoxgloveClient* each : clients_) each->Time(Nanoseconds(row.now.t_s));
  messages_->Write(row, image);
}

void Foxglove::Event(double t_s, std::string_view what, std::string_view is) {
  if (messages_ && watched()) messages_->WriteEvent(t_s, what, is);
}

bool Foxglove::wants_images() const {
  const auto image = std::ranges::find(channels_, ros::CompressedImage::kType, &Channel::type);
  if (image == channels_.end()) return watched();  // that they are there is yet to be said
  return std::ranges::any_of(
      clients_, [&](const FoxgloveClient* each) { return each->keeps_up() && each->Wants(image->id); });
}

}  // namespace kestrel::flight
