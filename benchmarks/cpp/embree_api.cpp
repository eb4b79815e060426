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
void resolve(void* library, Function& function, const char* name) {
  function = reinterpret_cast<Function>(dlsym(library, name));
  if (!function) throw std::runtime_error(std::string("the Embree library has no function ") + name);
}

}  // namespace

const Api& load_api(const std::string& tbb, const std::string& embree) {
  if (loaded) return *loaded;
  if (!tbb.empty()) open_library(tbb, RTLD_GLOBAL);
  void* library = open_library(embree, RTLD_LOCAL);
  auto api = std::make_unique<Api>();
  resolve(library, api->NewDevice, "rtcNewDevice");
  resolve(library, api->ReleaseDevice, "rtcReleaseDevice");
  resolve(library, api->GetDeviceError, "rtcGetDeviceError");
  resolve(library, api->GetDeviceProperty, "rtcGetDeviceProperty");
  resolve(library, api->SetDeviceErrorFunction, "rtcSetDeviceErrorFunction");
  resolve(library, api->SetDeviceMemoryMonitorFunction, "rtcSetDeviceMemoryMonitorFunction");
  resolve(library, api->NewGeometry, "rtcNewGeometry");
  resolve(library, api->ReleaseGeometry, "rtcReleaseGeometry");
  resolve(library, api->CommitGeometry, "rtcCommitGeometry");
  resolve(library, api->SetNewGeometryBuffer, "rtcSetNewGeometryBuffer");
  resolve(library, api->SetGeometryBuildQuality, "rtcSetGeometryBuildQuality");
  resolve(library, api->SetGeometryUserPrimitiveCount, "rtcSetGeometryUserPrimitiveCount");
  resolve(library, api->SetGeometryUserData, "rtcSetGeometryUserData");
  resolve(library, api->SetGeometryBoundsFunction, "rtcSetGeometryBoundsFunction");
  resolve(library, api->SetGeometryIntersectFunction, "rtcSetGeometryIntersectFunction");
  resolve(library, api->SetGeometryOccludedFunction, "rtcSetGeometryOccludedFunction");
  resolve(library, api->SetGeometryEnableFilterFunctionFromArguments,
          "rtcSetGeometryEnableFilterFunctionFromArguments");
  resolve(library, api->NewScene, "rtcNewScene");
  resolve(library, api->ReleaseScene, "rtcReleaseScene");
  resolve(library, api->SetSceneBuildQuality, "rtcSetSceneBuildQuality");
  resolve(library, api->SetSceneFlags, "rtcSetSceneFlags");
  resolve(library, api->AttachGeometry, "rtcAttachGeometry");
  resolve(library, api->CommitScene, "rtcCommitScene");
  resolve(library, api->Intersect1, "rtcIntersect1");
  resolve(library, api->Intersect8, "rtcIntersect8");
  resolve(library, api->Intersect16, "rtcIntersect16");
  resolve(library, api->Occluded1, "rtcOccluded1");
  resolve(library, api->Occluded8, "rtcOccluded8");
  resolve(library, api->Occluded16, "rtcOccluded16");
  loaded = std::move(api);
  return *loaded;
}

const Api& api() {
  if (!loaded) throw std::runtime_error("Embree is not loaded: call load first");
  return *loaded;
}

}  // namespace fastlines::peers
