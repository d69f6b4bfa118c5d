// The contact manifolds of a world that have contacts.
#pragma once

#include <btBulletDynamicsCommon.h>

#include <cstddef>
#include <ranges>
#include <span>

namespace cdb::world {

/// A view, in Bullet's order, valid until the world's next cycle. Not thread-safe with respect to
/// the world.
inline auto TouchingManifolds(btCollisionWorld& world) {
  btDispatcher& dispatcher = *world.getDispatcher();
  const std::span<const btPersistentManifold* const> manifolds(
      dispatcher.getInternalManifoldPointer(),
      static_cast<std::size_t>(dispatcher.getNumManifolds()));
  return manifolds | std::views::transform([](const btPersistentManifold* manifold) -> const auto& {
           return *manifold;
         }) |
         std::views::filter(
             [](const btPersistentManifold& manifold) { return manifold.getNumContacts() > 0; });
}

/// Bullet limits the coefficient of a contact.
inline constexpr double kMostFriction = 10;

/// True if the point had an impulse in the last cycle: those beyond the threshold keep an old one.
inline bool HasImpulse(const btPersistentManifold& manifold, const btManifoldPoint& point) {
  return point.getDistance() <= manifold.getContactProcessingThreshold() &&
         point.m_appliedImpulse != 0;
}

/// The impulse of friction on the first body. The second direction is used by multibodies only.
inline btVector3 FrictionImpulse(const btManifoldPoint& point) {
  return point.m_appliedImpulseLateral1 * point.m_lateralFrictionDir1 +
         point.m_appliedImpulseLateral2 * point.m_lateralFrictionDir2;
}

}  // namespace cdb::world
