// SPDX-License-Identifier: Apache-2.0
#include "bench/limits/machine_rates.h"

#include <algorithm>
#include <chrono>
#include <cstdint>

#include "sim/render/ray/instruction_targets.h"  // before Highway
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "bench/limits/machine_rates.cc"
#include <hwy/foreach_target.h>
// After foreach_target.
#include <hwy/aligned_allocator.h>
#include <hwy/highway.h>

#include "sim/render/ray/instruction_set.h"

HWY_BEFORE_NAMESPACE();
namespace kestrel::bench::HWY_NAMESPACE {
namespace {

namespace hn = hwy::HWY_NAMESPACE;
using Floats = hn::ScalableTag<float>;

// Operations that do not wait for one another: so many at once keep two units busy for five cycles each.
constexpr int kChains = 12;
constexpr int kTurns = 100'000;

// Returns something of the result, so that no compiler leaves the work out.
template <class Step>
float Chains(const Step& step) {
  const Floats d;
  auto v0 = hn::Set(d, 1.0f), v1 = hn::Set(d, 1.1f), v2 = hn::Set(d, 1.2f), v3 = hn::Set(d, 1.3f);
  auto v4 = hn::Set(d, 1.4f), v5 = hn::Set(d, 1.5f), v6 = hn::Set(d, 1.6f), v7 = hn::Set(d, 1.7f);
  auto v8 = hn::Set(d, 1.8f), v9 = hn::Set(d, 1.9f), va = hn::Set(d, 2.0f), vb = hn::Set(d, 2.1f);
  for (int i = 0; i < kTurns; ++i) {
    v0 = step(v0), v1 = step(v1), v2 = step(v2), v3 = step(v3), v4 = step(v4), v5 = step(v5);
    v6 = step(v6), v7 = step(v7), v8 = step(v8), v9 = step(v9), va = step(va), vb = step(vb);
  }
  const auto sum =
      hn::Add(hn::Add(hn::Add(v0, v1), hn::Add(v2, v3)),
              hn::Add(hn::Add(hn::Add(v4, v5), hn::Add(v6, v7)), hn::Add(hn::Add(v8, v9), hn::Add(va, vb))));
  return hn::GetLane(sum);
}

// The work done: results of one operation.
double MultiplyAdds(volatile float& kept) {
  const Floats d;
  const auto a = hn::Set(d, 0.999f), b = hn::Set(d, 0.001f);
  kept = Chains([&](auto v) { return hn::MulAdd(v, a, b); });
  return static_cast<double>(kTurns) * kChains * static_cast<double>(hn::Lanes(d));
}

double Divisions(volatile float& kept) {
  const Floats d;
  const auto a = hn::Set(d, 1.5f);
  kept = Chains([&](auto v) { return hn::Div(a, v); });
  return static_cast<double>(kTurns) * kChains * static_cast<double>(hn::Lanes(d));
}

// Once over all of it.
void ReadInOrder(const std::uint64_t* from, std::size_t count, volatile float& kept) {
  const hn::ScalableTag<std::uint64_t> d;
  const std::size_t lanes = hn::Lanes(d);
  auto a = hn::Zero(d), b = hn::Zero(d), c = hn::Zero(d), e = hn::Zero(d);
  for (std::size_t i = 0; i < count; i += 4 * lanes) {
    a = hn::Add(a, hn::Load(d, from + i));
    b = hn::Add(b, hn::Load(d, from + i + lanes));
    c = hn::Add(c, hn::Load(d, from + i + 2 * lanes));
    e = hn::Add(e, hn::Load(d, from + i + 3 * lanes));
  }
  kept = static_cast<float>(hn::GetLane(hn::Add(hn::Add(a, b), hn::Add(c, e))));
}

}  // namespace
}  // namespace kestrel::bench::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace kestrel::bench {
namespace {

HWY_EXPORT(MultiplyAdds);
HWY_EXPORT(Divisions);
HWY_EXPORT(ReadInOrder);

volatile float kept = 0;
constexpr int kTries = 7;

// The least of several tries, s.
template <class Work>
double Fastest_s(const Work& work) {
  double least_s = 1e9;
  for (int i = 0; i < kTries; ++i) {
    const auto start = std::chrono::steady_clock::now();
    work();
    least_s =
        std::min(least_s, std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  }
  return least_s;
}

MemoryRate RateOf(const char* level, std::size_t bytes) {
  const std::size_t count = bytes / sizeof(std::uint64_t);  // a power of two
  const auto buffer = hwy::AllocateAligned<std::uint64_t>(count);
  std::fill_n(buffer.get(), count, 1);
  MemoryRate rate{level, bytes, 0, 0};
  const auto passes = std::max<std::size_t>(1, (std::size_t{64} << 20) / bytes);
  rate.read_gb_s = 1e-9 * static_cast<double>(bytes * passes) / Fastest_s([&] {
                     for (std::size_t k = 0; k < passes; ++k)
                       HWY_DYNAMIC_DISPATCH(ReadInOrder)(buffer.get(), count, kept);
                   });
  constexpr std::size_t kPlaces = 1 << 20;
  rate.random_reads_per_us = 1e-6 * kPlaces / Fastest_s([&] {
                               std::uint64_t at = 1, sum = 0;
                               for (std::size_t i = 0; i < kPlaces; ++i) {
                                 at = at * 6364136223846793005u + 1442695040888963407u;
                                 sum += buffer[(at >> 20) & (count - 1)];
                               }
                               kept = static_cast<float>(sum);
                             });
  return rate;
}

}  // namespace

MachineRates MeasureMachineRates() {
  MachineRates rates;
  rates.instruction_set = sim::InstructionSet();
  double done = 0;
  const double adds_s = Fastest_s([&] { done = HWY_DYNAMIC_DISPATCH(MultiplyAdds)(kept); });
  rates.multiply_adds_gflop_s = 2e-9 * done / adds_s;
  const double divisions_s = Fastest_s([&] { done = HWY_DYNAMIC_DISPATCH(Divisions)(kept); });
  rates.divisions_per_ns = 1e-9 * done / divisions_s;
  constexpr std::size_t kKib = 1024;
  for (const auto& [level, bytes] : {std::pair{"16 KiB", 16 * kKib},
                                     {"512 KiB", 512 * kKib},
                                     {"8 MiB", 8 * kKib * kKib},
                                     {"256 MiB", 256 * kKib * kKib}})
    rates.memory.push_back(RateOf(level, bytes));
  return rates;
}

const MemoryRate& RateFor(const MachineRates& rates, double bytes) {
  for (const MemoryRate& rate : rates.memory)
    if (static_cast<double>(rate.bytes) >= bytes) return rate;
  return rates.memory.back();
}

}  // namespace kestrel::bench
#endif
