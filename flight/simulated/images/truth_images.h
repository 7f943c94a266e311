// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <mujoco/mujoco.h>

#include <cstdint>
#include <filesystem>
#include <opencv2/core.hpp>
#include <optional>
#include <string>

#include "sim/camera/frame_renderer.h"

namespace kestrel::flight {

// The files below, of others who write them: geoms.csv, the values of N_geom.png, the bytes of N_flow.flo.
std::string GeomsCsv(const mjModel* model);
cv::Mat GeomPicture(const cv::Mat& geom);
std::string FlowFile(const cv::Mat& flow_px);

// Writes what is truly in each frame beside the frame, for training and judging vision, into a folder of its
// own. N is the frame's number (telemetry.csv: sequence):
//   N_image.png   what the flight code was given
//   N_depth.tiff  32-bit floats: m from the viewpoint along the ray; infinite: sky, NaN: no lens there
//   N_geom.png    16 bits: 0 no lens there, 1 sky, from 2 on the geoms of geoms.csv
//   N_flow.flo    as Middlebury has it: px to the next frame that is here; 1e10: unknown. Not by OpenGL
//   geoms.csv     value, name, body
// Throws std::runtime_error with the file and the reason.
class TruthImages {
 public:
  // Removes what an earlier run left there under these names.
  TruthImages(std::filesystem::path folder, const mjModel* model);

  void Write(std::int64_t sequence, const sim::RenderedFrame& picture);

 private:
  std::filesystem::path Name(std::int64_t sequence, const char* what) const;

  std::filesystem::path folder_;
  std::optional<std::int64_t> last_;
};

}  // namespace kestrel::flight
