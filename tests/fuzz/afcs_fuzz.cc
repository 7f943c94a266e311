// SPDX-License-Identifier: Apache-2.0
#include <algorithm>
#include <cstdlib>
#include <span>
#include <string>
#include <vector>

#include "control/wire/afcs.h"
#include "tests/control/wire/other_afcs_profile.h"

// The input is a row of datagrams, each behind a byte with its length, or with the message that it is made to
// be, for one receiver: of the thesis's profile or of another with every type and order in it. Whatever they
// are: what is accepted is encoded back to the same datagram (but for padding), and the times of what is
// accepted of a type rise.
namespace {

using namespace kestrel::control::wire;  // NOLINT(google-build-using-namespace)

void Require(bool promise) {
  if (!promise) std::abort();
}

// A datagram with the right header and length for a message, around some of the input.
Bytes Made(const AfcsCodec& codec, std::size_t index, std::span<const std::uint8_t> input) {
  static const AfcsMessage kMessages[] = {AfcsOpen{},     AfcsAck{},   AfcsClose{},  AfcsState{},
                                          AfcsGpsState{}, AfcsFlyTo{}, AfcsTeleop{}, AfcsDesiredPosition{},
                                          AfcsPlatform{}};
  AfcsTime time;
  if (input.size() >= 2) time = {input[0], input[1]};
  Bytes bytes = codec.Encode({time, kMessages[index]});
  for (std::size_t i = 2; i < input.size() && codec.header_bytes() + i - 2 < bytes.size(); ++i)
    bytes[codec.header_bytes() + i - 2] = input[i];
  return bytes;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static const AfcsCodec kCodecs[] = {AfcsCodec(ThesisAfcsProfile()), AfcsCodec(OtherAfcsProfile())};
  if (size < 1) return 0;
  const std::size_t which = data[0] % 2;
  const AfcsCodec& codec = kCodecs[which];
  AfcsReceiver receiver{codec};
  std::span<const std::uint8_t> rest(data + 1, size - 1);
  std::vector<std::optional<AfcsTime>> last(kAfcsMessageNames.size());
  std::uint64_t datagrams = 0, accepted = 0;
  while (!rest.empty()) {
    const std::size_t what = rest[0];
    const std::size_t length = std::min<std::size_t>(what, rest.size() - 1);
    const auto input = rest.subspan(1, length);
    rest = rest.subspan(1 + length);
    Bytes bytes(input.begin(), input.end());
    if (what >= 224) bytes = Made(codec, what % kAfcsMessageNames.size(), input);
    ++datagrams;
    const auto received = receiver.Receive(bytes);
    if (!received) continue;
    ++accepted;
    auto& before = last[received->message.index()];
    Require(!before || *before < received->time);
    before = received->time;
    const Bytes again = codec.Encode(*received);
    Require(again.size() == bytes.size());
    const auto decoded = codec.Decode(again);
    Require(std::holds_alternative<AfcsDatagram>(decoded));
    Require(codec.Encode(std::get<AfcsDatagram>(decoded)) == again);  // not ==: NaN
    Require(std::equal(again.begin(), again.begin() + static_cast<std::ptrdiff_t>(codec.header_bytes()),
                       bytes.begin()));
    if (which == 0 &&
        received->message.index() == 3)  // the state has no padding, and every type holds its own
      Require(std::equal(again.begin(), again.end(), bytes.begin()));
  }
  std::uint64_t refused = 0;
  for (std::size_t why = 0; why < kAfcsRefusals; ++why)
    refused += receiver.refused(static_cast<AfcsRefusal>(why));
  Require(receiver.accepted() == accepted && accepted + refused == datagrams);
  return 0;
}
