// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <optional>
#include <stdexcept>

#include "records/log/log_tables.h"

namespace kestrel::records {
namespace {

constexpr std::size_t kMaxFields = 4000;

struct UlogField {
  std::string type, name;
  std::size_t count = 1;
  bool array = false;
};
using UlogFormats = std::map<std::string, std::vector<UlogField>, std::less<>>;

// Where a number lies in a message.
struct UlogNumber {
  std::string name, type;
  std::size_t at = 0;
};

template <class T>
double UlogValue(const char* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return static_cast<double>(value);
}

struct UlogType {
  const char* name;
  std::size_t size;
  double (*read)(const char*);
};
constexpr UlogType kUlogTypes[] = {
    {"int8_t", 1, UlogValue<std::int8_t>},   {"uint8_t", 1, UlogValue<std::uint8_t>},
    {"int16_t", 2, UlogValue<std::int16_t>}, {"uint16_t", 2, UlogValue<std::uint16_t>},
    {"int32_t", 4, UlogValue<std::int32_t>}, {"uint32_t", 4, UlogValue<std::uint32_t>},
    {"int64_t", 8, UlogValue<std::int64_t>}, {"uint64_t", 8, UlogValue<std::uint64_t>},
    {"float", 4, UlogValue<float>},          {"double", 8, UlogValue<double>},
    {"bool", 1, UlogValue<std::uint8_t>},    {"char", 1, UlogValue<std::uint8_t>}};

const UlogType* UlogTypeOf(std::string_view name) {
  for (const UlogType& each : kUlogTypes)
    if (name == each.name) return &each;
  return nullptr;
}

std::vector<UlogField> UlogFieldsOf(std::string_view text) {
  std::vector<UlogField> fields;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find(';'), text.size());
    const std::string_view part = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    const std::size_t space = part.find(' ');
    if (space == std::string_view::npos) continue;
    UlogField field{std::string(part.substr(0, space)), std::string(part.substr(space + 1))};
    if (const std::size_t bracket = field.type.find('['); bracket != std::string::npos) {
      field.array = true;
      const char* from = field.type.data() + bracket + 1;
      if (std::from_chars(from, field.type.data() + field.type.size(), field.count).ec != std::errc() ||
          field.count > kMaxFields)
        throw std::runtime_error(fmt::format("the format of '{}' is none", field.name));
      field.type.resize(bracket);
    }
    fields.push_back(std::move(field));
  }
  return fields;
}

// The numbers of a format, from at on; at comes behind them.
void LayOut(const UlogFormats& formats, std::string_view format, const std::string& before, std::size_t& at,
            std::vector<UlogNumber>& numbers, int depth) {
  const auto found = formats.find(format);
  if (found == formats.end() || depth > 8)
    throw std::runtime_error(fmt::format("there is no format '{}'", format));
  for (const UlogField& field : found->second) {
    for (std::size_t i = 0; i < field.count; ++i) {
      const std::string name = before + field.name + (field.array ? fmt::format("[{}]", i) : "");
      if (const UlogType* type = UlogTypeOf(field.type)) {
        if (!field.name.starts_with("_padding")) numbers.push_back({name, field.type, at});
        at += type->size;
      } else {
        LayOut(formats, field.type, name + ".", at, numbers, depth + 1);
      }
      if (numbers.size() > kMaxFields)
        throw std::runtime_error(fmt::format("'{}' has too many fields", format));
    }
  }
}

struct UlogTopic {
  LogTable* table = nullptr;
  std::vector<UlogNumber> numbers;
};

}  // namespace

LogTables ReadUlog(std::string_view bytes) {
  constexpr std::string_view kMagic = "ULog\x01\x12\x35";
  if (bytes.size() < 16 || !bytes.starts_with(kMagic)) throw std::runtime_error("is no ULog");
  UlogFormats formats;
  std::map<std::uint16_t, UlogTopic> topics;
  LogTables tables;
  for (std::size_t at = 16; at + 3 <= bytes.size();) {
    std::uint16_t size = 0;
    std::memcpy(&size, bytes.data() + at, 2);
    const char type = bytes[at + 2];
    if (at + 3 + size > bytes.size()) break;  // cut off
    const std::string_view body = bytes.substr(at + 3, size);
    at += 3u + size;
    if (type == 'F') {
      const std::size_t colon = body.find(':');
      if (colon == std::string_view::npos) throw std::runtime_error("has a format without a name");
      formats[std::string(body.substr(0, colon))] = UlogFieldsOf(body.substr(colon + 1));
    } else if (type == 'A' && body.size() > 3) {
      if (body[0] != 0) continue;  // another instance
      std::uint16_t id = 0;
      std::memcpy(&id, body.data() + 1, 2);
      const std::string name(body.substr(3));
      UlogTopic topic{&tables[name], {}};
      std::size_t length = 0;
      LayOut(formats, name, "", length, topic.numbers, 0);
      topics[id] = std::move(topic);
    } else if (type == 'D' && body.size() >= 2) {
      std::uint16_t id = 0;
      std::memcpy(&id, body.data(), 2);
      const auto topic = topics.find(id);
      if (topic == topics.end() || topic->second.numbers.empty()) continue;
      const std::string_view data = body.substr(2);
      const UlogNumber& last = topic->second.numbers.back();
      if (last.at + UlogTypeOf(last.type)->size > data.size()) continue;  // damaged
      for (const UlogNumber& number : topic->second.numbers) {
        const double value = UlogTypeOf(number.type)->read(data.data() + number.at);
        if (number.name == "timestamp")
          (*topic->second.table)["t_s"].push_back(1e-6 * value);
        else
          (*topic->second.table)[number.name].push_back(value);
      }
    }
  }
  return tables;
}

}  // namespace kestrel::records
