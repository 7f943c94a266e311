// SPDX-License-Identifier: Apache-2.0
#pragma once

// Embree 4 or 3: CMakeLists.txt looks for them in this order, too.
#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace kestrel::sim::ray {

// What rays meet that go side by side. intersect: rtcIntersect4 for an RTCRayHit4, and so on. valid: -1 for
// each ray that there is, 0 for the others.
template <typename Intersect, typename Packet>
void IntersectCoherent(Intersect* intersect, const int* valid, RTCScene scene, Packet* packet) {
#if RTC_VERSION_MAJOR >= 4
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  intersect(valid, scene, packet, &arguments);
#else
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  intersect(valid, scene, &context, packet);
#endif
}

}  // namespace kestrel::sim::ray
