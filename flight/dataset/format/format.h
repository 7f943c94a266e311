// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "base/diagnostics.h"
#include "flight/dataset/format/sequence.h"

namespace kestrel::flight {

// A file of a data set, by its path below the set's folder.
struct SetFile {
  std::string path, bytes;
};

// How a data set is laid out: conventions.h says in which frames. May be used by several threads.
class Format {
 public:
  virtual ~Format() = default;

  // What the format cannot say of these cameras.
  virtual void Check(const Sequence& sequence, Mistakes& mistakes) const = 0;
  // The pictures of one frame.
  virtual std::vector<SetFile> Pictures(const Sequence& sequence, const SetFrame& frame) const = 0;
  // All that is written once of a whole sequence: tables and calibration.
  virtual std::vector<SetFile> Tables(const Sequence& sequence) const = 0;
};

std::vector<std::string> FormatNames();
// A name of FormatNames().
std::unique_ptr<Format> MakeFormat(const std::string& name);

}  // namespace kestrel::flight
