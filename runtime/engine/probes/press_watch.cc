#include "runtime/engine/probes/press_watch.h"

#include <algorithm>
#include <cmath>
#include <ranges>

#include "library/objects/distance.h"
#include "runtime/engine/world/conversions.h"
#include "runtime/engine/world/manifolds.h"

namespace cdb::probes {
namespace {

using Eigen::Vector3d;

/// Depths in least sides of the smaller object.
constexpr double kShallowStart = 0.05, kDeep = 0.25;
constexpr int kHoldsWithin = 3, kPressed = 6;  ///< cycles
constexpr double kImpactTime = 0.5;            ///< s
/// Loads are searched for in the first cycles, at contacts that are upright and slow enough.
constexpr int kFirstCycles = 10;
constexpr double kUpright = 0.9, kSlow = 0.5;

}  // namespace

PressWatch::PressWatch(world::Engine& engine, const ContactSides& contact_sides, bool is_driven)
    : engine_(engine),
      contact_sides_(contact_sides),
      is_driven_(is_driven),
      patience_(std::max(
          2 * kPressed,
          static_cast<int>(std::min(1e6, kImpactTime / static_cast<double>(engine.timestep()))))) {
  for (const layouts::ObjectState& object : engine.initial_state().objects) {
    inner_.push_back(object.solid.InnerRadius());
    outer_.push_back(object.solid.OuterRadius());
  }
  loaded_.resize(inner_.size());
}

Vector3d PressWatch::PositionOf(std::uint32_t body) const {
  return world::ToEigen(engine_.objects()[body]->getWorldTransform().getOrigin());
}

bool PressWatch::IsSoft(std::uint32_t body) const {
  return IsObject(body) &&
         std::isfinite(engine_.initial_state().objects[body].numbers["contact_stiffness"]);
}

PressWatch::Seen PressWatch::After() {
  pairs_.swap(last_);
  pairs_.clear();
  CollectContacts();
  CollectCentres();
  Follow();
  if (cycle_ < kFirstCycles && !is_driven_) FindLoads();
  ++cycle_;
  const auto is_pressed = [this](const Pair& pair) {
    return !pair.from_start && pair.deep >= (pair.by_impact ? patience_ : kPressed);
  };
  return {static_cast<std::int32_t>(std::ranges::count_if(pairs_, is_pressed)), CountInverted()};
}

void PressWatch::CollectContacts() {
  std::ranges::fill(loaded_, 0);
  for (const btPersistentManifold& manifold : world::TouchingManifolds(engine_.world())) {
    const Bodies bodies =
        std::minmax(static_cast<std::uint32_t>(manifold.getBody0()->getUserIndex()),
                    static_cast<std::uint32_t>(manifold.getBody1()->getUserIndex()));
    const double least = contact_sides_.Least(bodies.first, bodies.second);
    double ratio = 0;
    for (int j = 0; j < manifold.getNumContacts(); ++j) {
      const btManifoldPoint& point = manifold.getContactPoint(j);
      const double depth = -static_cast<double>(point.getDistance());
      if (depth > kShallowStart * least)
        ratio = std::max(ratio, depth / contact_sides_.At(manifold, point));
    }
    if (IsObject(bodies.second)) loaded_[bodies.first] = loaded_[bodies.second] = 1;
    if (ratio > kShallowStart && !IsSoft(bodies.first) && !IsSoft(bodies.second))
      pairs_.push_back({bodies, ratio});
  }
  std::erase_if(pairs_, [this](const Pair& pair) {
    return !IsObject(pair.bodies.second) && !loaded_[pair.bodies.first];
  });
}

void PressWatch::CollectCentres() {
  const auto is_inside = [this](std::uint32_t object, std::uint32_t other, const Vector3d& way) {
    const objects::Solid& solid = engine_.initial_state().objects[other].solid;
    if (!(inner_[object] > 0) || way.squaredNorm() > outer_[other] * outer_[other]) return false;
    // Compounds are checked only if their pieces may be close.
    if (solid.shape == objects::Shape::kCompound &&
        way.squaredNorm() > inner_[other] * inner_[other])
      return false;
    const btMatrix3x3& basis = engine_.objects()[other]->getWorldTransform().getBasis();
    return Contains(solid, world::ToEigen(world::ToBullet(way) * basis));
  };
  btOverlappingPairCache& cache = *engine_.world().getPairCache();
  const btBroadphasePair* begin = cache.getOverlappingPairArrayPtr();
  for (int i = 0; i < cache.getNumOverlappingPairs(); ++i) {
    const auto& first = *static_cast<btCollisionObject*>(begin[i].m_pProxy0->m_clientObject);
    const auto& second = *static_cast<btCollisionObject*>(begin[i].m_pProxy1->m_clientObject);
    const Bodies bodies = std::minmax(static_cast<std::uint32_t>(first.getUserIndex()),
                                      static_cast<std::uint32_t>(second.getUserIndex()));
    if (!IsObject(bodies.second)) continue;
    const Vector3d way = PositionOf(bodies.second) - PositionOf(bodies.first);
    if (!is_inside(bodies.second, bodies.first, way) &&
        !is_inside(bodies.first, bodies.second, -way))
      continue;
    if (first.checkCollideWith(&second) && !IsSoft(bodies.first) && !IsSoft(bodies.second))
      pairs_.push_back({bodies, 2 * kDeep});
  }
}

/// Carries the state of each pair over from the last cycle.
void PressWatch::Follow() {
  std::ranges::sort(pairs_, [](const Pair& a, const Pair& b) {
    return a.bodies != b.bodies ? a.bodies < b.bodies : a.depth > b.depth;
  });
  const auto repeated = std::ranges::unique(pairs_, {}, &Pair::bodies);
  pairs_.erase(repeated.begin(), repeated.end());
  for (Pair& pair : pairs_) {
    const auto before = std::ranges::lower_bound(last_, pair.bodies, {}, &Pair::bodies);
    const bool is_known = before != last_.end() && before->bodies == pair.bodies;
    const bool is_deep = pair.depth > kDeep;
    pair.cycles = is_known ? before->cycles + 1 : 1;
    pair.deep = is_deep ? (is_known ? before->deep + 1 : 1) : 0;
    pair.from_start = is_known ? before->from_start : cycle_ == 0;
    pair.by_impact =
        is_deep && (is_known && before->deep > 0 ? before->by_impact : pair.cycles <= kHoldsWithin);
  }
}

void PressWatch::FindLoads() {
  const double pull = engine_.acceleration().norm();
  if (!(pull > 0)) return;
  const Vector3d up = -engine_.acceleration() / pull;
  for (const btPersistentManifold& manifold : world::TouchingManifolds(engine_.world())) {
    const auto first = static_cast<std::uint32_t>(manifold.getBody0()->getUserIndex());
    const auto second = static_cast<std::uint32_t>(manifold.getBody1()->getUserIndex());
    if (!IsObject(first) || !IsObject(second)) continue;
    if (std::abs(world::ToEigen(manifold.getContactPoint(0).m_normalWorldOnB).dot(up)) < kUpright)
      continue;
    const Vector3d way = PositionOf(first) - PositionOf(second);
    const Load load = way.dot(up) > 0 ? Load{first, second} : Load{second, first};
    const double speed = world::ToEigen(engine_.objects()[first]->getLinearVelocity() -
                                        engine_.objects()[second]->getLinearVelocity())
                             .norm();
    if ((way - way.dot(up) * up).norm() > inner_[load.lower] ||
        speed > kSlow * std::sqrt(pull * contact_sides_.Least(first, second)))
      continue;
    loads_.try_emplace(std::minmax(first, second), load);
  }
}

std::int32_t PressWatch::CountInverted() const {
  const double pull = engine_.acceleration().norm();
  if (loads_.empty() || !(pull > 0)) return 0;
  const Vector3d up = -engine_.acceleration() / pull;
  return static_cast<std::int32_t>(
      std::ranges::count_if(loads_ | std::views::values, [&](const Load& load) {
        const Vector3d way = PositionOf(load.upper) - PositionOf(load.lower);
        const double height = way.dot(up);
        return height < 0 &&
               (way - height * up).norm() < std::max(inner_[load.upper], inner_[load.lower]);
      }));
}

namespace {

using objects::Shape;
using objects::Solid;

/// Thickness of a point, relative to the solid.
constexpr double kThin = 1e-6;

}  // namespace

bool Contains(const Solid& solid, const Vector3d& point) {
  if (!solid.compound)
    return objects::Visit(solid, [&](auto form) { return form.Contains(solid.sides, point); });
  if (point.norm() > solid.OuterRadius()) return false;
  const Solid dot{Shape::kEllipsoid, Vector3d::Constant(kThin * 2 * solid.LeastHalfExtent())};
  return objects::Overlap(solid, {}, dot, {point, Eigen::Quaterniond::Identity()});
}

}  // namespace cdb::probes
