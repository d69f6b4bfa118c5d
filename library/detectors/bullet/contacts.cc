#include "library/detectors/bullet/contacts.h"

#include <btBulletCollisionCommon.h>

#include <algorithm>
#include <memory>

#include "library/detectors/bullet/vectors.h"

namespace cdb::bullet {
namespace {

bool IsBall(const Shape& shape) {
  return shape.kind == ShapeKind::kEllipsoid && shape.half.x == shape.half.y &&
         shape.half.y == shape.half.z;
}

/// Records the contacts that an algorithm finds, instead of keeping them in a manifold.
class Listener final : public btManifoldResult {
 public:
  Listener(const btCollisionObjectWrapper& a, const btCollisionObjectWrapper& b, const Pair& pair,
           std::vector<Contact>& contacts)
      : btManifoldResult(&a, &b), pair_(pair), contacts_(contacts) {}
  void addContactPoint(const btVector3& normal, const btVector3& on_b, btScalar depth) override {
    contacts_.push_back({pair_.a, pair_.b, ToVec3(on_b + normal * depth), ToVec3(on_b),
                         ToVec3(normal), static_cast<double>(depth)});
  }

 private:
  const Pair pair_;
  std::vector<Contact>& contacts_;
};

class BulletContacts final : public Detector {
 public:
  void Prepare(const Scene& scene) override {
    bodies_ = std::vector<btCollisionObject>(scene.size);
    for (Id body = 0; body < scene.size; ++body) {
      const Shape& shape = scene.shapes[body];
      if (IsBall(shape)) {
        shapes_.push_back(std::make_unique<btSphereShape>(static_cast<btScalar>(shape.half.x)));
      } else if (shape.kind == ShapeKind::kBox) {
        shapes_.push_back(std::make_unique<btBoxShape>(ToBullet(shape.half)));
        // The margin affects the rounding of half extents.
        shapes_.back()->setMargin(static_cast<btScalar>(
            std::min(0.04, std::min({shape.half.x, shape.half.y, shape.half.z}) / 10)));
      } else {
        continue;
      }
      bodies_[body].setCollisionShape(shapes_.back().get());
    }
  }

  bool Handles(const Scene& scene, Id a, Id b) const override {
    const Shape &first = scene.shapes[a], &second = scene.shapes[b];
    return (IsBall(first) && IsBall(second)) ||
           (first.kind == ShapeKind::kBox && second.kind == ShapeKind::kBox);
  }

  void FindContacts(const Scene& scene, std::span<const Pair> pairs,
                    std::vector<Contact>& contacts) override {
    const btDispatcherInfo info;
    for (const Pair& pair : pairs) {
      const btCollisionObject &a = Placed(scene, pair.a), &b = Placed(scene, pair.b);
      const btCollisionObjectWrapper wrap_a(nullptr, a.getCollisionShape(), &a,
                                            a.getWorldTransform(), -1, -1);
      const btCollisionObjectWrapper wrap_b(nullptr, b.getCollisionShape(), &b,
                                            b.getWorldTransform(), -1, -1);
      btCollisionAlgorithm* algorithm =
          dispatcher_.findAlgorithm(&wrap_a, &wrap_b, nullptr, BT_CONTACT_POINT_ALGORITHMS);
      Listener listener(wrap_a, wrap_b, pair, contacts);
      algorithm->processCollision(&wrap_a, &wrap_b, info, &listener);
      algorithm->~btCollisionAlgorithm();
      dispatcher_.freeCollisionAlgorithm(algorithm);
    }
  }

 private:
  const btCollisionObject& Placed(const Scene& scene, Id body) {
    const Pose& pose = scene.poses[body];
    bodies_[body].setWorldTransform(
        btTransform(btMatrix3x3(static_cast<btScalar>(pose.x.x), static_cast<btScalar>(pose.y.x),
                                static_cast<btScalar>(pose.z.x), static_cast<btScalar>(pose.x.y),
                                static_cast<btScalar>(pose.y.y), static_cast<btScalar>(pose.z.y),
                                static_cast<btScalar>(pose.x.z), static_cast<btScalar>(pose.y.z),
                                static_cast<btScalar>(pose.z.z)),
                    ToBullet(pose.position)));
    return bodies_[body];
  }

  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  std::vector<std::unique_ptr<btConvexShape>> shapes_;
  std::vector<btCollisionObject> bodies_;
};

}  // namespace

Detector* MakeBulletContacts(const Options&) { return new BulletContacts; }

}  // namespace cdb::bullet
