// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <mutex>
#include <utility>
#include <vector>

namespace kestrel {

// What the flights of a process have in common and none changes, as it takes long to make: the values that were asked
// for last, a few of them. For several threads: who asks for a value while another makes one waits for it.
template <class Key, class Value>
class Recent {
 public:
  explicit Recent(std::size_t most) : most_(most) {}

  // The value of this key; make() makes it where it is not kept. Of the others the one that was asked for least
  // recently goes first, so that there are never more than so many here. Whoever holds one keeps it.
  template <class Make>
  std::shared_ptr<const Value> Of(const Key& key, const Make& make) {
    const std::lock_guard lock(mutex_);
    const auto found =
        std::find_if(kept_.begin(), kept_.end(), [&](const auto& each) { return each.first == key; });
    if (found != kept_.end()) {
      std::rotate(kept_.begin(), found, found + 1);
      return kept_.front().second;
    }
    if (kept_.size() >= most_) kept_.pop_back();
    auto value = std::make_shared<const Value>(make());
    kept_.emplace(kept_.begin(), key, value);
    return value;
  }

 private:
  const std::size_t most_;
  std::mutex mutex_;
  std::vector<std::pair<Key, std::shared_ptr<const Value>>> kept_;  // the one asked for last is the first
};

}  // namespace kestrel
