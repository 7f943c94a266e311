// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <optional>

#include "app/mosaic/mosaic_command.h"
#include "base/diagnostics.h"
#include "vision/camera/camera_model.h"
#include "vision/enhance/mosaic/composition.h"
#include "vision/enhance/mosaic/mosaic.h"

// What the arguments of `kestrel mosaic` mean.
namespace kestrel::app {

bool MosaicOnPlane(const MosaicArguments& arguments);

// From a file, or a pinhole by its field of view, or none.
std::optional<vision::CameraModel> MosaicCameraOf(const MosaicArguments& arguments, const ImageInput& input,
                                                  Mistakes& mistakes);

// Half of the memory is for this, and half composes the picture.
vision::MosaicOptions MosaicOptionsOf(const MosaicArguments& arguments,
                                      const std::optional<vision::CameraModel>& camera);
vision::CompositionOptions MosaicCompositionOf(const MosaicArguments& arguments);

}  // namespace kestrel::app
