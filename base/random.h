// SPDX-License-Identifier: Apache-2.0
#pragma once

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

}  // namespace kestrel
