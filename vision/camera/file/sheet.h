// SPDX-License-Identifier: Apache-2.0
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "base/yaml/config.h"

namespace kestrel::vision {

using Keys = std::vector<std::string>;
using Nodes = std::vector<const ConfigNode*>;

// A member by its key, null: there is none; by the first of several keys that is there.
const ConfigNode* Find(const ConfigNode& node, std::string_view key);
const ConfigNode* FindAny(const ConfigNode& node, const Keys& keys);
std::string TextOf(const ConfigNode& node, std::string_view key);  // empty: it is not there

bool IsNumber(const ConfigNode& node, double expected);

// The elements of a value however it is written, row by row: a list, a list of rows, a matrix with its data,
// one number.
Nodes ElementsOf(const ConfigNode& node);

// What a foreign file says, under this project's keys and with the lines where it was written, so that one
// reader checks all.
struct Sheet {
  ConfigNode node;
  std::string path;  // before the keys in the mistakes
  Mistakes& mistakes;
  // The matrix of 4 x 4 that says where the camera is on its IMU, null: there is none; and whether it turns
  // coordinates of the IMU into the camera's, as T_cam_imu does, or the other way.
  const ConfigNode* on_imu = nullptr;
  bool to_camera = false;

  void Set(const std::string& key, const ConfigNode& value);
  void SetText(const std::string& key, const std::string& text, const Place& where);
  // Each element under a key of its own: of a list, or of a member that must be a list of so many.
  void SetAll(const Nodes& elements, const Keys& keys);
  void SetList(const ConfigNode& from, const std::string& key, const Keys& keys);
  // Members of a map, each of which must be there, under keys of ours.
  void SetMembers(const ConfigNode& from, const Keys& theirs, const Keys& ours);
  // Either of the two, where it is there.
  void SetSize(const ConfigNode* width, const ConfigNode* height);
  void Wrong(const Place& where, std::string_view key, const std::string& what,
             const std::string& remedy = {});
  // A word for a model or a distortion that is none of these.
  void Unknown(const ConfigNode& written, std::string_view key, const Keys& valid);
};

}  // namespace kestrel::vision
