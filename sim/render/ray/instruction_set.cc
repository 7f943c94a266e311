// SPDX-License-Identifier: Apache-2.0
#include "sim/render/ray/instruction_set.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <hwy/targets.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <iterator>
#include <opencv2/core/utility.hpp>
#include <sstream>

#include "base/diagnostics.h"
#include "sim/render/ray/kernel.h"

namespace kestrel::sim {
namespace {

struct Named {
  std::string_view name;
  std::int64_t target;  // Highway's
};

#if HWY_ARCH_X86
constexpr std::array kSets = {Named{"ssse3", HWY_SSSE3}, Named{"avx2", HWY_AVX2}, Named{"avx512", HWY_AVX3}};
constexpr std::array kNames = {kSets[0].name, kSets[1].name, kSets[2].name};
#else
constexpr std::array<Named, 0> kSets = {};
constexpr std::array<std::string_view, 0> kNames = {};
#endif

std::vector<std::string> Parts(const std::string& text, char between) {
  std::vector<std::string> parts;
  std::istringstream in(text);
  for (std::string part; std::getline(in, part, between);)
    if (!part.empty()) parts.push_back(part);
  return parts;
}

std::string Variable(const char* name) {
  const char* value = std::getenv(name);
  return value ? value : "";
}

// Of the features that OpenCV has code for beyond its baseline, those that a set is without: a star is before
// such a feature, and a question mark after one that is not there. One that was taken away is still to be.
std::string DisabledInOpenCv(std::string_view set) {
  constexpr const char* kVariable = "OPENCV_CPU_DISABLE";
  const std::vector<std::string> gone = Parts(Variable(kVariable), ',');
  std::vector<std::string> disabled;
  for (std::string feature : Parts(cv::getCPUFeaturesLine(), ' ')) {
    if (feature.front() != '*') continue;
    feature.erase(0, 1);
    const bool there = feature.back() != '?';
    if (!there) feature.pop_back();
    const bool beyond = set == "ssse3" || (set == "avx2" && feature.starts_with("AVX512"));
    if (beyond && (there || std::find(gone.begin(), gone.end(), feature) != gone.end()))
      disabled.push_back(feature);
  }
  return fmt::format("{}", fmt::join(disabled, ","));
}

// The C library's mathematics goes by FMA, FMA4 or neither. Its other tunables stay.
std::string Tunables(std::string_view set) {
  constexpr std::string_view kFeatures = "glibc.cpu.hwcaps=";
  std::vector<std::string> all = Parts(Variable("GLIBC_TUNABLES"), ':');
  std::erase_if(all, [&](const std::string& each) { return each.starts_with(kFeatures); });
  if (set == "ssse3") all.push_back(fmt::format("{}-AVX2,-FMA,-FMA4", kFeatures));
  return fmt::format("{}", fmt::join(all, ":"));
}

}  // namespace

std::span<const std::string_view> InstructionSets() { return kNames; }

std::string InstructionSet() {
  const std::string target = ray::InstructionSet();
  for (const Named& each : kSets)
    if (target == hwy::TargetName(each.target)) return std::string(each.name);
  return target;
}

void UseInstructionSet(const std::string& name, const char* chosen_by) {
  hwy::DisableTargets(0);
  const std::int64_t supported = hwy::SupportedTargets();
  std::vector<std::string_view> here;
  for (const Named& each : kSets)
    if (supported & each.target) here.push_back(each.name);
  const auto wanted =
      std::find_if(kSets.begin(), kSets.end(), [&](const Named& s) { return s.name == name; });
  if (std::find(here.begin(), here.end(), name) == here.end())
    throw InputError(
        chosen_by,
        fmt::format("{}", wanted == kSets.end()
                              ? fmt::format("'{}' is no instruction set that can be chosen", name)
                              : fmt::format("this machine has no {}", name)),
        fmt::format("valid: {}", here.empty() ? "none, on this processor"
                                              : fmt::format("{} here", fmt::join(here, ", "))));
  // The better, the lower its bit.
  hwy::DisableTargets(wanted->target - 1);
}

std::vector<std::pair<std::string, std::string>> EnvironmentOf(const std::string& set) {
  return {{"GLIBC_TUNABLES", Tunables(set)}, {"OPENCV_CPU_DISABLE", DisabledInOpenCv(set)}};
}

}  // namespace kestrel::sim
