// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace kestrel::flight {

// Bytes of pictures one behind the other: each without gaps between its rows, and begun at a multiple of
// kPictureAlignment.
inline constexpr std::size_t kPictureAlignment = 64;
std::size_t PictureBytes(const std::vector<cv::Mat>& pictures);
void CopyPictures(const std::vector<cv::Mat>& pictures, unsigned char* to);

// POSIX shared memory for the pictures of one client, which this user's programs may read and none may write.
// Its name goes with it.
class ImageMemory {
 public:
  ImageMemory() = default;
  ~ImageMemory();
  ImageMemory(const ImageMemory&) = delete;
  ImageMemory& operator=(const ImageMemory&) = delete;

  // Puts them in place of those before; where there is no room, in a new memory of another name. Throws
  // std::runtime_error with the reason.
  void Store(const std::vector<cv::Mat>& pictures);

  const std::string& name() const { return name_; }  // "/kestrel-1234-1"; empty: there is none yet
  std::size_t size() const { return size_; }         // bytes

 private:
  void Make(std::size_t size);
  void Remove();

  std::string name_;
  std::size_t size_ = 0;
  unsigned char* bytes_ = nullptr;
};

}  // namespace kestrel::flight
