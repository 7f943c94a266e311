// SPDX-License-Identifier: Apache-2.0
#include "vision/enhance/motion/opencl_device.h"

#include <algorithm>
#include <atomic>
#include <opencv2/core/ocl.hpp>
#include <vector>

namespace kestrel::vision {
namespace {

std::atomic<OpenClState> state = OpenClState::kUnused;

bool Serves(const cv::ocl::Device& device) {
  return device.ptr() && device.available() && device.compilerAvailable() && device.imageSupport();
}

std::optional<cv::ocl::Device> Chosen() {
  if (!cv::ocl::haveOpenCL()) return std::nullopt;
  if (const cv::ocl::Device& chosen = cv::ocl::Device::getDefault(); Serves(chosen)) return chosen;
  std::vector<cv::ocl::PlatformInfo> platforms;
  cv::ocl::getPlatfomsInfo(platforms);
  std::optional<cv::ocl::Device> other;
  for (const cv::ocl::PlatformInfo& platform : platforms) {
    for (int i = 0; i < platform.deviceNumber(); ++i) {
      cv::ocl::Device device;
      platform.getDevice(device, i);
      if (!Serves(device)) continue;
      if (device.type() & cv::ocl::Device::TYPE_GPU) return device;
      if (!other) other = device;
    }
  }
  return other;
}

struct Opened {
  cv::ocl::Device device;
  cv::ocl::Context context;
  std::string name;
};

// None: there is no device.
const std::optional<Opened>& Device() {
  static const std::optional<Opened> opened = []() -> std::optional<Opened> {
    try {
      const auto device = Chosen();
      if (!device) return std::nullopt;
      Opened found{*device, cv::ocl::Context::fromDevice(*device), device->name() + " " + device->version()};
      std::replace(found.name.begin(), found.name.end(), ',', ' ');
      return found;
    } catch (const cv::Exception&) {  // its driver is broken
      return std::nullopt;
    }
  }();
  return opened;
}

// OpenCV's own scope leaves the device bound where nothing was before it.
class Scope {
 public:
  Scope() : before_(cv::ocl::OpenCLExecutionContext::getCurrentRef()), used_(cv::ocl::useOpenCL()) {
    thread_local const auto mine =
        cv::ocl::OpenCLExecutionContext::create(Device()->context, Device()->context.device(0));
    mine.bind();
    cv::ocl::setUseOpenCL(true);
  }
  ~Scope() {
    if (!before_.empty()) before_.bind();
    cv::ocl::setUseOpenCL(used_);
  }
  Scope(const Scope&) = delete;
  Scope& operator=(const Scope&) = delete;

 private:
  cv::ocl::OpenCLExecutionContext before_;
  bool used_;
};

}  // namespace

std::optional<std::string> OpenClDevice() { return Device() ? std::optional(Device()->name) : std::nullopt; }

bool DoByOpenCl(const std::function<void()>& work) {
  if (state == OpenClState::kFailed) return false;
  if (!Device()) {
    state = OpenClState::kAbsent;
    return false;
  }
  try {
    const Scope scope;
    if (!cv::ocl::Image2D::isFormatSupported(CV_32F, 1, false)) {
      state = OpenClState::kAbsent;
      return false;
    }
    work();
    state = OpenClState::kUsed;
    return true;
  } catch (const cv::Exception&) {
    state = OpenClState::kFailed;
    return false;
  }
}

const char* NameOf(OpenClState of) {
  switch (of) {
    case OpenClState::kUnused:
      return "unused";
    case OpenClState::kAbsent:
      return "absent";
    case OpenClState::kUsed:
      return "used";
    case OpenClState::kFailed:
      return "failed";
  }
  return "";
}

OpenClState OpenClStateNow() { return state; }

}  // namespace kestrel::vision
