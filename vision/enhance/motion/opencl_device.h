// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <functional>
#include <optional>
#include <string>

namespace kestrel::vision {

// The device of OpenCL that this program uses where it is asked to: the one that OpenCV chooses, of which
// OPENCV_OPENCL_DEVICE decides, else any that has images of floats, a graphics card before a processor (as pocl makes
// it one). It is looked for when it is first asked for, which takes tenths of a second.

// Its name and version, one line without commas. None: there is none.
std::optional<std::string> OpenClDevice();

// Does something with OpenCV's UMats on it, in this thread alone; elsewhere OpenCV stays on the processor. Whether it
// was done: not without a device, nor once the device has failed.
bool DoByOpenCl(const std::function<void()>& work);

enum class OpenClState {
  kUnused,  // nobody has asked for it
  kAbsent,  // there is no device
  kUsed,    // what was asked of it was done there
  kFailed,  // it has failed, and the processor goes on
};
const char* NameOf(OpenClState state);  // "unused", "absent", "used", "failed"
OpenClState OpenClStateNow();

}  // namespace kestrel::vision
