// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <vector>

#include "vision/camera/file/sheet.h"

namespace kestrel::vision {

// How a program writes its calibrations, told by the content of a file. Cameras without a name of their own
// are called cam0, cam1, ... in the order of the file.
struct CameraForm {
  const char* written_by;
  const char* size_keys;                    // of the image, for who has to add them
  Keys (*cameras)(const ConfigNode& root);  // none: the file is not of this form
  // One of them. Says a mistake where it is not understood; the size of the image may be missing.
  void (*read)(const ConfigNode& root, std::size_t index, Sheet& sheet);
};
const std::vector<CameraForm>& CameraForms();
const CameraForm* FindForm(const ConfigNode& root);  // null: none

Keys NumberedCameras(std::size_t count);  // cam0, cam1, ...

}  // namespace kestrel::vision
