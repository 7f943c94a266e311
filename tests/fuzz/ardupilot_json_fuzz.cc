// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdlib>
#include <cstring>

#include "sim/server/physics/ardupilot_json.h"

// Any bytes as a servo packet; and any numbers as a state, which is one line or none.
using namespace kestrel::sim::ardupilot;

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span<const std::uint8_t> bytes(data, size);
  static ServoSequence sequence;
  if (const auto packet = DecodeServoPacket(bytes)) {
    sequence.Classify(packet->frame_count);
    if (!std::ranges::equal(EncodeServoPacket(*packet), bytes)) std::abort();
  }
  kestrel::control::wire::Reader reader(bytes);
  PhysicsState state;
  state.t_s = reader.Read<double>();
  for (Eigen::Vector3d* v : {&state.w_B, &state.specific_force_B, &state.p_N, &state.v_N})
    for (double& x : *v) x = reader.Read<double>();
  while (reader.left() >= 8) {
    state.ranges_m.push_back(reader.Read<double>());
    state.rc_us.push_back(static_cast<int>(reader.left()));
  }
  if (const auto line = StateLine(state)) {
    if (line->front() != '\n' || line->find('\n', 1) != line->size() - 1) std::abort();
    if (line->find("nan") != std::string::npos || line->find("inf") != std::string::npos) std::abort();
  }
  return 0;
}
