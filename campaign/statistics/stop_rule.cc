// SPDX-License-Identifier: Apache-2.0
#include "campaign/statistics/stop_rule.h"

#include <fmt/format.h>

#include <string_view>

#include "campaign/statistics/effects.h"

namespace kestrel::campaign {
namespace {

constexpr std::string_view kRule = "--stop-when ";

}  // namespace

std::string StopRule(double half_width) { return fmt::format("{}{}", kRule, half_width); }

std::optional<double> StopRuleOf(const CampaignIdentity& identity) {
  // WorkOf writes it below all else, as a comment.
  std::string_view text = identity.plan;
  while (text.ends_with('\n')) text.remove_suffix(1);
  text.remove_prefix(text.rfind('\n') == text.npos ? 0 : text.rfind('\n') + 1);
  const std::string start = fmt::format("# {}", kRule);
  if (!text.starts_with(start)) return std::nullopt;
  return NumberIn(std::string(text.substr(start.size())));
}

}  // namespace kestrel::campaign
