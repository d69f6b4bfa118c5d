#include "runtime/engine/detection/adapter_dispatcher.h"

#include <fmt/format.h>

#include <cmath>
#include <new>
#include <span>
#include <stdexcept>
#include <string>
#include <utility>

#include "runtime/engine/detection/kept_contacts.h"

namespace cdb::detection {
namespace {

constexpr double kUnit = 1e-3;           ///< a normal's length is off by no more
constexpr double kSizeTolerance = 1e-3;  ///< points and distance disagree by no more, in sizes
constexpr double kFarTolerance = 1e-6;   ///< and this part of the coordinates

/// ns, about: of a pair whose contacts are kept, and of one that is visited.
constexpr double kWorkOfPair = 40, kWorkOfVisit = 20;

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

/// By how much the first point is not where it should be from the second.
Vec3 Contradiction(const Contact& contact) {
  const Vec3 &a = contact.on_a, &b = contact.on_b, &normal = contact.normal;
  const double distance = contact.distance;
  return {a.x - b.x - distance * normal.x, a.y - b.y - distance * normal.y,
          a.z - b.z - distance * normal.z};
}

/// Passes nothing that AdapterDispatcher::Check refuses, and nearly all else. Numbers that are not
/// finite fail one of the comparisons.
bool IsSound(const Contact& contact, double tolerance) {
  return std::fabs(SquaredNorm(contact.normal) - 1) < kUnit &&
         SquaredNorm(Contradiction(contact)) <= tolerance * tolerance;
}

/// As btCollisionDispatcher::needsCollision, inline.
bool NeedCollision(const btCollisionObject& a, const btCollisionObject& b) {
  return (a.isActive() || b.isActive()) && a.checkCollideWith(&b) && b.checkCollideWith(&a);
}

}  // namespace

AdapterDispatcher::AdapterDispatcher(btCollisionConfiguration* configuration,
                                     NamedDetector detector, SceneView& view)
    : btCollisionDispatcher(configuration),
      detector_(std::move(detector)),
      view_(view),
      parts_(detector_.lists_all_points ? detector_.threads : 1),
      visited_(parts_.most()),
      asked_(visited_[0].asked),
      places_(visited_[0].places) {
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
  contacts_.clear();
  cache_ = static_cast<OrderedPairCache*>(cache);
  VisitAll(info);
  try {
    Ask();
  } catch (...) {
    Blame(detector_, "FindContacts", view_.cycle());
  }
}

/// Bullet's pairs are solved in the order in which they and, if pairs are listed, those of the
/// detector are visited.
void AdapterDispatcher::VisitAll(const btDispatcherInfo& info) {
  for (Visited& part : visited_) part.Clear();
  const bool is_sorted = info.m_deterministicOverlappingPairs;
  const Scene scene = view_.For(true);
  const double work = kWorkOfVisit * static_cast<double>(cache_->getNumOverlappingPairs());
  const kernels::ThreadPool::Session session = parts_.Begin(work);
  Visited& first = visited_[0];
  if (!is_sorted || parts_.most() == 1) {
    cache_->ForEach(is_sorted, [&](const Pair& bodies, btBroadphasePair& pair) {
      Visit(scene, bodies, pair, info, first);
      for (; !first.for_bullet.empty(); first.for_bullet.pop_back())
        getNearCallback()(*first.for_bullet.back(), *this, info);
    });
    return;
  }
  // The pairs of later bodies come first.
  const std::size_t size = view_.size();
  const unsigned parts =
      parts_.ForEach(work, 0, size, 1, [&](unsigned part, std::size_t from, std::size_t to) {
        Visited& own = visited_[part];
        cache_->ForEachFrom(size - to, size - from,
                            [&](const Pair& bodies, btBroadphasePair& pair) {
                              Visit(scene, bodies, pair, info, own);
                            });
      });
  for (unsigned part = 0; part < parts; ++part) {
    const Visited& own = visited_[part];
    for (btBroadphasePair* pair : own.for_bullet) getNearCallback()(*pair, *this, info);
    if (part == 0) continue;
    first.asked.insert(first.asked.end(), own.asked.begin(), own.asked.end());
    first.places.insert(first.places.end(), own.places.begin(), own.places.end());
  }
}

void AdapterDispatcher::Visit(const Scene& scene, const Pair& bodies, btBroadphasePair& pair,
                              const btDispatcherInfo& info, Visited& to) {
  if (pair.m_internalTmpValue == kNobody)
    pair.m_internalTmpValue = Handles(scene, bodies) ? kDetector : kBullet;
  if (pair.m_internalTmpValue == kBullet) return to.for_bullet.push_back(&pair);
  if (!NeedCollision(view_.body(bodies.a), view_.body(bodies.b))) return;
  if (pair.m_algorithm == nullptr && !info.m_deterministicOverlappingPairs) Make(pair);
  to.asked.push_back(bodies);
  to.places.push_back({&pair, pair.m_algorithm, 0, 0});
}

bool AdapterDispatcher::Handles(const Scene& scene, const Pair& bodies) {
  try {
    return detector_.detector->Handles(scene, bodies.a, bodies.b);
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

/// Finds the contacts of each pair. Those in another order than the pairs are sorted first; those
/// of a pair keep their order.
void AdapterDispatcher::AssignContacts() {
  if (AreInOrder()) return;
  are_indexed_ = false;
  for (Place& place : places_) place.count = 0;
  for (const Contact& contact : contacts_) ++places_[Look(contact)].count;
  std::uint32_t first = 0;
  for (Place& place : places_) {
    place.first = first;
    first += place.count;
  }
  in_order_.resize(contacts_.size());
  for (const Contact& contact : contacts_) in_order_[places_[Look(contact)].first++] = contact;
  for (Place& place : places_) place.first -= place.count;
  contacts_.swap(in_order_);
}

/// Finds the contacts of each pair if they are in the order of the pairs, as most detectors list
/// them.
bool AdapterDispatcher::AreInOrder() {
  std::size_t next = 0;
  for (std::size_t i = 0; i < asked_.size(); ++i) {
    const std::size_t first = next;
    while (next < contacts_.size() && asked_[i] == Pair{contacts_[next].a, contacts_[next].b})
      ++next;
    places_[i].first = static_cast<std::uint32_t>(first);
    places_[i].count = static_cast<std::uint32_t>(next - first);
  }
  return next == contacts_.size();
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
  if (!IsFinite(contact)) refuse("has a number that is not finite");
  const double length = std::sqrt(SquaredNorm(contact.normal));
  if (std::fabs(length - 1) > kUnit)
    refuse(fmt::format("has a normal of length {:.6g}; it must be 1", length));
  const double apart = std::sqrt(SquaredNorm(Contradiction(contact)));
  const double tolerance = kSizeTolerance * SmallerSize(contact) +
                           kFarTolerance * std::max(Greatest(contact.on_a), Greatest(contact.on_b));
  if (apart > tolerance)
    refuse(
        fmt::format("contradicts itself by {:.3g} m: its point on the first body has to be that "
                    "on the second and the distance, {:.6g} m, times the normal, which points "
                    "from the second to the first",
                    apart, contact.distance));
}

void AdapterDispatcher::Keep() {
  for (Place& place : places_)
    if (place.kept == nullptr && place.count > 0) place.kept = &Make(*place.pair);
  const double work = kWorkOfPair * static_cast<double>(places_.size());
  const kernels::ThreadPool::Session session = parts_.Begin(work);
  parts_.ForEach(work, 0, places_.size(), 1, [&](unsigned, std::size_t from, std::size_t to) {
    for (const Place& place : std::span(places_).subspan(from, to - from)) KeepOf(place);
  });
}

void AdapterDispatcher::KeepOf(const Place& place) {
  if (place.kept == nullptr) return;
  const std::span<const Contact> contacts = std::span(contacts_).subspan(place.first, place.count);
  for (const Contact& contact : contacts)
    if (!IsSound(contact, kSizeTolerance * SmallerSize(contact))) Check(contact);
  static_cast<KeptContacts*>(place.kept)->Update(contacts, detector_.lists_all_points);
}

}  // namespace cdb::detection
