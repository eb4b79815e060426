// The part of the Embree 4 interface that the peer uses, declared by hand and resolved in a library that is loaded at
// run time: fastlines neither links nor ships Embree.
//
// Names, values and layouts follow the "Embree API Reference" (embree.org/api.html): RTCRay, RTCHit, RTCRayHitN,
// RTCIntersectArguments, RTCGeometryType, and so on. A wrong one would fail benchmarks/tests/test_embree.py, which
// compares answers hit for hit.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

namespace fastlines::peers {

inline constexpr std::uint32_t kInvalid = ~0u;  // RTC_INVALID_GEOMETRY_ID

enum class GeometryType : int {
  triangle = 0,
  round_linear_curve = 16,
  flat_linear_curve = 17,
  round_bezier_curve = 24,
  sphere_point = 50,
  user = 120
};
enum class BufferType : int { index = 0, vertex = 1 };
enum class Format : int { uint1 = 0x5001, uint3 = 0x5003, float3 = 0x9003, float4 = 0x9004 };
enum class Quality : int { low = 0, medium = 1, high = 2 };
inline constexpr int kCompact = 1 << 1;             // RTC_SCENE_FLAG_COMPACT
inline constexpr int kInvokeFilter = 1 << 1;        // RTC_RAY_QUERY_FLAG_INVOKE_ARGUMENT_FILTER
inline constexpr int kCoherent = 1 << 16;           // RTC_RAY_QUERY_FLAG_COHERENT
inline constexpr std::uint32_t kAllFeatures = ~0u;  // RTC_FEATURE_FLAG_ALL

/// RTCRayN followed by RTCHitN, as consecutive arrays of N; for N = 1 this is RTCRayHit.
template <int N>
struct alignas(N == 1 ? 16 : 4 * N) RayHits {
  float ox[N], oy[N], oz[N], tnear[N];
  float dx[N], dy[N], dz[N], time[N];
  float tfar[N];
  std::uint32_t mask[N], id[N], flags[N];
  float nx[N], ny[N], nz[N], u[N], v[N];
  std::uint32_t prim[N], geom[N], instance[N], instance_prim[N];
};

/// The offsets of arrays in a ray packet and in a hit packet, in units of N words.
enum RayField { kOrigin = 0, kNear = 3, kDirection = 4, kFar = 8, kId = 10 };
enum HitField { kNormal = 0, kU = 3, kPrim = 5, kGeom = 6, kInstance = 7 };

/// RTCBounds.
struct alignas(16) Bounds {
  float lo[3], unused0, hi[3], unused1;
};

/// RTCBoundsFunctionArguments.
struct BoundsArguments {
  void* user;
  std::uint32_t prim, time_step;
  Bounds* bounds;
};

/// RTCRayQueryContext. A caller may append fields by deriving from it.
struct QueryContext {
  std::uint32_t instance = kInvalid, instance_prim = kInvalid;
};

/// RTCIntersectFunctionNArguments, and RTCOccludedFunctionNArguments, whose rays have no hits behind them.
struct CallbackArguments {
  int* valid;
  void* user;
  std::uint32_t prim;
  QueryContext* context;
  float* rays;
  std::uint32_t n, geom;
};

/// RTCFilterFunctionNArguments.
struct FilterArguments {
  int* valid;
  void* user;
  QueryContext* context;
  float* rays;
  float* hits;
  std::uint32_t n;
};

using Callback = void (*)(const CallbackArguments*);
using Filter = void (*)(const FilterArguments*);

/// RTCIntersectArguments and RTCOccludedArguments.
struct QueryArguments {
  int flags = 0;
  std::uint32_t features = kAllFeatures;
  QueryContext* context = nullptr;
  Filter filter = nullptr;
  Callback callback = nullptr;
  float min_width = 0.0f;
};

using Device = struct DeviceHandle*;
using Geometry = struct GeometryHandle*;
using SceneHandle = struct SceneObject*;

/// The functions of the library, named as there without "rtc".
struct Api {
  Device (*NewDevice)(const char*);
  void (*ReleaseDevice)(Device);
  int (*GetDeviceError)(Device);
  std::ptrdiff_t (*GetDeviceProperty)(Device, int);
  void (*SetDeviceErrorFunction)(Device, void (*)(void*, int, const char*), void*);
  void (*SetDeviceMemoryMonitorFunction)(Device, bool (*)(void*, std::ptrdiff_t, bool), void*);
  Geometry (*NewGeometry)(Device, GeometryType);
  void (*ReleaseGeometry)(Geometry);
  void (*CommitGeometry)(Geometry);
  void* (*SetNewGeometryBuffer)(Geometry, BufferType, unsigned, Format, std::size_t, std::size_t);
  void (*SetGeometryBuildQuality)(Geometry, Quality);
  void (*SetGeometryUserPrimitiveCount)(Geometry, unsigned);
  void (*SetGeometryUserData)(Geometry, void*);
  void (*SetGeometryBoundsFunction)(Geometry, void (*)(const BoundsArguments*), void*);
  void (*SetGeometryIntersectFunction)(Geometry, Callback);
  void (*SetGeometryOccludedFunction)(Geometry, Callback);
  void (*SetGeometryEnableFilterFunctionFromArguments)(Geometry, bool);
  SceneHandle (*NewScene)(Device);
  void (*ReleaseScene)(SceneHandle);
  void (*SetSceneBuildQuality)(SceneHandle, Quality);
  void (*SetSceneFlags)(SceneHandle, int);
  unsigned (*AttachGeometry)(SceneHandle, Geometry);
  void (*CommitScene)(SceneHandle);
  void (*Intersect1)(SceneHandle, void*, QueryArguments*);
  void (*Intersect8)(const int*, SceneHandle, void*, QueryArguments*);
  void (*Intersect16)(const int*, SceneHandle, void*, QueryArguments*);
  void (*Occluded1)(SceneHandle, void*, QueryArguments*);
  void (*Occluded8)(const int*, SceneHandle, void*, QueryArguments*);
  void (*Occluded16)(const int*, SceneHandle, void*, QueryArguments*);
};

/// The values of RTC_DEVICE_PROPERTY_….
inline constexpr int kVersionMajor = 1, kVersionMinor = 2, kVersionPatch = 3, kNative8 = 33, kNative16 = 34;

/// Loads the Embree library. Loads the TBB library that it needs first, so that the system need not search for it; ""
/// if there is none. Throws std::runtime_error with the system's message.
const Api& load_api(const std::string& tbb, const std::string& embree);

/// The loaded library; throws std::runtime_error if none is loaded.
const Api& api();

}  // namespace fastlines::peers
