// Embree's rtcCollide: a tree of boxes, built anew every cycle and intersected with itself.
//
// Embree uses float: boxes are rounded outwards for it, and its results are tested again with the
// original boxes, as Embree's manual requires of the callback.
// Source: Embree 3.13 and 4.3, doc/src/api (rtcCollide).
#if __has_include(<embree4/rtcore.h>)
#include <embree4/rtcore.h>
#else
#include <embree3/rtcore.h>
#endif

#include <cmath>
#include <limits>
#include <memory>
#include <mutex>
#include <stdexcept>
#include <string>
#include <vector>

#include "library/detectors/catalogue_entry.h"
#include "library/detectors/kernels/soa_boxes.h"

namespace cdb::third_party {
namespace {

constexpr float kInfinite = std::numeric_limits<float>::infinity();

float Below(double x) {
  const auto rounded = static_cast<float>(x);
  return rounded > x ? std::nextafter(rounded, -kInfinite) : rounded;
}
float Above(double x) {
  const auto rounded = static_cast<float>(x);
  return rounded < x ? std::nextafter(rounded, kInfinite) : rounded;
}

struct Release {
  void operator()(RTCDevice device) const { rtcReleaseDevice(device); }
  void operator()(RTCScene scene) const { rtcReleaseScene(scene); }
  void operator()(RTCGeometry geometry) const { rtcReleaseGeometry(geometry); }
};
template <typename T>
using Owned = std::unique_ptr<std::remove_pointer_t<T>, Release>;

class Collide final : public kernels::FiniteBoxes {
 public:
  /// Embree drops boxes beyond the square root of the largest float.
  explicit Collide(const Options& options)
      : kernels::FiniteBoxes(1e18),
        device_(rtcNewDevice(("threads=" + std::to_string(options.threads)).c_str())) {
    if (device_ == nullptr) throw std::runtime_error("Embree does not start");
  }

 private:
  void Build(const Scene&, std::span<const Id> bodies) override {
    // Embree requires the geometry to be in its scene before the number of boxes changes.
    scene_.reset(rtcNewScene(device_.get()));
    rtcSetSceneFlags(scene_.get(), RTC_SCENE_FLAG_DYNAMIC | RTC_SCENE_FLAG_ROBUST);
    rtcSetSceneBuildQuality(scene_.get(), RTC_BUILD_QUALITY_LOW);
    geometry_.reset(rtcNewGeometry(device_.get(), RTC_GEOMETRY_TYPE_USER));
    rtcSetGeometryUserPrimitiveCount(geometry_.get(), static_cast<unsigned>(bodies.size()));
    rtcSetGeometryUserData(geometry_.get(), this);
    rtcSetGeometryBoundsFunction(geometry_.get(), GetBounds, nullptr);
    rtcCommitGeometry(geometry_.get());
    rtcAttachGeometry(scene_.get(), geometry_.get());
  }

  void ListPairs(const Scene& scene, std::vector<Pair>& pairs) override {
    current_ = &scene;
    pairs_ = &pairs;
    rtcCommitGeometry(geometry_.get());
    rtcCommitScene(scene_.get());
    rtcCollide(scene_.get(), scene_.get(), Keep, this);
    if (const RTCError error = rtcGetDeviceError(device_.get()); error != RTC_ERROR_NONE)
      throw std::runtime_error("Embree fails with its error " + std::to_string(error));
  }

  static void GetBounds(const RTCBoundsFunctionArguments* args) {
    const auto* self = static_cast<const Collide*>(args->geometryUserPtr);
    const auto& [lower, upper] = self->current_->boxes[self->bodies()[args->primID]];
    RTCBounds& bounds = *args->bounds_o;
    bounds.lower_x = Below(lower.x);
    bounds.lower_y = Below(lower.y);
    bounds.lower_z = Below(lower.z);
    bounds.upper_x = Above(upper.x);
    bounds.upper_y = Above(upper.y);
    bounds.upper_z = Above(upper.z);
  }

  /// Called from several threads at once if Embree uses several.
  static void Keep(void* data, RTCCollision* collisions, unsigned count) {
    auto* self = static_cast<Collide*>(data);
    const std::lock_guard lock(self->mutex_);
    for (const RTCCollision& found : std::span(collisions, count)) {
      // A scene intersected with itself reports every pair from both sides, and each body with
      // itself.
      if (found.primID0 >= found.primID1) continue;
      const Id a = self->bodies()[found.primID0], b = self->bodies()[found.primID1];
      if (Overlap(self->current_->boxes[a], self->current_->boxes[b]))
        self->pairs_->push_back({a, b});
    }
  }

  Owned<RTCDevice> device_;
  Owned<RTCGeometry> geometry_;
  Owned<RTCScene> scene_;
  const Scene* current_ = nullptr;
  std::vector<Pair>* pairs_ = nullptr;
  std::mutex mutex_;
};

using detectors::CatalogueEntry;

constexpr DetectorEntry kEntries[] = {
    CatalogueEntry("embree",
                   [](const Options& options) -> Detector* { return new Collide(options); }),
};

}  // namespace
}  // namespace cdb::third_party

CDB_DETECTORS(cdb::third_party::kEntries)
