// SPDX-License-Identifier: Apache-2.0
#include "app/run/view_option.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <charconv>
#include <string_view>

namespace kestrel::app {

std::optional<cv::Size> ReadViewSize(const char* option, const std::string& text, Mistakes& mistakes) {
  if (text.empty()) return std::nullopt;
  const auto side = [](std::string_view digits, int& value) {
    const auto end = std::from_chars(digits.data(), digits.data() + digits.size(), value);
    return end.ec == std::errc{} && end.ptr == digits.data() + digits.size() &&
           value >= sim::kLeastViewSide_px && value <= sim::kMostViewSide_px;
  };
  const std::size_t x = text.find('x');
  cv::Size size;
  if (x != std::string::npos && side(std::string_view(text).substr(0, x), size.width) &&
      side(std::string_view(text).substr(x + 1), size.height)) {
    return size;
  }
  mistakes.Add(option, "", fmt::format("'{}' is not a size", text),
               fmt::format("valid: WIDTHxHEIGHT, {} to {} px each, such as 1280x720", sim::kLeastViewSide_px,
                           sim::kMostViewSide_px));
  return std::nullopt;
}

std::optional<flight::ViewOptions> ReadView(const std::string& view, const std::string& size,
                                            const sim::ViewParameters& of_scenario, Mistakes& mistakes) {
  constexpr std::string_view kWithCamera = "+camera";
  if (view.empty()) {
    if (!size.empty()) mistakes.Add("--view-size", "", "given without --view");
    return std::nullopt;
  }
  flight::ViewOptions options;
  options.parameters = of_scenario;
  options.with_camera = view.ends_with(kWithCamera);
  std::string& kind = options.parameters.kind;
  kind = options.with_camera ? view.substr(0, view.size() - kWithCamera.size()) : view;
  if (std::ranges::find(sim::KindsOfView(), kind) == sim::KindsOfView().end()) {
    mistakes.Add("--view", "", fmt::format("'{}' is no view", view),
                 fmt::format("valid: {}, each also with +camera", fmt::join(sim::KindsOfView(), ", ")));
    return std::nullopt;
  }
  if (const auto given = ReadViewSize("--view-size", size, mistakes)) {
    options.parameters.width_px = given->width;
    options.parameters.height_px = given->height;
  }
  return options;
}

}  // namespace kestrel::app
