// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

namespace kestrel::vision {

struct Grabbed {
  cv::Mat image;                      // CV_8UC1, or CV_8UC3 in the order blue, green, red; not shared
  std::optional<double> stamp_s;      // the driver's, best on the monotonic clock; none: it gives none
  std::optional<std::int64_t> count;  // the driver's own count of exposures
};

// A device or stream that images come from, of whatever library. Used by one thread at a time.
class ImageSource {
 public:
  virtual ~ImageSource() = default;
  virtual bool Open() = 0;                      // false: not there, or it does not give what is asked of it
  virtual std::optional<Grabbed> Grab() = 0;    // waits for the next image; none: the source has failed
  virtual bool Ended() const { return false; }  // there is no more, and opening again brings none: a file
  virtual std::string Error() const { return {}; }  // why it could not be opened or failed; empty: not known
};

using ImageSourceMaker = std::function<std::unique_ptr<ImageSource>()>;

}  // namespace kestrel::vision
