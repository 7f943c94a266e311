// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>

namespace kestrel {

// What is under way, on the standard error: on a terminal a line that each text replaces and the end takes away;
// elsewhere, as in the log of a build, a line of its own every so often.
class StatusLine {
 public:
  explicit StatusLine(std::string title, double elsewhere_s = 30);
  ~StatusLine();
  StatusLine(const StatusLine&) = delete;
  StatusLine& operator=(const StatusLine&) = delete;

  void Show(const std::string& text);
  void Clear();  // before results are printed

 private:
  std::string title_;
  bool terminal_;
  double elsewhere_s_, next_s_;  // elsewhere; of the monotonic clock
};

}  // namespace kestrel
