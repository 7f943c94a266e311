// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <fmt/format.h>

#include <cstdio>
#include <utility>

namespace kestrel {

// Says something beside the results, on the standard error: progress, a remark, why the program ends. That
// nobody can read it (the terminal has gone) is no reason to break anything off, and so no exception, as
// fmt::print has it.
template <class... T>
void PrintNote(fmt::format_string<T...> format, T&&... values) {
  std::fputs(fmt::format(format, std::forward<T>(values)...).c_str(), stderr);
}

}  // namespace kestrel
