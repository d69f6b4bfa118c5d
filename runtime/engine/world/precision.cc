#include "runtime/engine/world/precision.h"

#include <btBulletDynamicsCommon.h>

#include <new>

namespace cdb::world {
namespace {

#ifdef BT_USE_DOUBLE_PRECISION
constexpr std::size_t kScalarBytes = 8;
#else
constexpr std::size_t kScalarBytes = 4;
#endif
static_assert(sizeof(btScalar) == kScalarBytes, "Bullet's headers have a different precision");

}  // namespace

const char* EnginePrecision() { return kScalarBytes == 8 ? "double" : "single"; }

std::string PrecisionMismatch() {
  // This function is compiled into the library, not inline: it reads a transform and writes two
  // vectors in the library's precision. The space suffices for either.
  struct alignas(32) Room {
    unsigned char bytes[512];
  };
  Room pose_room = {}, lower_room = {}, upper_room = {}, shape_room = {};
  static_assert(sizeof(btTransform) <= sizeof(Room) && sizeof(btStaticPlaneShape) <= sizeof(Room));
  auto* pose = new (&pose_room) btTransform(btQuaternion::getIdentity(), btVector3(1, 2, 3));
  auto* lower = new (&lower_room) btVector3(0, 0, 0);
  auto* upper = new (&upper_room) btVector3(0, 0, 0);
  // Virtual, because the symbols of a library of the other precision have the same names.
  const btSphereShape* sphere = new (&shape_room) btSphereShape(4);
  const btCollisionShape* volatile shape = sphere;
  shape->getAabb(*pose, *lower, *upper);
  const bool agrees = lower->x() == -3 && lower->y() == -2 && lower->z() == -1 && upper->x() == 5 &&
                      upper->y() == 6 && upper->z() == 7;
  if (agrees) return "";
  return std::string("this worker was built for Bullet in ") + EnginePrecision() +
         " precision, but the library has another; install libbullet-dev as packaged";
}

}  // namespace cdb::world
