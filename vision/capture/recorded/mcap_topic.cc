// SPDX-License-Identifier: Apache-2.0
#include "vision/capture/recorded/mcap_topic.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <set>
#include <utility>

#include "base/nearest_name.h"
#include "base/ros/cdr.h"
#include "base/ros/messages.h"
#include "vision/capture/recorded/stamped_table.h"

namespace kestrel::vision {
namespace {

constexpr int kMaxWrongTold = 20;

bool IsOf(const mcap::Channel& channel, const std::vector<std::string>& types) {
  return channel.message_encoding == "cdr" &&
         std::find(types.begin(), types.end(), channel.schema.name) != types.end();
}

// All topics, with what they are of.
std::string AllTopics(const mcap::Reader& reader) {
  std::set<std::string> all;
  for (const auto& [number, channel] : reader.channels())
    all.insert(fmt::format("{} ({}{})", channel.topic,
                           channel.schema.name.empty() ? "without a schema" : channel.schema.name,
                           channel.message_encoding == "cdr" ? "" : " in " + channel.message_encoding));
  return all.empty() ? "it has no topics" : fmt::format("its topics are {}", fmt::join(all, ", "));
}

}  // namespace

std::vector<std::string> TopicsOf(const mcap::Reader& reader, const std::vector<std::string>& types) {
  std::set<std::string> topics;
  for (const auto& [number, channel] : reader.channels())
    if (IsOf(channel, types)) topics.insert(channel.topic);
  return {topics.begin(), topics.end()};
}

std::optional<std::string> TopicOf(const mcap::Reader& reader, const std::filesystem::path& file,
                                   const std::string& topic, const std::vector<std::string>& types,
                                   const std::string& what, Mistakes& mistakes) {
  const std::vector<std::string> topics = TopicsOf(reader, types);
  const std::string valid = fmt::format("valid: {}", fmt::join(topics, ", "));
  const auto refuse = [&](const std::string& wrong, const std::string& remedy) {
    mistakes.Add(file.string(), "topic", wrong, remedy);
    return std::nullopt;
  };
  if (topics.empty())
    return refuse(fmt::format("no topic of it has {}; {}", what, AllTopics(reader)),
                  fmt::format("valid: one of {} in CDR", fmt::join(types, ", ")));
  if (topic.empty() && topics.size() > 1)
    return refuse(fmt::format("{} of its topics have {}, and none is named", topics.size(), what), valid);
  if (topic.empty()) return topics.front();
  if (std::find(topics.begin(), topics.end(), topic) != topics.end()) return topic;
  const auto near = NearestName(topic, topics);
  return refuse(fmt::format("no topic '{}' of it has {}", topic, what),
                near ? fmt::format("did you mean {}? {}", *near, valid) : valid);
}

std::string McapStamps::NameOf(std::size_t message) const {
  return fmt::format("{}: message {} of {}", file_.string(), message + 1, topic_);
}

void McapStamps::Wrong(const std::string& what) {
  if (++wrong_ <= kMaxWrongTold) mistakes_.Add(NameOf(stamps_ns_.size() - 1), "", what);
}

void McapStamps::Add(const mcap::Message& message) {
  stamps_ns_.push_back(0);
  logged_ns_.push_back(static_cast<std::int64_t>(message.log_time_ns));
  try {
    stamps_ns_.back() = ros::Nanoseconds(ros::FromCdr<ros::Header>(message.data).stamp);
  } catch (const ros::CdrError& e) {
    Wrong(e.what());
  }
}

std::vector<std::int64_t> McapStamps::Take() {
  by_log_ = std::all_of(stamps_ns_.begin(), stamps_ns_.end(), [](std::int64_t ns) { return ns == 0; });
  const std::vector<std::int64_t>& stamps_ns = by_log_ ? logged_ns_ : stamps_ns_;
  StampOrder order;
  for (std::size_t i = 0; i < stamps_ns.size(); ++i)
    if (const std::string late = order.Next(stamps_ns[i], std::to_string(stamps_ns[i])); !late.empty())
      if (++wrong_ <= kMaxWrongTold)
        mistakes_.Add(NameOf(i), "", late, "valid: stamps in ns in the order of time, each once");
  if (wrong_ > kMaxWrongTold)
    mistakes_.Add(file_.string(), "",
                  fmt::format("and {} more mistakes of {}", wrong_ - kMaxWrongTold, topic_));
  return stamps_ns;
}

std::string McapStamps::Note(const mcap::Reader& reader, const std::string& what) const {
  std::string note;
  if (!reader.damage().empty())
    note = fmt::format("{}: {}; the {} that are whole are read, the rest is missing", file_.string(),
                       reader.damage(), what);
  if (by_log_)
    note += fmt::format("{}{}: the headers of {} have no stamps; when they were logged is taken",
                        note.empty() ? "" : "\n", file_.string(), topic_);
  return note;
}

}  // namespace kestrel::vision
