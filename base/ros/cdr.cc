// SPDX-License-Identifier: Apache-2.0
#include "base/ros/cdr.h"

#include <fmt/format.h>

namespace kestrel::ros {

void CdrReader::Fail(std::uint64_t count) const {
  throw CdrError(fmt::format("ends too early: {} bytes are to come where {} are left", count, left_.size()));
}

}  // namespace kestrel::ros
