// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <atomic>

#include "flight/stepped/sim.h"

namespace kestrel::python {

// Lets one thread at a time use a thing that works without Python's lock.
class OneThread {
 public:
  explicit OneThread(const char* what) : what_(what) {}

  class Use {
   public:
    explicit Use(const OneThread& of) : of_(of) {
      if (of.used_.exchange(true))
        throw SimError(fmt::format("two threads use this {} at a time; let each make its own", of.what_));
    }
    ~Use() { of_.used_ = false; }
    Use(const Use&) = delete;
    Use& operator=(const Use&) = delete;

   private:
    const OneThread& of_;
  };

 private:
  const char* what_;
  mutable std::atomic<bool> used_ = false;
};

}  // namespace kestrel::python
