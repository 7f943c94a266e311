// SPDX-License-Identifier: Apache-2.0
#pragma once

namespace kestrel {

// A visitor of a std::variant made of lambdas, one for each alternative: std::visit(Overloaded{...}, variant).
template <class... Each>
struct Overloaded : Each... {
  using Each::operator()...;
};
template <class... Each>
Overloaded(Each...) -> Overloaded<Each...>;

}  // namespace kestrel
