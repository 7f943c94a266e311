// SPDX-License-Identifier: Apache-2.0
#include "sim/render/shared_loop.h"

#include <gtest/gtest.h>

#include <atomic>
#include <latch>
#include <thread>
#include <vector>

namespace kestrel::sim {
namespace {

TEST(SharedLoop, EachRoundIsDoneOnceHoweverManyTakePart) {
  for (const int threads : {1, 3}) {
    SharedLoop loop;
    std::atomic<bool> over = false;
    std::vector<std::jthread> helpers;
    for (int i = 0; i < 2; ++i) helpers.emplace_back([&] { loop.HelpUntil([&] { return over.load(); }); });
    for (int count : {0, 1, 7, 300}) {
      std::vector<std::atomic<int>> done(static_cast<std::size_t>(count));
      for (int again = 0; again < 20; ++again) {
        loop.Run(threads, count, [&](int i) { ++done[static_cast<std::size_t>(i)]; });
        // All of them have returned.
        for (const auto& times : done) ASSERT_EQ(times.load(), again + 1) << count;
      }
    }
    over = true;
    loop.Wake();
  }
}

// The two rounds wait for each other: one thread alone would never end.
TEST(SharedLoop, WhoWaitsForTheResultTakesPart) {
  SharedLoop loop;
  std::atomic<bool> over = false;
  std::latch both(2);
  std::jthread drawing([&] {
    loop.Run(1, 2, [&](int) { both.arrive_and_wait(); });
    over = true;
    loop.Wake();
  });
  loop.HelpUntil([&] { return over.load(); });
  EXPECT_TRUE(both.try_wait());
}

TEST(SharedLoop, WhatIsThereAlreadyIsNotWaitedFor) {
  SharedLoop loop;
  loop.HelpUntil([] { return true; });
}

}  // namespace
}  // namespace kestrel::sim
