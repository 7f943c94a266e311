// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "control/wire/afcs.h"

namespace kestrel::control::wire {

// Other than the thesis's in all that a profile can say: byte orders, width of the time, order and types of
// fields.
inline AfcsProfile OtherAfcsProfile() {
  AfcsProfile profile = ThesisAfcsProfile();
  profile.name = "other";
  profile.header_byte_order = "little";
  profile.time_bytes = 8;
  const std::vector<std::string> types = {"f32", "i32", "u32", "f64", "u16", "i16"};
  std::size_t next = 0;
  for (AfcsLayout& message : profile.messages) {
    message.byte_order = message.byte_order == "big" ? "little" : "big";
    std::reverse(message.fields.begin(), message.fields.end());
    for (AfcsField& field : message.fields) field.type = types[next++ % types.size()];
  }
  return profile;
}

}  // namespace kestrel::control::wire
