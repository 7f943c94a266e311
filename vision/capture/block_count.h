// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>

namespace kestrel::vision {

// Counts a camera's exposures by the block ids of its stream: GigE Vision's run from 1 to 65535 and begin
// again at 1, unless the camera has the extended ones, of 64 bits, as USB3 Vision's are. An id above 65535
// tells them apart. An id that is a little behind the newest is a late block, and counts backward.
class BlockCount {
 public:
  std::int64_t Of(std::uint64_t id) {
    if (id > kLast) wide_ = true;
    if (!id_) {
      count_ = static_cast<std::int64_t>(id);
    } else {
      std::int64_t step = static_cast<std::int64_t>(id) - static_cast<std::int64_t>(*id_);
      if (!wide_ && step < -kLast / 2) step += kLast;
      if (!wide_ && step > kLast / 2) step -= kLast;
      count_ += step;
    }
    id_ = id;
    return count_;
  }

 private:
  static constexpr std::int64_t kLast = 65535;
  std::optional<std::uint64_t> id_;  // of the last block
  std::int64_t count_ = 0;
  bool wide_ = false;
};

}  // namespace kestrel::vision
