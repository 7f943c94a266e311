// SPDX-License-Identifier: Apache-2.0
#include "app/mosaic/mosaic_report.h"

#include <fmt/format.h>

#include "vision/enhance/motion/point_flow.h"

namespace kestrel::app {
namespace {

// In the order in which they are worth trying.
const std::vector<std::pair<vision::MosaicState, const char*>> kRemedies = {
    {vision::MosaicState::kNoTexture,
     "show nothing that can be followed: film closer or with more light, or focus the lens"},
    {vision::MosaicState::kLost,
     "agree with none before them: let images overlap by half (--every 1), or give --poses"},
    {vision::MosaicState::kOblique,
     "see the plane almost from its side: film downwards, or --surface sphere of a camera that turns"},
    {vision::MosaicState::kOtherSize,
     "have another size than the rest: scale them, or make a mosaic of each size"},
    {vision::MosaicState::kFull, "find no room: more --memory-mb, or fewer images by --every"}};

}  // namespace

std::string MosaicMemory(int memory_mb, const vision::MosaicOptions& options, const cv::Size& size) {
  return fmt::format(
      "memory {} MB: up to {} images are kept, of those that come after none has a place; beyond {:.1f} "
      "megapixels the mosaic is scaled down\n",
      memory_mb, vision::Mosaic::MostKept(options, size, 3),
      1e-6 * static_cast<double>(vision::Mosaic::MostPixels(options, 3)));
}

std::string MosaicReport(const MosaicArguments& a, const MosaicCount& count, double compose_s,
                         const std::vector<std::string>& written) {
  std::string text = fmt::format("{} images, {} in a mosaic", count.frames, count.placed);
  for (const auto& [state, n] : count.of_state) text += fmt::format(", {} {}", n, state);
  text += '\n';
  for (const auto& [state, remedy] : kRemedies)
    if (const auto n = count.of_state.find(vision::NameOf(state)); n != count.of_state.end())
      text += fmt::format("{} {} {}\n", n->second, n->first, remedy);
  if (count.placed == 1) text += "a mosaic of one image is that image: more are needed to see more\n";
  if (a.opencl) text += fmt::format("points were followed on {}\n", vision::FlowDevice(true));
  if (count.without_pose > 0)
    text += fmt::format("{} images have no pose in {}\n", count.without_pose, a.poses);
  if (count.poses_over > 0)
    text += fmt::format("{} poses are left over in {}: is it of these images?\n", count.poses_over, a.poses);
  if (const std::string interlaced = count.interlace.Sentence(a.input); !interlaced.empty())
    text += interlaced + '\n';
  for (const std::string& sentence : written) text += sentence + '\n';
  if (count.frames > 0)
    text += fmt::format("per image: reading {:.1f} ms, adding {:.1f} ms; adjusting and composing {:.1f} s\n",
                        1e3 * count.read_s / count.frames, 1e3 * count.add_s / count.frames, compose_s);
  return text;
}

}  // namespace kestrel::app
