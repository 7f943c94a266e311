// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <stdexcept>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

// How ROS 2 writes a message: plain CDR of version 1 (OMG DDSI-RTPS 2.3, 10.2, and CORBA 3.3, 9.3),
// little-endian. Behind 4 bytes that say so, each number stands at a multiple of its size, counted from
// behind them; a text is its length with the null that ends it, in 4 bytes, and its bytes; a sequence is its
// length in 4 bytes, and its elements.
//
// A message is a struct with Members(visitor, message), which names its members in order; one serves both
// ways.
namespace kestrel::ros {

static_assert(std::endian::native == std::endian::little, "numbers are copied as they are");

inline constexpr std::string_view kCdrHead("\x00\x01\x00\x00", 4);

template <class T>
inline constexpr bool kIsNumber = std::is_arithmetic_v<T>;

class CdrWriter {
 public:
  template <class... Each>
  void operator()(const Each&... each) {
    (Put(each), ...);
  }
  std::string Take() { return std::move(bytes_); }

 private:
  template <class T>
  void Put(const T& value) {
    if constexpr (kIsNumber<T>) {
      Align(sizeof(T));
      Raw(&value, sizeof(T));
    } else {
      Members(*this, const_cast<T&>(value));  // changes nothing
    }
  }
  void Put(const std::string& text) {
    Put(static_cast<std::uint32_t>(text.size() + 1));
    Raw(text.c_str(), text.size() + 1);
  }
  template <class T>
  void Put(const std::vector<T>& all) {
    Put(static_cast<std::uint32_t>(all.size()));
    Elements(all.data(), all.size());
  }
  template <class T, std::size_t size>
  void Put(const std::array<T, size>& all) {
    Elements(all.data(), size);
  }
  template <class T>
  void Elements(const T* first, std::size_t count) {
    if constexpr (kIsNumber<T>) {
      if (count == 0) return;
      Align(sizeof(T));
      Raw(first, count * sizeof(T));
    } else {
      for (std::size_t i = 0; i < count; ++i) Put(first[i]);
    }
  }
  void Align(std::size_t to) { bytes_.append((to - (bytes_.size() - kCdrHead.size()) % to) % to, '\0'); }
  void Raw(const void* from, std::size_t size) { bytes_.append(static_cast<const char*>(from), size); }

  std::string bytes_{kCdrHead};
};

// What is no message of this type: cut, of another byte order, or of lengths that are not there.
struct CdrError : std::runtime_error {
  using std::runtime_error::runtime_error;
};

class CdrReader {
 public:
  explicit CdrReader(std::string_view bytes) : left_(bytes), size_(bytes.size()) {
    if (Take(kCdrHead.size()).substr(0, 2) != kCdrHead.substr(0, 2))
      throw CdrError("is no plain CDR in little-endian order");
    size_ -= kCdrHead.size();
  }
  template <class... Each>
  void operator()(Each&... each) {
    (Get(each), ...);
  }

 private:
  template <class T>
  void Get(T& value) {
    if constexpr (std::is_same_v<T, bool>) {
      value = Take(1)[0] != 0;
    } else if constexpr (kIsNumber<T>) {
      Align(sizeof(T));
      std::memcpy(&value, Take(sizeof(T)).data(), sizeof(T));
    } else {
      Members(*this, value);
    }
  }
  void Get(std::string& text) {
    const std::string_view bytes = Take(Length());
    text = bytes.substr(0, bytes.empty() ? 0 : bytes.size() - 1);
  }
  template <class T>
  void Get(std::vector<T>& all) {
    const std::uint32_t count = Length();
    if constexpr (kIsNumber<T>) {
      all.clear();
      if (count == 0) return;
      Align(sizeof(T));
      const std::string_view bytes = Take(std::uint64_t{count} * sizeof(T));
      all.resize(count);
      std::memcpy(all.data(), bytes.data(), bytes.size());
    } else {
      all.clear();
      for (std::uint32_t i = 0; i < count; ++i) Get(all.emplace_back());  // none before its bytes are there
    }
  }
  template <class T, std::size_t size>
  void Get(std::array<T, size>& all) {
    for (T& each : all) Get(each);
  }
  std::uint32_t Length() {
    std::uint32_t length = 0;
    Get(length);
    return length;
  }
  void Align(std::size_t to) { Take((to - (size_ - left_.size()) % to) % to); }
  std::string_view Take(std::uint64_t count) {
    if (count > left_.size()) Fail(count);
    const std::string_view bytes = left_.substr(0, count);
    left_.remove_prefix(count);
    return bytes;
  }
  [[noreturn]] void Fail(std::uint64_t count) const;

  std::string_view left_;
  std::size_t size_;
};

template <class Message>
std::string ToCdr(const Message& message) {
  CdrWriter writer;
  writer(message);
  return writer.Take();
}

// Throws CdrError.
template <class Message>
Message FromCdr(std::string_view bytes) {
  Message message;
  CdrReader reader(bytes);
  reader(message);
  return message;
}

}  // namespace kestrel::ros
