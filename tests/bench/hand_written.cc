#include "tests/bench/hand_written.h"

#include <time.h>

#include <cstdlib>

namespace cdb::bench {
namespace {

btVector3 ToBullet(const Eigen::Vector3d& v) {
  return {static_cast<btScalar>(v.x()), static_cast<btScalar>(v.y()), static_cast<btScalar>(v.z())};
}

double NowNs() {
  timespec now;
  clock_gettime(CLOCK_MONOTONIC, &now);
  return 1e9 * static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec);
}

}  // namespace

HandWritten::HandWritten(const layouts::InitialState& state, double side) {
  world_.setGravity(ToBullet(state.acceleration));
  // One shape for each type, as all objects are of one size.
  btCollisionShape* by_type[4] = {};
  for (const layouts::ObjectState& object : state.objects) {
    btCollisionShape*& shape = by_type[static_cast<int>(object.solid.shape)];
    if (shape == nullptr) {
      const btVector3 half = ToBullet(object.solid.HalfExtents());
      switch (object.solid.shape) {
        case objects::Shape::kEllipsoid:
          shape = new btSphereShape(half.x());
          break;
        case objects::Shape::kCuboid:
          shape = new btBoxShape(half);
          break;
        case objects::Shape::kCylinder:
          shape = new btCylinderShape(half);
          break;
        default:
          std::abort();  // Bullet's own are other bodies
      }
      shapes_.push_back(shape);
    }
    const auto mass = static_cast<btScalar>(object.mass);
    btRigidBody::btRigidBodyConstructionInfo info(mass, nullptr, shape,
                                                  mass * ToBullet(object.solid.InertiaPerMass()));
    const Eigen::Quaterniond& turn = object.pose.orientation;
    info.m_startWorldTransform.setRotation(
        btQuaternion(static_cast<btScalar>(turn.x()), static_cast<btScalar>(turn.y()),
                     static_cast<btScalar>(turn.z()), static_cast<btScalar>(turn.w())));
    info.m_startWorldTransform.setOrigin(ToBullet(object.pose.position));
    auto* body = new btRigidBody(info);
    body->setLinearVelocity(ToBullet(object.linear_velocity));
    body->setAngularVelocity(ToBullet(object.angular_velocity));
    world_.addRigidBody(body);
    objects_.push_back(body);
  }
  for (int axis = 0; axis < 3; ++axis) {
    for (const int sign : {-1, 1}) {
      const Eigen::Vector3d inward = -sign * Eigen::Vector3d::Unit(axis);
      shapes_.push_back(new btStaticPlaneShape(ToBullet(inward), 0));
      btRigidBody::btRigidBodyConstructionInfo info(0, nullptr, shapes_.back());
      info.m_startWorldTransform.setOrigin(ToBullet(-inward * side / 2));
      info.m_restitution = 1;
      auto* wall = new btRigidBody(info);
      world_.addRigidBody(wall);
      walls_.push_back(wall);
    }
  }
}

HandWritten::~HandWritten() {
  for (auto* list : {&objects_, &walls_}) {
    for (btRigidBody* body : *list) {
      world_.removeRigidBody(body);
      delete body;
    }
  }
  for (btCollisionShape* shape : shapes_) delete shape;
}

double HandWritten::Step(double timestep) {
  const auto dt = static_cast<btScalar>(timestep);
  const double begin = NowNs();
  world_.stepSimulation(dt, 1, dt);
  return NowNs() - begin;
}

}  // namespace cdb::bench
