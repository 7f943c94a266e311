// SPDX-License-Identifier: Apache-2.0
#include "base/recent/recent.h"

#include <gtest/gtest.h>

#include <atomic>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

namespace kestrel {
namespace {

TEST(Recent, AValueIsMadeOnce) {
  Recent<std::string, int> recent(2);
  int made = 0;
  const auto make = [&] { return ++made; };
  const auto first = recent.Of("a", make);
  EXPECT_NE(recent.Of("b", make), first);
  EXPECT_EQ(recent.Of("a", make), first);
  EXPECT_EQ(made, 2);
}

TEST(Recent, TheOneAskedForLeastRecentlyGoesBeforeAnotherIsMade) {
  Recent<int, int> recent(2);
  const auto same = [](int value) { return [value] { return value; }; };
  const std::weak_ptr<const int> one = recent.Of(1, same(1)), two = recent.Of(2, same(2));
  recent.Of(1, same(1));
  recent.Of(3, [&] {
    EXPECT_TRUE(two.expired());
    return 3;
  });
  EXPECT_FALSE(one.expired());
}

TEST(Recent, WhoHoldsAValueKeepsIt) {
  Recent<int, std::string> recent(1);
  const auto held = recent.Of(1, [] { return "one"; });
  recent.Of(2, [] { return "two"; });
  EXPECT_EQ(*held, "one");
}

TEST(Recent, WhatCouldNotBeMadeIsTriedAgain) {
  Recent<int, int> recent(1);
  EXPECT_THROW(recent.Of(1, []() -> int { throw std::runtime_error("no"); }), std::runtime_error);
  EXPECT_EQ(*recent.Of(1, [] { return 5; }), 5);
}

TEST(Recent, ThreadsThatAskAtOnceShareOne) {
  Recent<int, int> recent(1);
  std::atomic<int> made = 0;
  std::vector<std::shared_ptr<const int>> got(8);
  {
    std::vector<std::jthread> threads;
    for (auto& each : got) threads.emplace_back([&] { each = recent.Of(7, [&] { return ++made; }); });
  }
  EXPECT_EQ(made, 1);
  for (const auto& each : got) EXPECT_EQ(each, got[0]);
}

}  // namespace
}  // namespace kestrel
