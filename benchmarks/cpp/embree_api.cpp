// Loads Embree with dlopen.
#include "embree_api.hpp"

#include <dlfcn.h>

#include <memory>
#include <stdexcept>

namespace fastlines::peers {
namespace {

std::unique_ptr<Api> loaded;

void* open_library(const std::string& path, int flags) {
  void* library = dlopen(path.c_str(), RTLD_NOW | flags);
  if (!library) throw std::runtime_error(dlerror());
  return library;
}

template <class Function>
void take(void* library, Function& function, const char* name) {
  function = reinterpret_cast<Function>(dlsym(library, name));
  if (!function) throw std::runtime_error(std::string("the Embree library has no function ") + name);
}

}  // namespace

const Api& load_api(const std::string& tbb, const std::string& embree) {
  if (loaded) return *loaded;
  if (!tbb.empty()) open_library(tbb, RTLD_GLOBAL);
  void* library = open_library(embree, RTLD_LOCAL);
  auto api = std::make_unique<Api>();
  take(library, api->NewDevice, "rtcNewDevice");
  take(library, api->ReleaseDevice, "rtcReleaseDevice");
  take(library, api->GetDeviceError, "rtcGetDeviceError");
  take(library, api->GetDeviceProperty, "rtcGetDeviceProperty");
  take(library, api->SetDeviceErrorFunction, "rtcSetDeviceErrorFunction");
  take(library, api->SetDeviceMemoryMonitorFunction, "rtcSetDeviceMemoryMonitorFunction");
  take(library, api->NewGeometry, "rtcNewGeometry");
  take(library, api->ReleaseGeometry, "rtcReleaseGeometry");
  take(library, api->CommitGeometry, "rtcCommitGeometry");
  take(library, api->SetNewGeometryBuffer, "rtcSetNewGeometryBuffer");
  take(library, api->SetGeometryBuildQuality, "rtcSetGeometryBuildQuality");
  take(library, api->SetGeometryUserPrimitiveCount, "rtcSetGeometryUserPrimitiveCount");
  take(library, api->SetGeometryUserData, "rtcSetGeometryUserData");
  take(library, api->SetGeometryBoundsFunction, "rtcSetGeometryBoundsFunction");
  take(library, api->SetGeometryIntersectFunction, "rtcSetGeometryIntersectFunction");
  take(library, api->SetGeometryOccludedFunction, "rtcSetGeometryOccludedFunction");
  take(library, api->SetGeometryEnableFilterFunctionFromArguments, "rtcSetGeometryEnableFilterFunctionFromArguments");
  take(library, api->NewScene, "rtcNewScene");
  take(library, api->ReleaseScene, "rtcReleaseScene");
  take(library, api->SetSceneBuildQuality, "rtcSetSceneBuildQuality");
  take(library, api->AttachGeometry, "rtcAttachGeometry");
  take(library, api->CommitScene, "rtcCommitScene");
  take(library, api->Intersect1, "rtcIntersect1");
  take(library, api->Intersect8, "rtcIntersect8");
  take(library, api->Intersect16, "rtcIntersect16");
  take(library, api->Occluded1, "rtcOccluded1");
  take(library, api->Occluded8, "rtcOccluded8");
  take(library, api->Occluded16, "rtcOccluded16");
  loaded = std::move(api);
  return *loaded;
}

const Api& api() {
  if (!loaded) throw std::runtime_error("Embree is not loaded: call load first");
  return *loaded;
}

}  // namespace fastlines::peers
