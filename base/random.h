// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <cstddef>
#include <cstdint>
#include <random>
#include <string_view>

namespace kestrel {

// All randomness of a run comes from its one seed, through named streams ("wind", "gps", ...): a new consumer
// takes a new name and shifts nobody else's numbers.
class RandomStream {
 public:
  RandomStream(std::uint64_t seed, std::string_view name) : engine_(Mix(seed ^ Mix(HashOf(name)))) {}

  double Normal() { return normal_(engine_); }  // mean 0, deviation 1
  double Uniform(double low, double high) { return low + (high - low) * unit_(engine_); }  // [low, high)
  std::uint64_t Bits() { return engine_(); }

  // A well-mixed 64-bit value of its argument (the finaliser of splitmix64).
  static constexpr std::uint64_t Mix(std::uint64_t z) {
    z += 0x9e3779b97f4a7c15;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
    z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
    return z ^ (z >> 31);
  }

 private:
  static constexpr std::uint64_t HashOf(std::string_view name) {  // FNV-1a
    std::uint64_t h = 0xcbf29ce484222325;
    for (const char c : name) h = (h ^ static_cast<unsigned char>(c)) * 0x100000001b3;
    return h;
  }

  std::mt19937_64 engine_;
  std::normal_distribution<double> normal_;
  std::uniform_real_distribution<double> unit_;
};

// Which of n things the next sample of a consensus takes: the same sequence each time, on every machine, since an
// estimate may depend on nothing but what it is made from. (A linear congruential generator: Knuth's MMIX.)
class SampleSequence {
 public:
  std::size_t Next(std::size_t n) {
    state_ = state_ * 6364136223846793005u + 1442695040888963407u;
    return static_cast<std::size_t>((state_ >> 33) % n);
  }

 private:
  std::uint64_t state_ = 0x9E3779B97F4A7C15u;
};

}  // namespace kestrel
