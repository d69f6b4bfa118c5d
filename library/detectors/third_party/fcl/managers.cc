// FCL's broad-phase managers, with objects that are only boxes.
//
// SaPCollisionManager is not included: over 30 cycles of 5000 dense boxes it lost a pair; with
// 20,000 boxes around one point it crashed, with others it did not return (FCL 0.7).
// Source: J. Pan, S. Chitta & D. Manocha, FCL: A general purpose library for collision and
// proximity queries, 2012.
#include "library/detectors/third_party/fcl/managers.h"

#include <fcl/broadphase/broadphase_SSaP.h>
#include <fcl/broadphase/broadphase_dynamic_AABB_tree.h>
#include <fcl/broadphase/broadphase_dynamic_AABB_tree_array.h>
#include <fcl/broadphase/broadphase_interval_tree.h>
#include <fcl/broadphase/broadphase_spatialhash.h>
#include <fcl/geometry/shape/sphere.h>

#include <algorithm>
#include <limits>
#include <memory>
#include <utility>
#include <vector>

#include "library/detectors/kernels/soa_boxes.h"

namespace cdb::third_party {
namespace {

using Bounds = fcl::AABBd;
using Object = fcl::CollisionObjectd;
using Manager = fcl::BroadPhaseCollisionManagerd;

Bounds BoundsOf(const Box& box) {
  return {{box.lower.x, box.lower.y, box.lower.z}, {box.upper.x, box.upper.y, box.upper.z}};
}

/// An object with a given box; FCL would compute one from the box of the shape and the pose, with
/// rounding.
class BoxObject final : public Object {
 public:
  BoxObject(const std::shared_ptr<fcl::CollisionGeometryd>& shape, Id body)
      : Object(shape), body_(body) {}
  void Set(const Box& box) { aabb = BoundsOf(box); }
  Id body() const { return body_; }

 private:
  Id body_;
};

class FclBoxes : public kernels::FiniteBoxes {
 public:
  using kernels::FiniteBoxes::FiniteBoxes;

 protected:
  virtual std::unique_ptr<Manager> Make(const std::vector<Object*>& objects) = 0;
  /// Called after the boxes of the objects have moved.
  virtual void Update(Manager& manager, const std::vector<Object*>&) { manager.update(); }

  void Renew() {
    manager_ = Make(pointers_);
    manager_->registerObjects(pointers_);
    manager_->setup();
  }

 private:
  void Build(const Scene& scene, std::span<const Id> bodies) override {
    manager_.reset();
    objects_.clear();
    pointers_.clear();
    objects_.reserve(bodies.size());
    for (const Id body : bodies) {
      objects_.emplace_back(shape_, body).Set(scene.boxes[body]);
      pointers_.push_back(&objects_.back());
    }
    if (!bodies.empty()) Renew();
  }

  void ListPairs(const Scene& scene, std::vector<Pair>& pairs) override {
    for (BoxObject& object : objects_) object.Set(scene.boxes[object.body()]);
    Update(*manager_, pointers_);
    manager_->collide(&pairs, [](Object* a, Object* b, void* data) {
      static_cast<std::vector<Pair>*>(data)->push_back(
          Ordered(static_cast<BoxObject*>(a)->body(), static_cast<BoxObject*>(b)->body()));
      return false;  // go on
    });
  }

  const std::shared_ptr<fcl::CollisionGeometryd> shape_ = std::make_shared<fcl::Sphered>(1);
  std::vector<BoxObject> objects_;
  std::vector<Object*> pointers_;
  std::unique_ptr<Manager> manager_;
};

/// A manager that needs no data from the scene.
template <typename T>
class Plain final : public FclBoxes {
  std::unique_ptr<Manager> Make(const std::vector<Object*>&) override {
    return std::make_unique<T>();
  }
};

/// If its tree is far from balanced, as with bodies in a few clusters, update() renumbers the
/// leaves and lists the pairs of other bodies from then on (FCL 0.7); so it may balance only in
/// small steps.
class TreeArray final : public FclBoxes {
  std::unique_ptr<Manager> Make(const std::vector<Object*>&) override {
    auto manager = std::make_unique<fcl::DynamicAABBTreeCollisionManager_Array<double>>();
    manager->max_tree_nonbalanced_level = std::numeric_limits<int>::max();
    return manager;
  }
};

/// Its update() makes new intervals and leaks the old ones (192 bytes per body and cycle), so it is
/// refilled instead, at the same cost.
class IntervalTree final : public FclBoxes {
  std::unique_ptr<Manager> Make(const std::vector<Object*>&) override {
    return std::make_unique<fcl::IntervalTreeCollisionManagerd>();
  }
  void Update(Manager& manager, const std::vector<Object*>& objects) override {
    manager.clear();
    manager.registerObjects(objects);
    manager.setup();
  }
};

/// Needs a cell size and the limits of the world, beyond which it tests nothing: the limits are set
/// around the bodies with room to move, and again when a body leaves them.
class SpatialHash final : public FclBoxes {
 public:
  SpatialHash() : FclBoxes(0x1p26) {}

 private:
  using Hash = fcl::SpatialHashingCollisionManagerd<>;

  std::unique_ptr<Manager> Make(const std::vector<Object*>& objects) override {
    Bounds all = objects.front()->getAABB();
    double sum = 0, longest = 0;
    for (const Object* object : objects) {
      const double side = (object->getAABB().max_ - object->getAABB().min_).maxCoeff();
      all += object->getAABB();
      sum += side;
      longest = std::max(longest, side);
    }
    // A body occupies all cells that it touches: large bodies must not occupy too many, and cell
    // numbers must not overflow.
    const double extent = (all.max_ - all.min_).maxCoeff();
    const double cell = std::max({sum / static_cast<double>(objects.size()), longest / kMostCells,
                                  extent / kMostCellsAcross, 1e-3});
    const fcl::Vector3d room = (all.max_ - all.min_) / 4 + fcl::Vector3d::Constant(cell);
    limits_ = {all.min_ - room, all.max_ + room};
    const auto slots = static_cast<unsigned>(2 * objects.size() + 1000);
    return std::make_unique<Hash>(cell, limits_.min_, limits_.max_, slots);
  }

  void Update(Manager& manager, const std::vector<Object*>& objects) override {
    const bool is_inside = std::ranges::all_of(
        objects, [&](const Object* object) { return limits_.contain(object->getAABB()); });
    if (is_inside)
      manager.update();
    else
      Renew();
  }

  static constexpr double kMostCells = 16, kMostCellsAcross = 1e6;
  Bounds limits_;
};

}  // namespace

Detector* MakeFclTree(const Options&) { return new Plain<fcl::DynamicAABBTreeCollisionManagerd>; }
Detector* MakeFclTreeArray(const Options&) { return new TreeArray; }
Detector* MakeFclSsap(const Options&) { return new Plain<fcl::SSaPCollisionManagerd>; }
Detector* MakeFclSpatialHash(const Options&) { return new SpatialHash; }
Detector* MakeFclIntervalTree(const Options&) { return new IntervalTree; }

}  // namespace cdb::third_party
