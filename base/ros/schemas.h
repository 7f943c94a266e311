// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>

namespace kestrel::ros {

// The definition of a message as a log of the encoding "ros2msg" has it: that of the type, then behind a line
// of '=' and one "MSG: package/Type" each that it is made of. Throws std::logic_error of a type that is not
// known.
std::string SchemaOf(std::string_view type);  // "sensor_msgs/msg/Image"

}  // namespace kestrel::ros
