// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <optional>
#include <string_view>

// The time stamps of recordings, whole nanoseconds of the recording's own clock, from the texts that recorders
// write. A double holds the time of day to some 200 ns only, and so none is made of them on the way.
namespace kestrel::vision {

// "1403636579763555584", as EuRoC writes it.
std::optional<std::int64_t> StampOfNanoseconds(std::string_view text);

// "1305031102.175304" as TUM writes it: to the bit, digits beyond the nanosecond are rounded; and with an
// exponent, as KITTI writes it ("1.036224e-01").
std::optional<std::int64_t> StampOfSeconds(std::string_view text);

// The stamp in a file's name without its ending: 19 digits are nanoseconds, as of this century, and digits
// with at least three after a point are seconds. None: it is a number of an image, or another name.
std::optional<std::int64_t> StampOfName(std::string_view stem);

}  // namespace kestrel::vision
