// Bullet's narrow phase on pairs of two bodies, as a rival of other narrow phases.
#pragma once

#include <btBulletCollisionCommon.h>

#include <utility>
#include <vector>

#include "library/detectors/bullet/vectors.h"
#include "library/layouts/initial_state.h"
#include "runtime/engine/world/shapes.h"
#include "tests/library/detectors/narrow/pair_cases.h"

namespace cdb::bench {

/// The algorithm that Bullet has for each pair, kept with its manifolds from cycle to cycle. The
/// shapes are those of a run.
///
/// Only if it `copies`, FindContacts places the bodies of each pair, and returns the contacts.
class BulletPairs final : public Detector {
 public:
  BulletPairs(const std::vector<tests::PairCase>& cases, bool copies) : copies_(copies) {
    dispatcher_.setDispatcherFlags(
        btCollisionDispatcher::CD_USE_RELATIVE_CONTACT_BREAKING_THRESHOLD);
    bodies_.resize(2 * cases.size());
    for (std::size_t i = 0; i < cases.size(); ++i) {
      bodies_[2 * i].setCollisionShape(shapes_.Get(cases[i].a, layouts::kBulletMargin));
      btCollisionShape* other = &plane_;
      if (!cases[i].is_plane) other = shapes_.Get(cases[i].b, layouts::kBulletMargin);
      bodies_[2 * i + 1].setCollisionShape(other);
    }
    algorithms_.resize(cases.size());
  }
  ~BulletPairs() override {
    for (btCollisionAlgorithm* algorithm : algorithms_) {
      if (algorithm == nullptr) continue;
      algorithm->~btCollisionAlgorithm();
      dispatcher_.freeCollisionAlgorithm(algorithm);
    }
  }
  /// Puts the bodies where they are, which is no part of the narrow phase.
  void Place(const Scene& scene) {
    for (Id body = 0; body < bodies_.size(); ++body) PlaceBody(scene, body);
  }
  void FindContacts(const Scene& scene, std::span<const Pair> pairs,
                    std::vector<Contact>& contacts) override {
    const btDispatcherInfo info;
    for (const Pair& pair : pairs) {
      if (copies_) PlaceBody(scene, pair.a), PlaceBody(scene, pair.b);
      const btCollisionObject &a = bodies_[pair.a], &b = bodies_[pair.b];
      const btCollisionObjectWrapper of_a(nullptr, a.getCollisionShape(), &a, a.getWorldTransform(),
                                          -1, -1),
          of_b(nullptr, b.getCollisionShape(), &b, b.getWorldTransform(), -1, -1);
      btCollisionAlgorithm*& algorithm = algorithms_[pair.a / 2];
      if (algorithm == nullptr)
        algorithm = dispatcher_.findAlgorithm(&of_a, &of_b, nullptr, BT_CONTACT_POINT_ALGORITHMS);
      btManifoldResult result(&of_a, &of_b);
      algorithm->processCollision(&of_a, &of_b, info, &result);
      if (copies_) Copy(pair, *algorithm, contacts);
    }
  }

 private:
  void PlaceBody(const Scene& scene, Id body) {
    const Pose& pose = scene.poses[body];
    const auto at = [](double x) { return static_cast<btScalar>(x); };
    bodies_[body].setWorldTransform(btTransform(
        btMatrix3x3(at(pose.x.x), at(pose.y.x), at(pose.z.x), at(pose.x.y), at(pose.y.y),
                    at(pose.z.y), at(pose.x.z), at(pose.y.z), at(pose.z.z)),
        bullet::ToBullet(pose.position)));
  }
  void Copy(const Pair& pair, btCollisionAlgorithm& algorithm, std::vector<Contact>& contacts) {
    btManifoldArray manifolds;
    algorithm.getAllContactManifolds(manifolds);
    for (int m = 0; m < manifolds.size(); ++m)
      for (int k = 0; k < manifolds[m]->getNumContacts(); ++k) {
        const btManifoldPoint& point = manifolds[m]->getContactPoint(k);
        Contact contact = {.a = pair.a,
                           .b = pair.b,
                           .on_a = bullet::ToVec3(point.m_positionWorldOnA),
                           .on_b = bullet::ToVec3(point.m_positionWorldOnB),
                           .normal = bullet::ToVec3(point.m_normalWorldOnB),
                           .distance = static_cast<double>(point.getDistance())};
        if (manifolds[m]->getBody0() != &bodies_[pair.a]) {
          std::swap(contact.on_a, contact.on_b);
          contact.normal = {-contact.normal.x, -contact.normal.y, -contact.normal.z};
        }
        contacts.push_back(contact);
      }
  }

  const bool copies_;
  btDefaultCollisionConfiguration configuration_;
  btCollisionDispatcher dispatcher_{&configuration_};
  btStaticPlaneShape plane_{btVector3(0, 1, 0), 0};
  world::ShapePool shapes_;
  std::vector<btCollisionObject> bodies_;
  std::vector<btCollisionAlgorithm*> algorithms_;
};

}  // namespace cdb::bench
