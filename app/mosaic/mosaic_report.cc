// SPDX-License-Identifier: Apache-2.0
#include "app/mosaic/mosaic_report.h"

#include <fmt/format.h>

#include "vision/enhance/motion/point_flow.h"

namespace kestrel::app {
namespace {

// In the order in which they are worth trying.
const std::vector<std::pair<vision::MosaicState, const char*>> kRemedies = {
    {vision::MosaicState::kNoTexture,
     "nothing can be followed; film closer or with more light, or focus the lens"},
    {vision::MosaicState::kLost,
     "nothing before shows the same; let images overlap by half (--every 1), or give --poses"},
    {vision::MosaicState::kOblique,
     "the plane is seen almost from its side, or its pose puts it far away or far above the first; film "
     "downwards, begin in the air, or --surface sphere of a camera that turns"},
    {vision::MosaicState::kOtherSize,
     "another size than the rest; scale them, or make a mosaic of each size"},
    {vision::MosaicState::kUnreadable, "the file is damaged; write it again"},
    {vision::MosaicState::kFull, "memory is used up; more --memory-mb, or fewer images by --every"}};

std::string Images(int n) { return fmt::format("{} image{}", n, n == 1 ? "" : "s"); }

}  // namespace

std::string MosaicMemory(int memory_mb, const vision::MosaicOptions& options, const cv::Size& size) {
  return fmt::format(
      "memory {} MB: up to {} images are kept, of those that come after none has a place; beyond {:.1f} "
      "megapixels the mosaic is scaled down\n",
      memory_mb, vision::Mosaic::MostKept(options, size, 3),
      1e-6 * static_cast<double>(vision::Mosaic::MostPixels(options, 3)));
}

int MosaicCount::joined() const {
  const auto first = of_state.find(vision::NameOf(vision::MosaicState::kFirst));
  return placed - (first == of_state.end() ? 0 : first->second);
}

std::string MosaicReport(const MosaicArguments& a, const MosaicCount& count, double compose_s,
                         const std::vector<std::string>& written) {
  std::string text = fmt::format("{}, {} in a mosaic", Images(count.frames), count.placed);
  for (const auto& [state, n] : count.of_state) text += fmt::format(", {} {}", n, state);
  text += '\n';
  for (const auto& [state, remedy] : kRemedies)
    if (const auto n = count.of_state.find(vision::NameOf(state)); n != count.of_state.end())
      text += fmt::format("{} {}: {}\n", n->second, n->first, remedy);
  if (count.joined() == 0)
    text += count.placed == 0 ? "no image is in a mosaic, and nothing is written\n"
                              : "no images were joined: a mosaic of one image is that image\n";
  if (a.opencl) text += fmt::format("points were followed on {}\n", vision::FlowDevice(true));
  if (count.without_pose > 0)
    text += fmt::format("without a pose in {}: {}\n", a.poses, Images(count.without_pose));
  if (count.below_ground > 0)
    text += fmt::format("not above the ground by {}: {}, whose poses are not used; --ground-down-m is {:g}\n",
                        a.poses, Images(count.below_ground), a.ground_down_m);
  if (count.against_pose > 0)
    text += fmt::format(
        "against {}: {} would lie elsewhere by what they show; is it of these images, --mount-* as the "
        "camera is mounted, --pose-sigma-m large enough?\n",
        a.poses, Images(count.against_pose));
  if (count.poses_over > 0)
    text += fmt::format("left over in {}: {} pose{}; is it of these images?\n", a.poses, count.poses_over,
                        count.poses_over == 1 ? "" : "s");
  if (const std::string interlaced = count.interlace.Sentence(a.input); !interlaced.empty())
    text += interlaced + '\n';
  for (const std::string& sentence : written) text += sentence + '\n';
  if (count.frames > 0)
    text += fmt::format("per image: reading {:.1f} ms, adding {:.1f} ms; adjusting and composing {:.1f} s\n",
                        1e3 * count.read_s / count.frames, 1e3 * count.add_s / count.frames, compose_s);
  return text;
}

}  // namespace kestrel::app
