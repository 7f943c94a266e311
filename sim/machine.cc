// SPDX-License-Identifier: Apache-2.0
#include "sim/machine.h"

#include <dlfcn.h>
#include <fmt/format.h>
#include <hwy/highway.h>
#include <mujoco/mujoco.h>
#include <xxhash.h>

#include <Eigen/Core>
#include <array>
#include <bit>
#include <cstdint>
#include <cstring>
#include <filesystem>
#include <opencv2/core/utility.hpp>
#include <sstream>
#include <utility>

#include "sim/render/ray/instruction_set.h"
#include "sim/render/ray/mesh/triangle_tree.h"

#ifdef __GLIBC__
#include <gnu/libc-version.h>
#endif
#if defined(__x86_64__) && __has_include(<sys/platform/x86.h>)
#include <sys/platform/x86.h>
#define KESTREL_KNOWS_GLIBCS_CHOICE 1
#endif
#ifdef __x86_64__
#include <immintrin.h>
#endif

namespace kestrel::sim {
namespace {

#ifdef __x86_64__
// The approximations to x of 1/x and 1/sqrt(x), as bits.
std::array<float, 2> Approximations(float x) {
  const __m128 v = _mm_set_ss(x);
  return {_mm_cvtss_f32(_mm_rcp_ss(v)), _mm_cvtss_f32(_mm_rsqrt_ss(v))};
}
// Those of AVX-512, which are others.
__attribute__((target("avx512f"))) std::array<float, 2> WideApproximations(float x) {
  const __m128 v = _mm_set_ss(x);
  return {_mm_cvtss_f32(_mm_rcp14_ss(v, v)), _mm_cvtss_f32(_mm_rsqrt14_ss(v, v))};
}

std::string Reciprocals(bool wide) {
  constexpr int kSteps = 4096;  // of the mantissa, in two octaves
  std::array<std::array<float, 2>, 2 * kSteps> all;
  for (int i = 0; i < 2 * kSteps; ++i) {
    const float x = std::bit_cast<float>(0x3f800000u + static_cast<std::uint32_t>(i) * (1u << 23) / kSteps);
    all[static_cast<std::size_t>(i)] = wide ? WideApproximations(x) : Approximations(x);
  }
  return fmt::format("{:08x}", XXH32(all.data(), sizeof all, 0));
}
#else
std::string Reciprocals(bool) { return "none"; }
#endif

std::string CLibrary() {
#ifdef __GLIBC__
  return fmt::format("glibc {}", gnu_get_libc_version());
#else
  return "unknown";
#endif
}

// As glibc chooses among its variants, by what its tunables have left of the processor.
std::string Mathematics() {
#ifdef KESTREL_KNOWS_GLIBCS_CHOICE
  if (CPU_FEATURE_ACTIVE(FMA) && CPU_FEATURE_ACTIVE(AVX2)) return "fma";
  return CPU_FEATURE_ACTIVE(FMA4) ? "fma4" : "sse2";
#else
  return "unknown";
#endif
}

// A star is before a feature that OpenCV has code for, and a question mark after one that it does without.
std::string OpenCv() {
  std::string text = cv::getVersionString();
  std::istringstream features(cv::getCPUFeaturesLine());
  for (std::string each; features >> each;)
    if (each.front() == '*' && each.back() != '?') text += fmt::format(" {}", each.substr(1));
  return text;
}

// By its file, which is one of several.
std::string Lapack() {
  void* const solve = dlsym(RTLD_DEFAULT, "dgesv_");
  Dl_info info;
  if (!solve || dladdr(solve, &info) == 0) return "none";
  std::error_code error;
  const auto file = std::filesystem::canonical(info.dli_fname, error);
  std::string text = (error ? std::filesystem::path(info.dli_fname) : file).filename().string();
  using Name = const char* (*)();
  if (const auto core = reinterpret_cast<Name>(dlsym(RTLD_DEFAULT, "openblas_get_corename")))
    text += fmt::format(" {}", core());
  return text;
}

std::string Build() {
  return fmt::format("compiler {}, Eigen {}.{}.{}, Highway {}.{}.{}", __VERSION__, EIGEN_WORLD_VERSION,
                     EIGEN_MAJOR_VERSION, EIGEN_MINOR_VERSION, HWY_MAJOR, HWY_MINOR, HWY_PATCH);
}

}  // namespace

Machine ThisMachine() {
  static const Machine unchanging = {
      {"c_library", CLibrary()}, {"mathematics", Mathematics()},   {"opencv", OpenCv()},
      {"lapack", Lapack()},      {"embree", ray::EmbreeVersion()}, {"mujoco", mj_versionString()},
      {"build", Build()}};
  Machine machine = unchanging;
  const std::string set = InstructionSet();
  machine["instruction_set"] = set;
  machine["reciprocals"] = Reciprocals(set == "avx512");
  return machine;
}

std::map<std::string, std::pair<std::string, std::string>> MachineDifferences(const Machine& a,
                                                                              const Machine& b) {
  std::map<std::string, std::pair<std::string, std::string>> differences;
  for (const auto& [name, value] : a) differences[name] = {value, "unknown"};
  for (const auto& [name, value] : b)
    differences.try_emplace(name, "unknown", "").first->second.second = value;
  std::erase_if(differences, [](const auto& each) { return each.second.first == each.second.second; });
  return differences;
}

}  // namespace kestrel::sim
