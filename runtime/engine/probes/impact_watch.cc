#include "runtime/engine/probes/impact_watch.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <limits>

#include "runtime/engine/world/conversions.h"
#include "runtime/engine/world/manifolds.h"

namespace cdb::probes {
namespace {

using Eigen::Vector3d;
using exact::ImpactBody;

/// Of the largest sum of momenta so far, of more than two objects: counts as true impulses, so that
/// one impact of many objects is not the whole.
constexpr double kPrior = 0.1;
/// In which an impact may be completed: Bullet brings two close before they touch.
constexpr int kMostCycles = 12;
/// Of the true impulse: an impact with less is completed.
constexpr double kExact = 0.01;
/// Of the approach: an impact that leaves less is completed.
constexpr double kComplete = 0.1;
/// Bullet's shapes may be rounded, and touch later: the way in least sides, and in cycles.
constexpr double kRounded = 0.06, kMostLate = 50;
/// In cycles: further back, if they overlapped there.
constexpr double kFarthestBack = 4;
/// In cycles, beyond the one in which contacts are found.
constexpr double kForeseen = 2;
/// Of a cycle, in which further points may touch.
constexpr int kSteps = 32;
/// In which points that touch one after the other are followed.
constexpr int kCourseCycles = 4;
constexpr exact::Slip kSlipRules[] = {exact::Slip::kLeft, exact::Slip::kFirst};

auto KeyOf(const ImpactPair& pair) { return std::pair(pair.a, pair.b); }

ImpactPair Sorted(std::uint32_t a, std::uint32_t b) { return {std::min(a, b), std::max(a, b)}; }

}  // namespace

ImpactWatch::ImpactWatch(const plan::Scene& scene, world::Engine& engine,
                         const world::Coefficients& coefficients)
    : engine_(engine),
      bodies_(scene, engine, coefficients),
      touching_(engine.objects().size()),
      flights_(touching_.size(), 0) {}

ImpactWatch::Seen ImpactWatch::After(const BodyStates& before, const BodyStates& now,
                                     std::span<const Meeting> meetings) {
  ReadPairs();
  for (const Meeting& meeting : meetings_)
    if (!Find(pairs_, {meeting.a, meeting.b})) BeginUnfelt(meeting, before, now);
  std::erase_if(events_, [&](Event& event) { return !Continue(event, before, now); });
  for (const Pair& pair : pairs_)
    if (!Find(last_[0], pair) && !IsContinued(pair)) Begin(pair, before, now);
  meetings_.clear();
  std::ranges::copy_if(meetings, std::back_inserter(meetings_), [&](const Meeting& meeting) {
    return !Find(pairs_, {meeting.a, meeting.b});
  });
  std::ranges::rotate(last_, last_.end() - 1);
  last_[0].swap(pairs_);
  momentum_ = std::max(momentum_, bodies_.Momentum(now));
  return {Error(), unjudged_};
}

/// Grazes that were missed make the error of the others no smaller.
double ImpactWatch::Error() const {
  const double prior = kPrior * momentum_;
  double error =
      impulse_ > 0 ? error_ / (impulse_ + prior) : std::numeric_limits<double>::quiet_NaN();
  if (missed_ > 0)
    error = std::fmax(error, (error_ + missed_) / (impulse_ + missed_ + std::max(prior, graze_)));
  return error;
}

void ImpactWatch::ReadPairs() {
  found_.clear();
  for (const btPersistentManifold& manifold : world::TouchingManifolds(engine_.world())) {
    Vector3d impulse = Vector3d::Zero();
    bool pushes = false;
    for (int j = 0; j < manifold.getNumContacts(); ++j) {
      const btManifoldPoint& point = manifold.getContactPoint(j);
      if (!world::HasImpulse(manifold, point)) continue;
      pushes = true;
      impulse += world::ToEigen(point.m_appliedImpulse * point.m_normalWorldOnB +
                                world::FrictionImpulse(point));
    }
    if (!pushes) continue;
    const auto a = static_cast<std::uint32_t>(manifold.getBody0()->getUserIndex());
    const auto b = static_cast<std::uint32_t>(manifold.getBody1()->getUserIndex());
    found_.push_back(a < b ? Pair{{a, b}, impulse} : Pair{{b, a}, -impulse});
  }
  std::ranges::sort(found_, {}, KeyOf);
  // Compounds have a manifold for each pair of pieces.
  pairs_.clear();
  for (const Pair& pair : found_) {
    if (!pairs_.empty() && KeyOf(pairs_.back()) == KeyOf(pair))
      pairs_.back().impulse += pair.impulse;
    else
      pairs_.push_back(pair);
  }
  for (std::size_t i = 0; i < touching_.size(); ++i) {
    flights_[i] = touching_[i].empty() ? flights_[i] + 1 : 0;
    touching_[i].clear();
  }
  for (const Pair& pair : pairs_) {
    touching_[pair.a].push_back(pair.b);
    if (!bodies_.IsWall(pair.b)) touching_[pair.b].push_back(pair.a);
  }
}

const ImpactWatch::Pair* ImpactWatch::Find(const std::vector<Pair>& pairs, const ImpactPair& pair) {
  const auto found = std::ranges::lower_bound(pairs, KeyOf(pair), {}, KeyOf);
  return found != pairs.end() && KeyOf(*found) == KeyOf(pair) ? &*found : nullptr;
}

/// In the last cycles.
bool ImpactWatch::TouchedBefore(const ImpactPair& pair) const {
  return std::ranges::any_of(
      last_, [&](const std::vector<Pair>& pairs) { return Find(pairs, pair) != nullptr; });
}

/// Whether the impact of the pair was found before its first impulse, which is in this cycle.
bool ImpactWatch::IsContinued(const ImpactPair& pair) const {
  return std::ranges::any_of(events_, [&](const Event& event) {
    return event.is_felt && event.cycles == 1 && KeyOf(event.pair) == KeyOf(pair);
  });
}

bool ImpactWatch::AnyThird(const ImpactPair& pair, auto visit) const {
  for (const std::uint32_t self : {pair.a, pair.b}) {
    if (!bodies_.IsFree(self)) continue;
    for (const std::uint32_t third : touching_[self])
      if (third != pair.a && third != pair.b && visit(self, third)) return true;
  }
  return false;
}

/// Along the velocities.
std::optional<exact::Touch> ImpactWatch::FindTouch(const ImpactPair& pair,
                                                   const BodyStates& before) const {
  const exact::Collider a = bodies_.ColliderOf(pair.a, before),
                        b = bodies_.ColliderOf(pair.b, before);
  const double rate = (a.motion.way - b.motion.way).norm();
  const double back = std::min(kMostLate, 1 + kRounded * bodies_.LeastSide(pair) / rate);
  auto touch = exact::FindTouch(*a.solid, a.motion, b, -back, kForeseen);
  const auto has_flown = [&](std::uint32_t body) {
    return !bodies_.IsFree(body) || flights_[body] >= kFarthestBack;
  };
  if (!touch && back < kFarthestBack && has_flown(pair.a) && has_flown(pair.b) &&
      bodies_.Overlap(pair, -back, before))
    touch = exact::FindTouch(*a.solid, a.motion, b, -kFarthestBack, kForeseen);
  return touch;
}

void ImpactWatch::Begin(const Pair& pair, const BodyStates& before, const BodyStates& now) {
  const Judged judged = bodies_.JudgedOf(pair);
  const double least = bodies_.LeastApproach(pair);
  if (judged == Judged::kNot || !bodies_.AreFinite(pair, before) ||
      bodies_.MostApproach(pair, before) < least)
    return;
  const auto touch = FindTouch(pair, before);
  if (!touch) {
    const exact::Touch felt{0, pair.impulse.normalized(), bodies_.Distance(pair, before).on_a};
    unjudged_ += bodies_.ApproachAt(pair, felt, felt.point, before) >= least;
    return;
  }
  if (bodies_.ApproachAt(pair, *touch, touch->point, before) < least) return;
  if (touch->part < 0 && !bodies_.IsRound(pair) && bodies_.LeavesAnotherWay(pair, *touch, before)) {
    ++unjudged_;
    return;
  }
  const bool is_crowded =
      AnyThird(pair, [&](std::uint32_t, std::uint32_t third) { return bodies_.IsFree(third); });
  if (judged == Judged::kWhole && !is_crowded) {
    if (auto event = MakeEvent(pair, *touch, before, now)) {
      Compare(*event, now);
      if (event->error <= kExact * event->impulse)
        Count(event->error, event->impulse);
      else
        events_.push_back(*std::move(event));
      return;
    }
    ++unjudged_;
  }
  CompareDirection(pair, touch->normal);
}

void ImpactWatch::CompareDirection(const Pair& pair, const Vector3d& normal) {
  const double friction = bodies_.Friction(pair), press = pair.impulse.dot(normal);
  const double across = (pair.impulse - press * normal).norm();
  const double outside = (across - friction * press) / std::sqrt(1 + friction * friction);
  Count(std::clamp(outside, 0.0, pair.impulse.norm()), pair.impulse.norm());
}

/// A pair without an impulse in this cycle, in which it has come to where the meeting ended.
void ImpactWatch::BeginUnfelt(const Meeting& meeting, const BodyStates& before,
                              const BodyStates& now) {
  const ImpactPair pair{meeting.a, meeting.b};
  if (bodies_.JudgedOf(pair) == Judged::kNot || !bodies_.AreFinite(pair, before)) return;
  exact::Collider other = bodies_.ColliderOf(pair.b, before);
  other.motion = meeting.motion_b;
  auto touch =
      exact::FindTouch(*bodies_.ColliderOf(pair.a, before).solid, meeting.motion_a, other, 0, 1);
  if (!touch) return;
  const exact::Touch in_meeting = *touch;
  touch->part -= 1;  // from its end
  if (bodies_.ApproachAt(pair, *touch, touch->point, before) < bodies_.LeastApproach(pair)) return;
  // An impulse of another body may come first.
  const bool is_disturbed = AnyThird(pair, [&](std::uint32_t self, std::uint32_t third) {
    return bodies_.IsFree(third) || !Find(last_[0], Sorted(self, third));
  });
  // After an impact that was found late, they are not where they should be.
  std::optional<Event> event;
  if (!is_disturbed && !TouchedBefore(pair) && !bodies_.IsLinked(pair) &&
      (bodies_.IsRound(pair) || !bodies_.SlidesAcross(meeting, in_meeting)))
    event = MakeEvent(pair, *touch, before, now);
  if (!event) {
    ++unjudged_;
    return;
  }
  event->is_felt = false;
  events_.push_back(*std::move(event));
}

/// None if a support cannot be judged, or points touch one after the other while others support
/// the bodies.
std::optional<ImpactWatch::Event> ImpactWatch::MakeEvent(const ImpactPair& pair,
                                                         const exact::Touch& touch,
                                                         const BodyStates& before,
                                                         const BodyStates& now) const {
  Event event;
  event.pair = pair;
  event.judged = bodies_.JudgedOf(pair);
  // Contacts are those of the touch; bodies have moved there.
  for (const std::uint32_t body : {pair.a, pair.b}) {
    event.first.push_back(bodies_.StateOf(body, before));
    event.first.back().centre += touch.part * bodies_.timestep() * event.first.back().velocity;
  }
  ImpactBodies::Points points{{touch.point}};
  if (event.judged == Judged::kWhole) {
    points = bodies_.PointsOf(pair, touch, before);
    event.is_at_once = points.are_at_once;
    for (const exact::Slip slip : kSlipRules) {
      if (!points.are_in_turn) break;
      event.courses.push_back(bodies_.CourseOf(pair, touch.part, slip, before));
      event.courses.back().Advance(-touch.part * bodies_.timestep(),
                                   static_cast<int>(std::ceil(-touch.part * kSteps)));
    }
  }
  for (const Vector3d& point : points.points)
    event.contacts.push_back({0, 1, touch.normal, point, bodies_.Friction(pair),
                              bodies_.Restitution(pair) *
                                  std::max(0.0, bodies_.ApproachAt(pair, touch, point, before))});
  const bool is_unknown = AnyThird(pair, [&](std::uint32_t self, std::uint32_t ground) {
    event.courses.clear();
    return !event.is_at_once || !AddSupport(event, self, ground, before, now);
  });
  if (is_unknown) return std::nullopt;
  return event;
}

bool ImpactWatch::AddSupport(Event& event, std::uint32_t object, std::uint32_t ground,
                             const BodyStates& before, const BodyStates& now) const {
  const ImpactPair pair{object, ground};
  if (!bodies_.IsWall(ground) && bodies_.JudgedOf({ground, ground}) != Judged::kWhole) return false;
  const exact::SignedDistance distance = bodies_.Distance(pair, before);
  const exact::Touch touch{0, distance.normal, (distance.on_a + distance.on_b) / 2};
  const std::size_t self = object == event.pair.a ? 0 : 1, index = 2 + event.supports.size();
  event.supports.push_back(ground);
  const ImpactBody a = bodies_.StateOf(object, before), b = bodies_.StateOf(ground, now);
  // The velocities of later cycles are not those of the true impact.
  const double restitution = event.cycles == 0 ? bodies_.Restitution(pair) : 0,
               least = bodies_.LeastApproach(pair);
  for (const Vector3d& point : bodies_.RestingPoints(pair, touch, before)) {
    const double approach =
        -(exact::VelocityAt(a, point) - exact::VelocityAt(b, point)).dot(touch.normal);
    event.contacts.push_back({self, index, touch.normal, point, bodies_.Friction(pair),
                              approach > least ? restitution * approach : 0});
  }
  return true;
}

/// Returns false if it is over.
bool ImpactWatch::Continue(Event& event, const BodyStates& before, const BodyStates& now) {
  const Pair* felt = Find(pairs_, event.pair);
  if (!event.is_felt) {
    if (felt == nullptr) return Wait(event, before, now);
    event.is_felt = true;
    event.cycles = 0;
    if (event.judged != Judged::kWhole) {
      CompareDirection(*felt, event.contacts[0].normal);
      return false;
    }
  }
  if ((felt != nullptr || !event.is_complete) && event.cycles < kMostCycles) {
    const bool is_interrupted = AnyThird(event.pair, [&](std::uint32_t self, std::uint32_t other) {
      return std::ranges::find(event.supports, other) == event.supports.end() &&
             (bodies_.IsFree(other) || !event.courses.empty() ||
              !AddSupport(event, self, other, before, now));
    });
    if (!is_interrupted) {
      Compare(event, now);
      if (event.error > kExact * event.impulse) return true;
    } else if (!event.is_complete) {
      ++unjudged_;
      return false;
    }
  }
  Count(event.error, event.impulse);
  return false;
}

/// Call in a cycle without an impulse. Returns false if it is over.
bool ImpactWatch::Wait(Event& event, const BodyStates& before, const BodyStates& now) {
  const bool is_disturbed = AnyThird(event.pair, [&](std::uint32_t, std::uint32_t other) {
    return std::ranges::find(event.supports, other) == event.supports.end();
  });
  if (is_disturbed || event.cycles > kMostLate || !bodies_.AreFinite(event.pair, before)) {
    ++unjudged_;
    return false;
  }
  const bool overlaps = bodies_.Distance(event.pair, before).gap < 0;
  if (overlaps || !event.courses.empty()) Advance(event, now);
  if (!overlaps) CountMissed(event, now);
  return overlaps;
}

void ImpactWatch::CountMissed(const Event& event, const BodyStates& now) {
  const Vector3d& point = event.contacts[0].point;
  const Vector3d approach =
      exact::VelocityAt(event.first[0], point) - exact::VelocityAt(event.first[1], point);
  ImpactBodies::Change least{};
  for (const std::vector<ImpactBody>& end : EndsOf(event, now)) {
    const auto change = bodies_.ChangeOf(event.pair, event.first, end, now);
    if (!(least.inverse_mass > 0) || change.impulse < least.impulse) least = change;
  }
  missed_ += least.impulse;
  graze_ = std::max(graze_, approach.norm() / least.inverse_mass - least.impulse);
}

/// The states of the pair that may follow.
std::vector<std::vector<ImpactBody>> ImpactWatch::EndsOf(const Event& event,
                                                         const BodyStates& now) const {
  std::vector<std::vector<ImpactBody>> ends;
  for (const exact::ImpactCourse& course : event.courses) ends.push_back({course.a(), course.b()});
  for (const exact::Slip slip : kSlipRules) {
    if (!event.is_at_once) break;
    std::vector<ImpactBody> bodies = event.first;
    for (const std::uint32_t support : event.supports)
      bodies.push_back(bodies_.StateOf(support, now));
    exact::SolveImpact(bodies, event.contacts, slip);
    ends.push_back(std::move(bodies));
  }
  return ends;
}

/// By a cycle.
void ImpactWatch::Advance(Event& event, const BodyStates& now) const {
  ++event.cycles;
  for (const std::uint32_t body : {event.pair.a, event.pair.b}) {
    ImpactBody& first = event.first[body == event.pair.a ? 0 : 1];
    first = bodies_.IsFree(body) ? bodies_.Pulled(body, first) : bodies_.StateOf(body, now);
  }
  for (exact::ImpactCourse& course : event.courses) course.Advance(bodies_.timestep(), kSteps);
}

void ImpactWatch::Compare(Event& event, const BodyStates& now) const {
  Advance(event, now);
  const std::vector<ImpactBody> real = {bodies_.StateOf(event.pair.a, now),
                                        bodies_.StateOf(event.pair.b, now)};
  bool is_first = event.cycles == 1;
  for (const std::vector<ImpactBody>& end : EndsOf(event, now)) {
    const double error = bodies_.ChangeOf(event.pair, real, end, now).impulse,
                 change = bodies_.ChangeOf(event.pair, event.first, end, now).impulse;
    if (is_first || error * event.impulse < event.error * change) {
      event.error = error;
      event.impulse = change;
    }
    is_first = false;
  }
  const auto leaving = [](const std::vector<ImpactBody>& bodies,
                          const exact::ImpactContact& contact) {
    return (exact::VelocityAt(bodies[0], contact.point) -
            exact::VelocityAt(bodies[1], contact.point))
        .dot(contact.normal);
  };
  event.is_complete =
      event.courses.empty()
          ? std::ranges::none_of(event.contacts,
                                 [&](const exact::ImpactContact& contact) {
                                   return contact.a == 0 && contact.b == 1 &&
                                          leaving(real, contact) <
                                              kComplete * leaving(event.first, contact);
                                 })
          : event.cycles >= kCourseCycles;
}

void ImpactWatch::Count(double error, double impulse) {
  error_ += error;
  impulse_ += impulse;
}

}  // namespace cdb::probes
