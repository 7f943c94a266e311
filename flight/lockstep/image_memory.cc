// SPDX-License-Identifier: Apache-2.0
#include "flight/lockstep/image_memory.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/mman.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstring>
#include <stdexcept>

namespace kestrel::flight {
namespace {

std::atomic<int> memories_made = 0;  // by this process, so that no two have one name

std::size_t RowBytes(const cv::Mat& picture) {
  return static_cast<std::size_t>(picture.cols) * picture.elemSize();
}
std::size_t BytesOf(const cv::Mat& picture) {
  const std::size_t bytes = static_cast<std::size_t>(picture.rows) * RowBytes(picture);
  return (bytes + kPictureAlignment - 1) / kPictureAlignment * kPictureAlignment;
}

}  // namespace

std::size_t PictureBytes(const std::vector<cv::Mat>& pictures) {
  std::size_t bytes = 0;
  for (const cv::Mat& picture : pictures) bytes += BytesOf(picture);
  return bytes;
}

void CopyPictures(const std::vector<cv::Mat>& pictures, unsigned char* to) {
  for (const cv::Mat& picture : pictures) {
    for (int row = 0; row < picture.rows; ++row)
      std::memcpy(to + static_cast<std::size_t>(row) * RowBytes(picture), picture.ptr(row),
                  RowBytes(picture));
    to += BytesOf(picture);
  }
}

ImageMemory::~ImageMemory() { Remove(); }

void ImageMemory::Store(const std::vector<cv::Mat>& pictures) {
  const std::size_t bytes = PictureBytes(pictures);
  if (bytes > size_) Make(bytes);
  if (bytes > 0) CopyPictures(pictures, bytes_);
}

void ImageMemory::Make(std::size_t size) {
  Remove();
  const std::string name = fmt::format("/kestrel-{}-{}", getpid(), ++memories_made);
  const auto fail = [&](int reason) {
    throw std::runtime_error(
        fmt::format("no shared memory of {} bytes for images: {}", size, std::strerror(reason)));
  };
  shm_unlink(name.c_str());  // of a process that had this one's number and was killed
  // For others it is there to be read: a client that cuts it would end this process by a signal.
  const int descriptor = shm_open(name.c_str(), O_CREAT | O_EXCL | O_RDWR, 0400);
  if (descriptor < 0) fail(errno);
  name_ = name;
  // All of it now: memory that is full would else end this process by a signal, later.
  int error = posix_fallocate(descriptor, 0, static_cast<off_t>(size));
  void* bytes = MAP_FAILED;
  if (error == 0) {
    bytes = mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_SHARED | MAP_POPULATE, descriptor, 0);
    if (bytes == MAP_FAILED) error = errno;
  }
  close(descriptor);
  if (error != 0) {
    Remove();
    fail(error);
  }
  bytes_ = static_cast<unsigned char*>(bytes);
  size_ = size;
}

void ImageMemory::Remove() {
  if (bytes_) munmap(bytes_, size_);
  if (!name_.empty()) shm_unlink(name_.c_str());
  name_.clear();
  bytes_ = nullptr;
  size_ = 0;
}

}  // namespace kestrel::flight
