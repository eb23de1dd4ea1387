// Embree 4, or 3 where there is no 4: what differs between them.
#pragma once

#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

namespace impedraw::embree {

#if RTC_VERSION_MAJOR >= 4
inline void intersect(RTCScene scene, RTCRayHit* ray) { rtcIntersect1(scene, ray, nullptr); }

// For rays that go much the same way. valid: -1 for each ray that counts, else 0.
inline void intersect_coherent(const int* valid, RTCScene scene, RTCRayHit8* packet) {
  RTCIntersectArguments arguments;
  rtcInitIntersectArguments(&arguments);
  arguments.flags = RTC_RAY_QUERY_FLAG_COHERENT;
  rtcIntersect8(valid, scene, packet, &arguments);
}
#else
inline void intersect(RTCScene scene, RTCRayHit* ray) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  rtcIntersect1(scene, &context, ray);
}

inline void intersect_coherent(const int* valid, RTCScene scene, RTCRayHit8* packet) {
  RTCIntersectContext context;
  rtcInitIntersectContext(&context);
  context.flags = RTC_INTERSECT_CONTEXT_FLAG_COHERENT;
  rtcIntersect8(valid, scene, &context, packet);
}
#endif

}  // namespace impedraw::embree
