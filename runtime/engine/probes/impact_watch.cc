#include "runtime/engine/probes/impact_watch.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <limits>

#include "compiler/analysis/expectation.h"
#include "runtime/engine/world/conversions.h"
#include "runtime/engine/world/manifolds.h"

namespace cdb::probes {
namespace {

using Eigen::Vector3d;
using exact::ImpactBody;

/// An approach by more than such a fall, in least sides, and by so many falls in a cycle.
constexpr double kImpactFall = 0.05, kImpactFalls = 4;
/// 1/s: without gravity, of the least side.
constexpr double kImpactRate = 0.1;
/// Of the largest sum of momenta so far, of more than two objects: counts as true impulses, so that
/// one impact of many objects is not the whole.
constexpr double kPrior = 0.1;
/// In which an impact may be completed: Bullet brings two close before they touch.
constexpr int kMostCycles = 12;
/// Of the true impulse: an impact with less is completed.
constexpr double kExact = 0.01;
/// Of the approach: an impact that leaves less is completed.
constexpr double kComplete = 0.1;
/// Of a cycle: further points that follow within this time touch at once; points that follow later,
/// but within the other, are another impact, which the first one changes.
constexpr double kAtOnce = 0.25, kAmbiguous = 4;
/// rad: at most, between faces of which all points touch at once; of which any do; at rest.
constexpr double kParallel = 0.02, kMostTilt = 0.5, kNearlyParallel = 0.05;
/// Regions of contact, in least half extents and relative to each other.
constexpr double kPoint = 0.1, kSameRegion = 0.2;
/// In least sides: contacts at rest are as deep. Where the shortest way out of one has another
/// direction (a cosine) than the touch, it is not known which counts.
constexpr double kShallow = 0.05, kOtherWay = 0.9;
/// Bullet's shapes may be rounded, and touch later by a way of so many least sides; in cycles.
constexpr double kRounded = 0.06, kMostLate = 50;
/// In cycles, beyond the one in which contacts are found.
constexpr double kForeseen = 2;
/// Of a cycle, in which it is seen how two part; and in which further points may touch.
constexpr int kSamples = 4, kSteps = 32;
/// In which points that touch one after the other are followed.
constexpr int kCourseCycles = 4;
constexpr exact::Slip kSlipRules[] = {exact::Slip::kLeft, exact::Slip::kFirst};

double Diameter(const std::vector<Vector3d>& points) {
  double most = 0;
  for (const Vector3d& a : points)
    for (const Vector3d& b : points) most = std::max(most, (a - b).norm());
  return most;
}

/// m: of a point of one set from the nearest of another, at most.
double Farthest(const std::vector<Vector3d>& points, const std::vector<Vector3d>& others) {
  double most = 0;
  for (const Vector3d& point : points) {
    double least = std::numeric_limits<double>::infinity();
    for (const Vector3d& other : others) least = std::min(least, (point - other).norm());
    most = std::max(most, least);
  }
  return most;
}

bool IsFinite(const BodyState& state) {
  return world::IsFinite(state.pose.getOrigin()) && world::IsFinite(state.velocity) &&
         world::IsFinite(state.spin);
}

}  // namespace

ImpactWatch::ImpactWatch(const plan::Scene& scene, world::Engine& engine)
    : engine_(engine),
      wall_restitution_(scene.world.Real("world.wall_restitution")),
      wall_friction_(scene.world.Real("world.wall_friction")),
      timestep_(static_cast<double>(engine.timestep())),
      touching_(engine.objects().size()) {
  std::vector<char> linked(touching_.size(), 0);
  engine.links().MarkHeld(linked, 1);
  for (std::size_t i = 0; i < touching_.size(); ++i) {
    const layouts::ObjectState& state = engine.initial_state().objects[i];
    const btRigidBody& body = *engine.objects()[i];
    Judged judged = Judged::kWhole;
    if (state.solid.compound || linked[i] != 0 || state.numbers["rolling_friction"] > 0 ||
        state.numbers["spinning_friction"] > 0)
      judged = Judged::kCone;
    const plan::Group& group = scene.groups[state.group];
    if (analysis::HasSchedule(group) && !state.is_kinematic) judged = Judged::kNot;
    if (state.solid.IsSurface() || std::isfinite(state.numbers["contact_stiffness"]))
      judged = Judged::kNot;
    bodies_.push_back({state.mass, state.mass * state.solid.InertiaPerMass(),
                       std::pow(1 - static_cast<double>(body.getLinearDamping()), timestep_),
                       std::pow(1 - static_cast<double>(body.getAngularDamping()), timestep_),
                       state.numbers["friction"], state.numbers["restitution"],
                       2 * state.solid.LeastHalfExtent(), judged, linked[i] != 0});
  }
}

ImpactWatch::Seen ImpactWatch::After(const BodyStates& before, const BodyStates& now,
                                     std::span<const Meeting> meetings) {
  ReadPairs();
  for (const Meeting& meeting : meetings_)
    if (!Contains(pairs_, {meeting.a, meeting.b})) BeginUnfelt(meeting, before, now);
  std::erase_if(events_, [&](Event& event) { return !Continue(event, before, now); });
  for (const Pair& pair : pairs_)
    if (!Contains(last_, pair) && !IsContinued(pair)) Begin(pair, before, now);
  meetings_.clear();
  std::ranges::copy_if(meetings, std::back_inserter(meetings_), [&](const Meeting& meeting) {
    return !Contains(pairs_, {meeting.a, meeting.b});
  });
  pairs_.swap(last_);
  double momentum = 0, moving = 0;
  for (std::size_t i = 0; i < bodies_.size(); ++i) {
    momentum += bodies_[i].mass * world::ToEigen(now[i].velocity).norm();
    moving += bodies_[i].mass > 0;
  }
  momentum *= std::max(0.0, 1 - 2 / moving);
  momentum_ = std::max(momentum_, momentum);
  return {Error(), unjudged_};
}

/// Grazes that were missed make the error of the others no smaller.
double ImpactWatch::Error() const {
  const double prior = kPrior * momentum_;
  double error =
      impulse_ > 0 ? error_ / (impulse_ + prior) : std::numeric_limits<double>::quiet_NaN();
  if (missed_ > 0)
    error = std::fmax(error,
                      (error_ + missed_) / (impulse_ + missed_ + std::max(prior, graze_)));
  return error;
}

void ImpactWatch::ReadPairs() {
  pairs_.clear();
  for (const btPersistentManifold& manifold : world::TouchingManifolds(engine_.world())) {
    Vector3d impulse = Vector3d::Zero();
    bool pushes = false;
    for (int j = 0; j < manifold.getNumContacts(); ++j) {
      const btManifoldPoint& point = manifold.getContactPoint(j);
      if (!world::HasImpulse(manifold, point)) continue;
      pushes = true;
      impulse += world::ToEigen(point.m_appliedImpulse * point.m_normalWorldOnB +
                                point.m_appliedImpulseLateral1 * point.m_lateralFrictionDir1);
    }
    if (!pushes) continue;
    const auto a = static_cast<std::uint32_t>(manifold.getBody0()->getUserIndex());
    const auto b = static_cast<std::uint32_t>(manifold.getBody1()->getUserIndex());
    pairs_.push_back(a < b ? Pair{a, b, impulse} : Pair{b, a, -impulse});
  }
  const auto key = [](const Pair& pair) { return std::pair(pair.a, pair.b); };
  std::ranges::sort(pairs_, {}, key);
  auto kept = pairs_.begin();
  for (auto pair = pairs_.begin(); pair != pairs_.end(); ++pair) {
    if (kept != pair && key(*kept) == key(*pair)) {
      kept->impulse += pair->impulse;
    } else {
      if (pair != pairs_.begin()) ++kept;
      *kept = *pair;
    }
  }
  if (!pairs_.empty()) pairs_.erase(kept + 1, pairs_.end());
  for (auto& others : touching_) others.clear();
  for (const Pair& pair : pairs_) {
    touching_[pair.a].push_back(pair.b);
    if (!IsWall(pair.b)) touching_[pair.b].push_back(pair.a);
  }
}

bool ImpactWatch::Contains(const std::vector<Pair>& pairs, const Pair& pair) {
  const auto key = [](const Pair& each) { return std::pair(each.a, each.b); };
  return std::ranges::binary_search(pairs, key(pair), {}, key);
}

/// Whether the impact of the pair was found before its first impulse, which is in this cycle.
bool ImpactWatch::IsContinued(const Pair& pair) const {
  return std::ranges::any_of(events_, [&](const Event& event) {
    return event.is_felt && event.cycles == 1 && event.bodies[0] == pair.a &&
           event.bodies[1] == pair.b;
  });
}

/// m: of the smaller one.
double ImpactWatch::LeastSide(const Pair& pair) const {
  const double side = bodies_[pair.a].least_side;
  return IsWall(pair.b) ? side : std::min(side, bodies_[pair.b].least_side);
}

/// m/s.
double ImpactWatch::LeastApproach(const Pair& pair) const {
  const double side = LeastSide(pair);
  const double pull = engine_.acceleration().norm();
  return std::max({std::sqrt(2 * pull * kImpactFall * side), kImpactFalls * pull * timestep_,
                   kImpactRate * side});
}

ImpactWatch::Judged ImpactWatch::JudgedOf(const Pair& pair) const {
  const Judged judged = bodies_[pair.a].judged;
  return IsWall(pair.b) ? judged : std::min(judged, bodies_[pair.b].judged);
}

void ImpactWatch::Begin(const Pair& pair, const BodyStates& before, const BodyStates& now) {
  const Judged judged = JudgedOf(pair);
  if (judged == Judged::kNot || !IsFinite(before[pair.a])) return;
  if (!IsWall(pair.b) && !IsFinite(before[pair.b])) return;
  const ImpactBody a = BodyOf(pair.a, before), b = BodyOf(pair.b, before);
  const double least = LeastApproach(pair);
  const auto surface_speed = [&](std::uint32_t object, const ImpactBody& state) {
    return IsWall(object)
               ? 0
               : state.spin.norm() * engine_.initial_state().objects[object].solid.OuterRadius();
  };
  if ((a.velocity - b.velocity).norm() + surface_speed(pair.a, a) + surface_speed(pair.b, b) <
      least)
    return;
  const objects::Solid& solid = engine_.initial_state().objects[pair.a].solid;
  const exact::Motion motion = ColliderOf(pair.a, before).motion;
  const exact::Collider other = ColliderOf(pair.b, before);
  const double side = LeastSide(pair);
  const double rate = (motion.way - other.motion.way).norm();
  const double from = -std::min(kMostLate, 1 + kRounded * side / rate);
  const auto touch = exact::FindTouch(solid, motion, other, from, kForeseen);
  if (!touch || ApproachAt(pair, *touch, touch->point, before) < least) return;
  if (touch->part < 0 && !IsRound(pair) && LeavesAnotherWay(pair, *touch, before)) {
    ++unjudged_;
    return;
  }
  if (judged == Judged::kWhole && !TouchesFreeThird(pair)) {
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
  const double friction = FrictionOf(pair.a, pair.b), press = pair.impulse.dot(normal);
  const double across = (pair.impulse - press * normal).norm();
  const double outside = (across - friction * press) / std::sqrt(1 + friction * friction);
  Count(std::clamp(outside, 0.0, pair.impulse.norm()), pair.impulse.norm());
}

/// A pair without an impulse in this cycle, in which it has come to where the meeting ended.
void ImpactWatch::BeginUnfelt(const Meeting& meeting, const BodyStates& before,
                              const BodyStates& now) {
  const Pair pair{meeting.a, meeting.b};
  const Judged judged = JudgedOf(pair);
  if (judged == Judged::kNot || !IsFinite(before[pair.a])) return;
  if (!IsWall(pair.b) && !IsFinite(before[pair.b])) return;
  exact::Collider other = ColliderOf(pair.b, before);
  other.motion = meeting.motion_b;
  const objects::Solid& solid = engine_.initial_state().objects[pair.a].solid;
  auto touch = exact::FindTouch(solid, meeting.motion_a, other, 0, 1);
  if (!touch) return;
  const bool slides = !IsRound(pair) && SlidesAcross(meeting, *touch);
  touch->part -= 1;  // to the end of the meeting
  if (ApproachAt(pair, *touch, touch->point, before) < LeastApproach(pair)) return;
  // An impulse of another body comes before or after.
  const auto is_new = [&](std::uint32_t self, std::uint32_t third) {
    return !Contains(last_, self < third ? Pair{self, third} : Pair{third, self});
  };
  const auto is_pushed = [&](std::uint32_t self) {
    return IsFree(self) && std::ranges::any_of(touching_[self], [&](std::uint32_t third) {
             return IsFree(third) || is_new(self, third);
           });
  };
  std::optional<Event> event;
  if (!slides && !is_pushed(pair.a) && !is_pushed(pair.b) && !bodies_[pair.a].is_linked &&
      (IsWall(pair.b) || !bodies_[pair.b].is_linked)) {
    event = MakeEvent(pair, *touch, before, now);
  }
  if (!event) {
    ++unjudged_;
    return;
  }
  event->is_felt = false;
  events_.push_back(*std::move(event));
}

/// Call in a cycle without an impulse. Returns false if it is over.
bool ImpactWatch::Wait(Event& event, const BodyStates& before, const BodyStates& now) {
  const Pair pair{event.bodies[0], event.bodies[1]};
  const bool is_pushed = std::ranges::any_of(std::array{pair.a, pair.b}, [&](std::uint32_t self) {
    return IsFree(self) && std::ranges::any_of(touching_[self], [&](std::uint32_t other) {
             return std::ranges::find(event.bodies, other) == event.bodies.end();
           });
  });
  if (is_pushed || event.cycles > kMostLate || !IsFinite(before[pair.a]) ||
      (!IsWall(pair.b) && !IsFinite(before[pair.b]))) {
    ++unjudged_;
    return false;
  }
  const bool overlaps = DistanceBefore(pair, before).gap < 0;
  if (overlaps || !event.courses.empty()) Advance(event, now);
  if (!overlaps) CountMissed(event, now);
  return overlaps;
}

void ImpactWatch::CountMissed(const Event& event, const BodyStates& now) {
  const Vector3d& point = event.contacts[0].point;
  const Vector3d approach =
      exact::VelocityAt(event.first[0], point) - exact::VelocityAt(event.first[1], point);
  const Change change =
      ChangeOf(event, AfterImpact(event, exact::Slip::kLeft, now), event.first, now);
  missed_ += change.impulse;
  graze_ = std::max(graze_, approach.norm() / change.inverse_mass - change.impulse);
}

bool ImpactWatch::TouchesFreeThird(const Pair& pair) const {
  for (const auto& [self, other] : {std::pair(pair.a, pair.b), std::pair(pair.b, pair.a)})
    if (IsFree(self))
      for (const std::uint32_t third : touching_[self])
        if (third != other && IsFree(third)) return true;
  return false;
}

/// m/s, where they touch: the bodies have moved there.
double ImpactWatch::ApproachAt(const Pair& pair, const exact::Touch& touch, const Vector3d& point,
                               const BodyStates& before) const {
  ImpactBody a = BodyOf(pair.a, before), b = BodyOf(pair.b, before);
  a.centre += touch.part * timestep_ * a.velocity;
  b.centre += touch.part * timestep_ * b.velocity;
  return -(exact::VelocityAt(a, point) - exact::VelocityAt(b, point)).dot(touch.normal);
}

/// All that touch at once; none if it is not known which do.
std::optional<std::vector<Vector3d>> ImpactWatch::PointsOf(const Pair& pair,
                                                           const exact::Touch& touch,
                                                           const BodyStates& before) const {
  std::vector<Vector3d> points = {touch.point};
  if (IsRound(pair)) return points;
  const objects::Solid& solid = engine_.initial_state().objects[pair.a].solid;
  const exact::Collider other = ColliderOf(pair.b, before);
  const objects::Pose pose = ColliderOf(pair.a, before).motion.At(touch.part),
                      other_pose = other.motion.At(touch.part);
  const auto region = [&](double tilt) {
    return exact::ContactRegion(solid, pose, other.solid, other_pose, touch, tilt);
  };
  const double half = LeastSide(pair) / 2;
  const double tilt = ApproachAt(pair, touch, touch.point, before) * timestep_ / half;
  const std::vector<Vector3d> widest = region(std::min(kMostTilt, kAmbiguous * tilt));
  if (Diameter(widest) <= kPoint * half) return points;
  points = region(std::min(kParallel, kAtOnce * tilt));
  if (Farthest(widest, points) > kSameRegion * Diameter(widest)) return std::nullopt;
  return points;
}

/// None if a support cannot be judged, or points touch one after the other while others support
/// the bodies.
std::optional<ImpactWatch::Event> ImpactWatch::MakeEvent(const Pair& pair,
                                                         const exact::Touch& touch,
                                                         const BodyStates& before,
                                                         const BodyStates& now) {
  Event event;
  event.bodies = {pair.a, pair.b};
  event.judged = JudgedOf(pair);
  // Contacts are those of the touch; bodies have moved there.
  for (int i = 0; i < 2; ++i) {
    event.first[i] = BodyOf(event.bodies[i], before);
    event.first[i].centre += touch.part * timestep_ * event.first[i].velocity;
  }
  std::optional<std::vector<Vector3d>> points;
  if (event.judged == Judged::kWhole) points = PointsOf(pair, touch, before);
  if (event.judged == Judged::kWhole && !points) AddCourses(event, touch, before);
  const double friction = FrictionOf(pair.a, pair.b), restitution = RestitutionOf(pair.a, pair.b);
  for (const Vector3d& point : points.value_or(std::vector{touch.point}))
    event.contacts.push_back(
        {0, 1, touch.normal, point, friction,
         restitution * std::max(0.0, ApproachAt(pair, touch, point, before))});
  for (const std::uint32_t self : {pair.a, pair.b}) {
    if (!IsFree(self)) continue;
    for (const std::uint32_t ground : touching_[self])
      if (ground != pair.a && ground != pair.b &&
          (!event.courses.empty() || !AddSupport(event, self, ground, before, now)))
        return std::nullopt;
  }
  return event;
}

void ImpactWatch::AddCourses(Event& event, const exact::Touch& touch,
                             const BodyStates& before) const {
  const auto body_of = [&](std::uint32_t body) {
    const exact::Collider collider = ColliderOf(body, before);
    exact::ImpactCourse::Body result{collider.solid, collider.motion.At(touch.part)};
    result.velocity = collider.motion.way / timestep_;
    result.spin = collider.motion.turn / timestep_;
    if (!IsFree(body)) return result;
    result.mass = bodies_[body].mass;
    result.inertia = bodies_[body].inertia;
    return result;
  };
  const std::uint32_t a = event.bodies[0], b = event.bodies[1];
  for (const exact::Slip slip : kSlipRules) {
    event.courses.emplace_back(
        body_of(a), body_of(b),
        exact::ImpactCourse::Rules{FrictionOf(a, b), RestitutionOf(a, b), engine_.acceleration(),
                                   slip, ColliderOf(b, before).plane});
    event.courses.back().Advance(-touch.part * timestep_,
                                 static_cast<int>(std::ceil(-touch.part * kSteps)));
  }
}

bool ImpactWatch::AddSupport(Event& event, std::uint32_t object, std::uint32_t ground,
                             const BodyStates& before, const BodyStates& now) {
  if (!IsWall(ground) && bodies_[ground].judged != Judged::kWhole) return false;
  const auto& objects = engine_.initial_state().objects;
  const objects::Pose pose = world::ToPose(before[object].pose);
  const exact::Collider other = ColliderOf(ground, before);
  const objects::Solid& solid = objects[object].solid;
  const objects::Pose other_pose = other.motion.from;
  const exact::SignedDistance distance = DistanceBefore({object, ground}, before);
  const exact::Touch touch{0, distance.normal, (distance.on_a + distance.on_b) / 2};
  std::vector<Vector3d> points = {touch.point};
  if (!IsRound({object, ground}))
    if (auto region =
            exact::ContactRegion(solid, pose, other.solid, other_pose, touch, kNearlyParallel);
        !region.empty())
      points = std::move(region);
  const std::size_t self = object == event.bodies[0] ? 0 : 1, index = event.bodies.size();
  event.bodies.push_back(ground);
  const ImpactBody a = BodyOf(object, before), b = BodyOf(ground, now);
  // The velocities of later cycles are not those of the true impact.
  const double restitution = event.cycles == 0 ? RestitutionOf(object, ground) : 0,
               least = LeastApproach({object, ground});
  for (const Vector3d& point : points) {
    const double approach =
        -(exact::VelocityAt(a, point) - exact::VelocityAt(b, point)).dot(touch.normal);
    event.contacts.push_back({self, index, touch.normal, point, FrictionOf(object, ground),
                              approach > least ? restitution * approach : 0});
  }
  return true;
}

/// Returns false if it is over.
bool ImpactWatch::Continue(Event& event, const BodyStates& before, const BodyStates& now) {
  if (!event.is_felt) {
    const auto pair = std::ranges::find_if(pairs_, [&](const Pair& each) {
      return each.a == event.bodies[0] && each.b == event.bodies[1];
    });
    if (pair == pairs_.end()) return Wait(event, before, now);
    event.is_felt = true;
    event.cycles = 0;
    event.is_complete = false;
    if (event.judged != Judged::kWhole) {
      CompareDirection(*pair, event.contacts[0].normal);
      return false;
    }
  }
  const auto is_interrupted = [&] {
    for (int i = 0; i < 2; ++i) {
      const std::uint32_t self = event.bodies[i];
      if (!IsFree(self)) continue;
      for (const std::uint32_t other : touching_[self])
        if (std::ranges::find(event.bodies, other) == event.bodies.end() &&
            (IsFree(other) || !AddSupport(event, self, other, before, now)))
          return true;
    }
    return false;
  };
  const std::uint32_t one = IsFree(event.bodies[0]) ? 0 : 1;
  const auto& others = touching_[event.bodies[one]];
  const bool touches = std::ranges::find(others, event.bodies[1 - one]) != others.end();
  if ((touches || !event.is_complete) && event.cycles < kMostCycles) {
    if (!is_interrupted()) {
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

/// The velocities that the true impact changes.
std::vector<ImpactBody> ImpactWatch::StartOf(const Event& event, const BodyStates& now) const {
  std::vector<ImpactBody> bodies(event.first, event.first + 2);
  for (std::size_t i = 2; i < event.bodies.size(); ++i)
    bodies.push_back(BodyOf(event.bodies[i], now));
  return bodies;
}

std::vector<ImpactBody> ImpactWatch::AfterImpact(const Event& event, exact::Slip slip,
                                                 const BodyStates& now) const {
  if (!event.courses.empty()) {
    const exact::ImpactCourse& course = event.courses[slip == exact::Slip::kLeft ? 0 : 1];
    return {course.a(), course.b()};
  }
  std::vector<ImpactBody> bodies = StartOf(event, now);
  exact::SolveImpact(bodies, event.contacts, slip);
  return bodies;
}

/// By a cycle.
void ImpactWatch::Advance(Event& event, const BodyStates& now) {
  ++event.cycles;
  for (int i = 0; i < 2; ++i)
    event.first[i] = IsFree(event.bodies[i]) ? Pulled(event.bodies[i], event.first[i])
                                             : BodyOf(event.bodies[i], now);
  for (exact::ImpactCourse& course : event.courses) course.Advance(timestep_, kSteps);
}

void ImpactWatch::Compare(Event& event, const BodyStates& now) {
  Advance(event, now);
  const bool has_friction = std::ranges::any_of(
      event.contacts, [](const exact::ImpactContact& contact) { return contact.friction > 0; });
  for (const exact::Slip slip : kSlipRules) {
    if (slip == exact::Slip::kFirst && !has_friction) break;
    CompareWith(AfterImpact(event, slip, now), event, now,
                event.cycles == 1 && slip == exact::Slip::kLeft);
  }
  if (!event.courses.empty()) {
    event.is_complete = event.cycles >= kCourseCycles;
    return;
  }
  event.is_complete = true;
  const ImpactBody ends[2] = {BodyOf(event.bodies[0], now), BodyOf(event.bodies[1], now)};
  for (const exact::ImpactContact& contact : event.contacts) {
    if (contact.a != 0 || contact.b != 1) continue;
    const auto leaving = [&](const ImpactBody& a, const ImpactBody& b) {
      return (exact::VelocityAt(a, contact.point) - exact::VelocityAt(b, contact.point))
          .dot(contact.normal);
    };
    if (leaving(ends[0], ends[1]) < kComplete * leaving(event.first[0], event.first[1]))
      event.is_complete = false;
  }
}

/// kg m/s: of the first two of the bodies from other velocities.
ImpactWatch::Change ImpactWatch::ChangeOf(const Event& event, std::span<const ImpactBody> bodies,
                                          std::span<const ImpactBody> others,
                                          const BodyStates& now) const {
  double energy = 0, inverse_mass = 0;
  for (std::size_t i = 0; i < 2; ++i) {
    const std::uint32_t object = event.bodies[i];
    if (!IsFree(object)) continue;
    const Body& body = bodies_[object];
    const Eigen::Quaterniond back = world::ToEigen(now[object].pose.getRotation()).conjugate();
    energy += body.mass * (bodies[i].velocity - others[i].velocity).squaredNorm() +
              body.inertia.dot((back * (bodies[i].spin - others[i].spin)).cwiseAbs2());
    inverse_mass += 1 / body.mass;
  }
  return {std::sqrt(energy / inverse_mass), inverse_mass};
}

/// `bodies`: after the true impact.
void ImpactWatch::CompareWith(std::span<const ImpactBody> bodies, Event& event,
                              const BodyStates& now, bool is_first) {
  const ImpactBody real[2] = {BodyOf(event.bodies[0], now), BodyOf(event.bodies[1], now)};
  const double error = ChangeOf(event, bodies, real, now).impulse,
               change = ChangeOf(event, bodies, event.first, now).impulse;
  if (is_first || error * event.impulse < event.error * change) {
    event.error = error;
    event.impulse = change;
  }
}

void ImpactWatch::Count(double error, double impulse) {
  error_ += error;
  impulse_ += impulse;
}

bool ImpactWatch::IsRound(const Pair& pair) const {
  const auto is_ellipsoid = [&](std::uint32_t body) {
    return !IsWall(body) &&
           engine_.initial_state().objects[body].solid.shape == objects::Shape::kEllipsoid;
  };
  return is_ellipsoid(pair.a) || is_ellipsoid(pair.b);
}

/// At the start of the cycle.
exact::SignedDistance ImpactWatch::DistanceBefore(const Pair& pair,
                                                  const BodyStates& before) const {
  const objects::Solid& solid = engine_.initial_state().objects[pair.a].solid;
  const objects::Pose pose = world::ToPose(before[pair.a].pose);
  const exact::Collider other = ColliderOf(pair.b, before);
  return other.solid ? exact::DistanceOf(solid, pose, *other.solid, other.motion.from)
                     : exact::DistanceOf(solid, pose, other.plane);
}

/// Whether they overlap no more than contacts at rest do, and part sooner across the touch.
bool ImpactWatch::LeavesAnotherWay(const Pair& pair, const exact::Touch& touch,
                                   const BodyStates& before) const {
  if (IsWall(pair.b)) return false;
  return IsShallowAcross(pair, touch, DistanceBefore(pair, before));
}

bool ImpactWatch::IsShallowAcross(const Pair& pair, const exact::Touch& touch,
                                  const exact::SignedDistance& distance) const {
  return distance.Depth() < kShallow * LeastSide(pair) &&
         distance.normal.dot(touch.normal) < kOtherWay;
}

/// The same from the touch to the end of the cycle.
bool ImpactWatch::SlidesAcross(const Meeting& meeting, const exact::Touch& touch) const {
  const Pair pair{meeting.a, meeting.b};
  if (IsWall(pair.b)) return false;
  const auto& objects = engine_.initial_state().objects;
  bool overlaps = false;
  for (int sample = 1; sample <= kSamples; ++sample) {
    const double part = touch.part + (1 - touch.part) * sample / kSamples;
    const exact::SignedDistance distance =
        exact::DistanceOf(objects[pair.a].solid, meeting.motion_a.At(part), objects[pair.b].solid,
                          meeting.motion_b.At(part));
    if (distance.gap >= 0) continue;
    overlaps = true;
    if (!IsShallowAcross(pair, touch, distance)) return false;
  }
  return overlaps;
}

double ImpactWatch::FrictionOf(std::uint32_t a, std::uint32_t b) const {
  return std::min(world::kMostFriction,
                  bodies_[a].friction * (IsWall(b) ? wall_friction_ : bodies_[b].friction));
}

double ImpactWatch::RestitutionOf(std::uint32_t a, std::uint32_t b) const {
  return bodies_[a].restitution * (IsWall(b) ? wall_restitution_ : bodies_[b].restitution);
}

exact::Collider ImpactWatch::ColliderOf(std::uint32_t body, const BodyStates& states) const {
  exact::Collider collider;
  if (IsWall(body)) {
    const auto wall = body - static_cast<std::uint32_t>(bodies_.size());
    collider.plane.normal = (wall % 2 == 0 ? 1 : -1) * Vector3d::Unit(wall / 2);
    collider.plane.offset = -engine_.side() / 2;
    return collider;
  }
  collider.solid = &engine_.initial_state().objects[body].solid;
  collider.motion = {world::ToPose(states[body].pose),
                     timestep_ * world::ToEigen(states[body].velocity),
                     timestep_ * world::ToEigen(states[body].spin)};
  return collider;
}

ImpactBody ImpactWatch::BodyOf(std::uint32_t body, const BodyStates& states) const {
  ImpactBody result;
  if (IsWall(body)) return result;
  const BodyState& state = states[body];
  result.centre = world::ToEigen(state.pose.getOrigin());
  result.velocity = world::ToEigen(state.velocity);
  result.spin = world::ToEigen(state.spin);
  if (!IsFree(body)) return result;
  result.inverse_mass = 1 / bodies_[body].mass;
  const Eigen::Matrix3d turn = world::ToEigen(state.pose.getBasis());
  result.inverse_inertia =
      turn * bodies_[body].inertia.cwiseInverse().asDiagonal() * turn.transpose();
  return result;
}

/// A cycle later, without contacts; Bullet turns the spin as the body turns.
ImpactBody ImpactWatch::Pulled(std::uint32_t body, const ImpactBody& state) const {
  ImpactBody pulled = state;
  const Vector3d momentum = state.inverse_inertia.inverse() * state.spin;
  pulled.velocity = bodies_[body].damping * state.velocity + timestep_ * engine_.acceleration();
  pulled.spin = bodies_[body].spin_damping *
                (state.spin - timestep_ * state.inverse_inertia * state.spin.cross(momentum));
  return pulled;
}

}  // namespace cdb::probes
