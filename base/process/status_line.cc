// SPDX-License-Identifier: Apache-2.0
#include "base/process/status_line.h"

#include <unistd.h>

#include <utility>

#include "base/process/print_note.h"
#include "base/stopwatch.h"

namespace kestrel {

StatusLine::StatusLine(std::string title, double elsewhere_s)
    : title_(std::move(title)),
      terminal_(isatty(STDERR_FILENO)),
      elsewhere_s_(elsewhere_s),
      next_s_(MonotonicNow_s() + elsewhere_s) {}

StatusLine::~StatusLine() { Clear(); }

void StatusLine::Clear() {
  if (terminal_) PrintNote("\r\033[K");
}

void StatusLine::Show(const std::string& text) {
  if (terminal_) return PrintNote("\r\033[K{}: {}", title_, text);
  const double now_s = MonotonicNow_s();
  if (now_s < next_s_) return;
  next_s_ = now_s + elsewhere_s_;
  PrintNote("{}: {}\n", title_, text);
}

}  // namespace kestrel
