// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <limits>
#include <stdexcept>

#include "records/log/log_tables.h"

namespace kestrel::records {
namespace {

constexpr unsigned char kHead[] = {0xA3, 0x95};
constexpr std::uint8_t kFormatId = 128;
constexpr std::size_t kFormatSize = 89;

template <class T>
double FlashValue(const char* at) {
  T value;
  std::memcpy(&value, at, sizeof value);
  return static_cast<double>(value);
}

struct FlashType {
  char letter;
  std::size_t size;
  double (*read)(const char*);  // null: no number
  double unit = 1;
};
constexpr FlashType kFlashTypes[] = {{'a', 64, nullptr},
                                     {'b', 1, FlashValue<std::int8_t>},
                                     {'B', 1, FlashValue<std::uint8_t>},
                                     {'M', 1, FlashValue<std::uint8_t>},
                                     {'h', 2, FlashValue<std::int16_t>},
                                     {'H', 2, FlashValue<std::uint16_t>},
                                     {'c', 2, FlashValue<std::int16_t>, 0.01},
                                     {'C', 2, FlashValue<std::uint16_t>, 0.01},
                                     {'g', 2, nullptr},
                                     {'i', 4, FlashValue<std::int32_t>},
                                     {'I', 4, FlashValue<std::uint32_t>},
                                     {'e', 4, FlashValue<std::int32_t>, 0.01},
                                     {'E', 4, FlashValue<std::uint32_t>, 0.01},
                                     {'L', 4, FlashValue<std::int32_t>, 1e-7},
                                     {'f', 4, FlashValue<float>},
                                     {'d', 8, FlashValue<double>},
                                     {'q', 8, FlashValue<std::int64_t>},
                                     {'Q', 8, FlashValue<std::uint64_t>},
                                     {'n', 4, nullptr},
                                     {'N', 16, nullptr},
                                     {'Z', 64, nullptr}};

struct FlashFormat {
  std::size_t length = 0;  // with the head
  std::string name;
  struct Column {
    std::string name;
    std::size_t at;
    FlashType type;
  };
  std::vector<Column> columns;
};

std::string Padded(std::string_view text) { return std::string(text.substr(0, text.find('\0'))); }

FlashFormat FormatOf(std::string_view message) {
  FlashFormat format;
  format.length = static_cast<std::uint8_t>(message[4]);
  format.name = Padded(message.substr(5, 4));
  const std::string letters = Padded(message.substr(9, 16)), labels = Padded(message.substr(25, 64));
  std::size_t at = 3, label = 0;
  for (const char letter : letters) {
    const FlashType* type = nullptr;
    for (const FlashType& each : kFlashTypes)
      if (each.letter == letter) type = &each;
    if (!type) throw std::runtime_error("has a format with the letter '" + std::string(1, letter) + "'");
    const std::size_t end = std::min(labels.find(',', label), labels.size());
    if (type->read) format.columns.push_back({labels.substr(label, end - label), at, *type});
    at += type->size;
    label = std::min(end + 1, labels.size());
  }
  if (at != format.length)
    throw std::runtime_error("has a format '" + format.name + "' that contradicts its length");
  return format;
}

}  // namespace

LogTables ReadDataFlash(std::string_view bytes) {
  if (bytes.size() < 3 || std::memcmp(bytes.data(), kHead, 2) != 0)
    throw std::runtime_error("is no DataFlash log");
  std::map<std::uint8_t, FlashFormat> formats;
  LogTables tables;
  for (std::size_t at = 0; at + 3 <= bytes.size();) {
    if (std::memcmp(bytes.data() + at, kHead, 2) != 0) {
      ++at;  // damaged: on to the next head
      continue;
    }
    const auto id = static_cast<std::uint8_t>(bytes[at + 2]);
    if (id == kFormatId) {
      if (at + kFormatSize > bytes.size()) break;
      const FlashFormat format = FormatOf(bytes.substr(at, kFormatSize));
      formats[static_cast<std::uint8_t>(bytes[at + 3])] = format;
      at += kFormatSize;
      continue;
    }
    const auto format = formats.find(id);
    if (format == formats.end() || format->second.length < 3) {
      ++at;
      continue;
    }
    if (at + format->second.length > bytes.size()) break;
    LogTable& table = tables[format->second.name];
    for (const FlashFormat::Column& column : format->second.columns) {
      const double value = column.type.unit * column.type.read(bytes.data() + at + column.at);
      if (column.name == "TimeUS")
        table["t_s"].push_back(1e-6 * value);
      else
        table[column.name].push_back(value);
    }
    at += format->second.length;
  }
  if (formats.empty()) throw std::runtime_error("holds no format of a DataFlash log");
  return tables;
}

LogTable ReadCsvTable(std::string_view text) {
  LogTable table;
  std::vector<std::vector<double>*> columns;
  while (!text.empty()) {
    const std::size_t end = std::min(text.find('\n'), text.size());
    std::string_view line = text.substr(0, end);
    text.remove_prefix(std::min(end + 1, text.size()));
    if (line.ends_with('\r')) line.remove_suffix(1);
    const bool names = columns.empty();
    std::size_t index = 0;
    for (std::size_t begin = 0; begin <= line.size(); ++index) {
      const std::size_t comma = std::min(line.find(',', begin), line.size());
      const std::string_view cell = line.substr(begin, comma - begin);
      begin = comma + 1;
      if (names) {
        columns.push_back(&table[std::string(cell)]);
      } else if (index < columns.size()) {
        double value = std::numeric_limits<double>::quiet_NaN();
        const auto [stop, error] = std::from_chars(cell.data(), cell.data() + cell.size(), value);
        if (error != std::errc() || stop != cell.data() + cell.size())
          value = std::numeric_limits<double>::quiet_NaN();
        columns[index]->push_back(value);
      }
    }
    for (; !names && index < columns.size(); ++index)
      columns[index]->push_back(std::numeric_limits<double>::quiet_NaN());
  }
  return table;
}

}  // namespace kestrel::records
