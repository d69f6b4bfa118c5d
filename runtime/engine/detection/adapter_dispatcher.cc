#include "runtime/engine/detection/adapter_dispatcher.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <new>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

#include "dsl/text/check.h"
#include "runtime/engine/detection/kept_contacts.h"

namespace cdb::detection {
namespace {

constexpr double kUnit = 1e-3;           ///< a normal's length is off by no more
constexpr double kSizeTolerance = 1e-3;  ///< points and distance disagree by no more, in sizes
constexpr double kFarTolerance = 1e-6;   ///< and this part of the coordinates

/// Whose pair it is, in a field that Bullet sets to 0 with a new one and does not use. Of a
/// detector's pair, the sum of kDetector and its place among all that it is asked for, in cycles in
/// which that is looked for.
enum Owner { kNobody = 0, kBullet = 1, kDetector = 2 };

double SquaredNorm(const Vec3& v) { return v.x * v.x + v.y * v.y + v.z * v.z; }

double Greatest(const Vec3& v) {
  return std::max({std::fabs(v.x), std::fabs(v.y), std::fabs(v.z)});
}

bool IsFinite(const Contact& contact) {
  const auto is_finite = [](const Vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
  };
  return is_finite(contact.on_a) && is_finite(contact.on_b) && is_finite(contact.normal) &&
         std::isfinite(contact.distance);
}

KeptContacts* KeptOf(const btBroadphasePair& pair) {
  return static_cast<KeptContacts*>(pair.m_algorithm);
}

}  // namespace

AdapterDispatcher::AdapterDispatcher(btCollisionConfiguration* configuration,
                                     NamedDetector detector, SceneView& view)
    : btCollisionDispatcher(configuration), detector_(std::move(detector)), view_(view) {
  const Scene scene = view_.For(false);
  for (const Shape& shape : scene.shapes) sizes_.push_back(2 * Greatest(shape.half));
}

void AdapterDispatcher::Prepare() {
  try {
    detector_.detector->Prepare(view_.For(true));
  } catch (...) {
    Blame(detector_, "Prepare", view_.cycle());
  }
}

void AdapterDispatcher::dispatchAllCollisionPairs(btOverlappingPairCache* cache,
                                                  const btDispatcherInfo& info,
                                                  btDispatcher* /*dispatcher*/) {
  asked_.clear();
  places_.clear();
  contacts_.clear();
  cache_ = static_cast<OrderedPairCache*>(cache);
  cache_->ForEach(info.m_deterministicOverlappingPairs,
                  [&](const Pair& bodies, btBroadphasePair& pair) { Visit(bodies, pair, info); });
  try {
    Ask();
  } catch (...) {
    Blame(detector_, "FindContacts", view_.cycle());
  }
}

void AdapterDispatcher::Visit(const Pair& bodies, btBroadphasePair& pair,
                              const btDispatcherInfo& info) {
  if (pair.m_internalTmpValue == kNobody)
    pair.m_internalTmpValue = Handles(bodies) ? kDetector : kBullet;
  if (pair.m_internalTmpValue == kBullet) return getNearCallback()(pair, *this, info);
  const btCollisionObject &a = view_.body(bodies.a), &b = view_.body(bodies.b);
  if (!needsCollision(&a, &b)) return;
  if (pair.m_algorithm == nullptr && !info.m_deterministicOverlappingPairs) Make(pair);
  asked_.push_back(bodies);
  places_.push_back({&pair, 0, 0});
}

bool AdapterDispatcher::Handles(const Pair& bodies) {
  try {
    return detector_.detector->Handles(view_.For(true), bodies.a, bodies.b);
  } catch (...) {
    Blame(detector_, "Handles", view_.cycle());
  }
}

KeptContacts& AdapterDispatcher::Make(btBroadphasePair& pair) {
  const auto body = [](const btBroadphaseProxy* proxy) -> const btCollisionObject& {
    return *static_cast<const btCollisionObject*>(proxy->m_clientObject);
  };
  auto* kept = new (allocateCollisionAlgorithm(sizeof(KeptContacts)))
      KeptContacts(*this, body(pair.m_pProxy0), body(pair.m_pProxy1));
  pair.m_algorithm = kept;
  return *kept;
}

bool AdapterDispatcher::IsDetectors(const btBroadphasePair& pair) {
  return pair.m_internalTmpValue >= kDetector;
}

void AdapterDispatcher::Ask() {
  detector_.detector->FindContacts(view_.For(true), asked_, contacts_);
  AssignContacts();
  Keep();
}

/// Finds the pairs of the contacts. Contacts in another order than the pairs are sorted; those of a
/// pair keep their order.
void AdapterDispatcher::AssignContacts() {
  are_indexed_ = false;
  std::size_t place = 0;
  bool is_ordered = true;
  const auto to_count = [&](const Contact& contact) {
    const Pair pair = {contact.a, contact.b};
    const std::size_t last = place;
    if (!are_indexed_)
      while (place < asked_.size() && asked_[place] != pair) ++place;
    if (are_indexed_ || place == asked_.size()) place = Look(contact);
    is_ordered = is_ordered && place >= last;
    ++places_[place].count;
  };
  for (const Contact& contact : contacts_) to_count(contact);
  std::uint32_t first = 0;
  for (Place& of : places_) {
    of.first = first;
    first += of.count;
  }
  if (is_ordered) return;
  in_order_.resize(contacts_.size());
  for (const Contact& contact : contacts_) in_order_[places_[Look(contact)].first++] = contact;
  for (Place& of : places_) of.first -= of.count;
  contacts_.swap(in_order_);
}

/// The place of a contact's pair, wherever it is.
std::size_t AdapterDispatcher::Look(const Contact& contact) {
  if (!are_indexed_)
    for (std::size_t i = 0; i < places_.size(); ++i)
      places_[i].pair->m_internalTmpValue = kDetector + static_cast<int>(i);
  are_indexed_ = true;
  const Pair pair = {contact.a, contact.b};
  if (pair.a < pair.b && pair.b < view_.size()) {
    const btBroadphasePair* found = cache_->findPair(view_.body(pair.a).getBroadphaseHandle(),
                                                     view_.body(pair.b).getBroadphaseHandle());
    // A pair that was not given in this cycle may hold its place in an earlier one.
    if (found != nullptr && IsDetectors(*found))
      if (const auto place = static_cast<std::size_t>(found->m_internalTmpValue - kDetector);
          place < asked_.size() && asked_[place] == pair)
        return place;
  }
  throw std::invalid_argument(
      fmt::format("it returns a contact of the bodies {} and {}, a pair that it was not given",
                  contact.a, contact.b));
}

void AdapterDispatcher::Check(const Contact& contact) const {
  const auto refuse = [&](const std::string& what) {
    throw std::invalid_argument(
        fmt::format("the contact of the bodies {} and {} {}", contact.a, contact.b, what));
  };
  const Vec3 &on_a = contact.on_a, &on_b = contact.on_b, &normal = contact.normal;
  const double sum = on_a.x + on_a.y + on_a.z + on_b.x + on_b.y + on_b.z + normal.x + normal.y +
                     normal.z + contact.distance;
  if (!std::isfinite(sum) && !IsFinite(contact)) refuse("has a number that is not finite");
  const double square = SquaredNorm(normal);
  if (square < (1 - kUnit) * (1 - kUnit) || square > (1 + kUnit) * (1 + kUnit))
    refuse(fmt::format("has a normal of length {:.6g}; it must be 1", std::sqrt(square)));
  const double distance = contact.distance;
  const double apart =
      SquaredNorm({on_a.x - on_b.x - distance * normal.x, on_a.y - on_b.y - distance * normal.y,
                   on_a.z - on_b.z - distance * normal.z});
  const double tolerance = kSizeTolerance * std::min(sizes_[contact.a], sizes_[contact.b]) +
                           kFarTolerance * std::max(Greatest(on_a), Greatest(on_b));
  if (apart > tolerance * tolerance)
    refuse(
        fmt::format("contradicts itself by {:.3g} m: its point on the first body has to be that "
                    "on the second and the distance, {:.6g} m, times the normal, which points "
                    "from the second to the first",
                    std::sqrt(apart), distance));
}

void AdapterDispatcher::Keep() {
  for (const Place& place : places_) {
    if (place.pair->m_algorithm == nullptr && place.count == 0) continue;
    const std::span<const Contact> contacts =
        std::span(contacts_).subspan(place.first, place.count);
    for (const Contact& contact : contacts) Check(contact);
    KeptContacts& kept =
        place.pair->m_algorithm != nullptr ? *KeptOf(*place.pair) : Make(*place.pair);
    kept.Update(contacts, detector_.lists_all_points);
  }
}

}  // namespace cdb::detection
