// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <memory>
#include <string>

namespace kestrel::sim {

// A PNG file's picture in the form that MuJoCo takes without decoding it: two int32, width and height, then a byte
// each of red, green and blue. The last few are kept, for MuJoCo decodes them anew for each model, which takes half of
// a model's making. None: it is no PNG file of pixels that are understood.
std::shared_ptr<const std::string> DecodedTexture(const std::string& png);

}  // namespace kestrel::sim
