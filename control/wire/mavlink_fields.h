// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <concepts>
#include <type_traits>

namespace kestrel::control::wire::mavlink {

// M itself, or M that is only read.
template <class T, class M>
concept Either = std::same_as<std::remove_const_t<T>, M>;

}  // namespace kestrel::control::wire::mavlink
