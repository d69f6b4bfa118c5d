// ODE's collision spaces, with geometries that are only boxes.
//
// Source: R. Smith, Open Dynamics Engine 0.16, ode/src/collision_space.cpp and related files.
#include <ode/ode.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <stdexcept>
#include <vector>

#include "library/detectors/catalogue_entry.h"
#include "library/detectors/kernels/soa_boxes.h"

namespace cdb::third_party {
namespace {

/// The data of one of our geometries: the location of its box.
struct Place {
  const Box* box;
};

void GetBox(dGeomID geom, dReal bounds[6]) {
  const Box& box = *static_cast<const Place*>(dGeomGetClassData(geom))->box;
  const double values[6] = {box.lower.x, box.upper.x, box.lower.y,
                            box.upper.y, box.lower.z, box.upper.z};
  std::ranges::copy(values, bounds);
}

/// ODE allows four user classes of geometries per process, so all spaces share one.
int BoxClass() {
  static const int box_class = [] {
    if (!dCheckConfiguration("ODE_double_precision"))
      throw std::runtime_error(
          "this ODE is built for float, but its header for double; install a matching pair");
    if (!dInitODE2(0)) throw std::runtime_error("ODE does not start");
    const dGeomClass box = {sizeof(Place), [](int) -> dColliderFn* { return nullptr; }, GetBox,
                            nullptr, nullptr};
    return dCreateGeomClass(&box);
  }();
  return box_class;
}

bool IsSame(const Box& a, const Box& b) {
  return a.lower.x == b.lower.x && a.lower.y == b.lower.y && a.lower.z == b.lower.z &&
         a.upper.x == b.upper.x && a.upper.y == b.upper.y && a.upper.z == b.upper.z;
}

/// The smallest box around all boxes, and the mean of their longest sides.
struct Extent {
  Vec3 middle = {}, half = {};
  double mean_side = 0;
};

Extent ExtentOf(const Scene& scene, std::span<const Id> bodies) {
  Extent extent;
  if (bodies.empty()) return extent;
  Box all = scene.boxes[bodies.front()];
  for (const Id body : bodies) {
    const auto& [lower, upper] = scene.boxes[body];
    for (const auto axis : {&Vec3::x, &Vec3::y, &Vec3::z}) {
      all.lower.*axis = std::min(all.lower.*axis, lower.*axis);
      all.upper.*axis = std::max(all.upper.*axis, upper.*axis);
    }
    extent.mean_side += std::max({upper.x - lower.x, upper.y - lower.y, upper.z - lower.z});
  }
  extent.mean_side /= static_cast<double>(bodies.size());
  for (const auto axis : {&Vec3::x, &Vec3::y, &Vec3::z}) {
    extent.middle.*axis = (all.lower.*axis + all.upper.*axis) / 2;
    extent.half.*axis = (all.upper.*axis - all.lower.*axis) / 2;
  }
  return extent;
}

class Space : public kernels::FiniteBoxes {
 public:
  using kernels::FiniteBoxes::FiniteBoxes;
  ~Space() override { Clear(); }
  Space(const Space&) = delete;
  Space& operator=(const Space&) = delete;

 private:
  virtual dSpaceID Make(const Scene& scene, std::span<const Id> bodies) = 0;

  void Build(const Scene& scene, std::span<const Id> bodies) override {
    Clear();
    const int box_class = BoxClass();
    dAllocateODEDataForThread(dAllocateMaskAll);
    space_ = Make(scene, bodies);
    dSpaceSetCleanup(space_, 1);  // destroys the geometries too
    boxes_.resize(bodies.size());
    for (std::size_t i = 0; i < bodies.size(); ++i) {
      boxes_[i] = scene.boxes[bodies[i]];
      const dGeomID geom = dCreateGeom(box_class);
      static_cast<Place*>(dGeomGetClassData(geom))->box = &boxes_[i];
      dGeomSetData(geom, reinterpret_cast<void*>(static_cast<std::uintptr_t>(bodies[i])));
      dSpaceAdd(space_, geom);
      geoms_.push_back(geom);
    }
  }

  void ListPairs(const Scene& scene, std::vector<Pair>& pairs) override {
    for (std::size_t i = 0; i < geoms_.size(); ++i) {
      const Box& box = scene.boxes[bodies()[i]];
      if (IsSame(box, boxes_[i])) continue;
      boxes_[i] = box;
      // The position does not matter; setting it marks the box as changed.
      dGeomSetPosition(geoms_[i], box.lower.x, box.lower.y, box.lower.z);
    }
    dSpaceCollide(space_, &pairs, [](void* data, dGeomID a, dGeomID b) {
      static_cast<std::vector<Pair>*>(data)->push_back(Ordered(BodyOf(a), BodyOf(b)));
    });
  }

  static Id BodyOf(dGeomID geom) {
    return static_cast<Id>(reinterpret_cast<std::uintptr_t>(dGeomGetData(geom)));
  }

  void Clear() {
    geoms_.clear();
    if (space_ != nullptr) dSpaceDestroy(space_);
    space_ = nullptr;
  }

  dSpaceID space_ = nullptr;
  std::vector<Box> boxes_;
  std::vector<dGeomID> geoms_;
};

/// The cells of the hash are 2^k m; ODE numbers them in int, which limits their range.
constexpr int kLeastLevel = -3, kMostLevel = 30;

class HashSpace final : public Space {
 public:
  HashSpace() : Space(0x1p26) {}

 private:
  dSpaceID Make(const Scene&, std::span<const Id>) override {
    const dSpaceID space = dHashSpaceCreate(nullptr);
    dHashSpaceSetLevels(space, kLeastLevel, kMostLevel);
    return space;
  }
};

class SapSpace final : public Space {
  dSpaceID Make(const Scene&, std::span<const Id>) override {
    return dSweepAndPruneSpaceCreate(nullptr, dSAP_AXES_XYZ);
  }
};

class QuadtreeSpace final : public Space {
  /// Deep enough for leaves of about the size of the bodies, or one body per leaf, whichever is
  /// less.
  dSpaceID Make(const Scene& scene, std::span<const Id> bodies) override {
    const Extent extent = ExtentOf(scene, bodies);
    const double side = 2 * std::max(extent.half.x, extent.half.y);
    const double by_size = extent.mean_side > 0 ? std::log2(side / extent.mean_side) : 0;
    const double by_count = std::log2(static_cast<double>(bodies.size() + 1)) / 2;
    const int depth = static_cast<int>(std::clamp(std::min(by_size, by_count), 0.0, 8.0));
    const dVector3 middle = {extent.middle.x, extent.middle.y, extent.middle.z};
    const dVector3 half = {extent.half.x, extent.half.y, extent.half.z};
    return dQuadTreeSpaceCreate(nullptr, middle, half, depth);
  }
};

using detectors::CatalogueEntry;

constexpr DetectorEntry kEntries[] = {
    CatalogueEntry("ode_hash", kernels::MakeDetector<HashSpace>),
    CatalogueEntry("ode_sap", kernels::MakeDetector<SapSpace>),
    CatalogueEntry("ode_quadtree", kernels::MakeDetector<QuadtreeSpace>),
};

}  // namespace
}  // namespace cdb::third_party

CDB_DETECTORS(cdb::third_party::kEntries)
