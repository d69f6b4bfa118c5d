#include "library/detectors/builtin/skin.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>

namespace cdb::builtin {
namespace {

// In nanoseconds, measured once on one machine; only their ratios matter.
constexpr double kGridCost = 38;                   ///< of a body in a cycle of `grid`
constexpr double kListCost = 80, kListedCost = 1;  ///< of making a list: a body, a candidate
constexpr double kOccupancyCost = 0.1;             ///< of each other body in a cell, or too long
constexpr double kCheckCost = 3, kTestCost = 2.2, kRegrowCost = 250, kUntrackedCost = 100;

/// Escaped bodies that get larger boxes more often in one list are untracked.
constexpr std::uint8_t kMostRegrowths = 2;
/// Of a fat box's longest side: who is so far out of it was set elsewhere.
constexpr double kFarAway = 0.5;
/// A list is made anew after so many cycles at the latest: what came to rest gets thin again.
constexpr unsigned kMaxAge = 256;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

constexpr std::size_t kSample = 512;
/// Of a body, above which boxes get less fat; looked at after so many bodies.
constexpr std::size_t kMostCandidates = 24, kSlice = 256;
/// Boxes get less fat in quarters, down to this.
constexpr double kLeastShare = 1. / 256;
/// Of a list's cycles, after which boxes are remembered for their velocities.
constexpr double kRecentShare = 0.75;
/// Deviations of all but a quarter, times this, hold nearly all of what jitters evenly.
constexpr double kMarginFactor = 1.6;
/// The same of all but a half.
constexpr double kHalfMarginFactor = 2.7;
/// Who deviated more than most gets so much of a margin of its own, up to a limit for those that
/// bounced or were set elsewhere.
constexpr double kOwnMarginFactor = 2;

Vec3 Shift(const Box& from, const Box& to) {
  return {(to.lower.x - from.lower.x + to.upper.x - from.upper.x) / 2,
          (to.lower.y - from.lower.y + to.upper.y - from.upper.y) / 2,
          (to.lower.z - from.lower.z + to.upper.z - from.upper.z) / 2};
}
double Length(const Vec3& way) {
  return std::max(std::max(std::fabs(way.x), std::fabs(way.y)), std::fabs(way.z));
}
/// What is left of a shift after so many cycles of a velocity.
Vec3 Rest(const Vec3& shift, const Vec3& velocity, double cycles) {
  return {shift.x - velocity.x * cycles, shift.y - velocity.y * cycles,
          shift.z - velocity.z * cycles};
}
Vec3 Scaled(const Vec3& way, double by) { return {way.x * by, way.y * by, way.z * by}; }
bool Overlap(const kernels::FatBox& a, const kernels::FatBox& b) {
  for (int axis = 0; axis < 3; ++axis)
    if (!(a.lower[axis] <= b.upper[axis] && b.lower[axis] <= a.upper[axis])) return false;
  return true;
}

/// Without touching its sides.
bool LiesInside(const kernels::FatBox& fat, const Box& room) {
  const auto inside = [](float lower, float upper, double least, double most) {
    return static_cast<double>(lower) > least && static_cast<double>(upper) < most;
  };
  return inside(fat.lower[0], fat.upper[0], room.lower.x, room.upper.x) &&
         inside(fat.lower[1], fat.upper[1], room.lower.y, room.upper.y) &&
         inside(fat.lower[2], fat.upper[2], room.lower.z, room.upper.z);
}
bool AreSame(const Box& a, const Box& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

/// A float is off by less than the last term. Infinity stays what it is.
float Below(double x) { return static_cast<float>(x < kInfinity ? x - std::fabs(x) * 0x1p-23 : x); }
float Above(double x) {
  return static_cast<float>(x > -kInfinity ? x + std::fabs(x) * 0x1p-23 : x);
}

Pair Ordered(Id a, Id b) { return {std::min(a, b), std::max(a, b)}; }

double CostOfEscaped(std::size_t escaped, std::size_t untracked) {
  return kRegrowCost * static_cast<double>(escaped - untracked) +
         kUntrackedCost * static_cast<double>(untracked);
}

/// A fat box with room for one that left it, and for as much again. Nullopt where it left for good:
/// it was set elsewhere, or is no number.
std::optional<kernels::FatBox> Larger(const kernels::FatBox& fat, const Box& box) {
  const double lower[3] = {box.lower.x, box.lower.y, box.lower.z};
  const double upper[3] = {box.upper.x, box.upper.y, box.upper.z};
  double out = 0, slack = 0, side = 0;
  for (int axis = 0; axis < 3; ++axis) {
    if (!(lower[axis] <= upper[axis])) return std::nullopt;
    const double low = fat.lower[axis], high = fat.upper[axis];
    out = std::max({out, low - lower[axis], upper[axis] - high});
    slack = std::max(slack, (high - low - (upper[axis] - lower[axis])) / 2);
    side = std::max(side, high - low);
  }
  if (!(out <= kFarAway * side && side < kInfinity)) return std::nullopt;
  const double margin = std::max(slack, 2 * out);
  kernels::FatBox larger;
  for (int axis = 0; axis < 3; ++axis) {
    const float low = Below(lower[axis] - margin), high = Above(upper[axis] + margin);
    larger.lower[axis] = fat.lower[axis] <= low ? fat.lower[axis] : low;
    larger.upper[axis] = fat.upper[axis] >= high ? fat.upper[axis] : high;
  }
  return larger;
}

}  // namespace

Skin::Skin(const Options& options, const kernels::Kernels& kernels)
    : kernels_(kernels), grid_(kernels), runner_grid_(kernels), parts_(options.threads) {}

void Skin::Prepare(const Scene& scene) {
  bodies_.Learn(scene);
  is_built_ = sleeps_ = false;
  velocity_.assign(bodies_.movers(), {0, 0, 0});
  recent_.assign(bodies_.movers(), {});
  margins_.assign(bodies_.movers(), 0);
  recent_age_ = 0;
  goes_on_ = false;
  share_ = 1;
  margin_ = most_margin_ = 0;
  last_cost_ = last_tried_ = 0;
}

void Skin::FindPairs(const Scene& scene, std::vector<Pair>& pairs) {
  if (scene.size != built_.size()) Prepare(scene);
  bodies_.MeasureRoom(scene);
  const std::size_t movers = bodies_.movers();
  if (is_built_) {
    ++age_;
    if (StillSleeps(scene) || (pairs_are_of_built_ && IsUnchanged(scene))) {
      parts_.AppendTo(pairs);
      return;
    }
  }
  bool is_over = !is_built_ || age_ >= kMaxAge || (goes_on_ && age_ > horizon_) ||
                 !AreSame(bodies_.room(), room_);
  if (!is_over) {
    const std::size_t escaped =
        kernels_.find_escaped(scene.boxes.data(), fat_.data(), movers, escaped_.data());
    if (goes_on_ && recent_age_ == 0 && age_ >= kRecentShare * horizon_) {
      std::copy_n(scene.boxes.begin(), movers, recent_.begin());
      recent_age_ = age_;
    }
    const double foreseen = CostOfEscaped(escaped, std::min(escaped, untracked_));
    is_over = stray_cost_ + foreseen > kListCost * static_cast<double>(movers);
    if (!is_over) {
      untracked_ = RegrowEscaped(scene, escaped);
      const double cost = CostOfEscaped(escaped, untracked_);
      cost_ += cost;
      stray_cost_ += cost + kTestCost * static_cast<double>(candidates_.size() - made_);
    }
  }
  if (is_over) MakeList(scene);
  const std::span<const Pair> all = candidates_.pairs();
  cost_ += kCheckCost * static_cast<double>(movers) + kTestCost * static_cast<double>(all.size());
  parts_.Run(all.size() / 16, [&](unsigned part, unsigned parts, kernels::PairBuffer& found) {
    const std::size_t begin = all.size() * part / parts, end = all.size() * (part + 1) / parts;
    kernels_.filter(scene.boxes.data(), all.data() + begin, end - begin, found.sink());
  });
  if (untracked_ > 0) AppendUntracked(scene, untracked_, parts_.last());
  bodies_.MeetBounds(scene, near_walls_, parts_.last());
  bodies_.MeetOthers(scene, kernels_, parts_.last());
  pairs_are_of_built_ = age_ == 0;
  last_room_ = bodies_.room();
  parts_.AppendTo(pairs);
}

/// All movers have been asleep since the last call, so that its pairs are those of this one.
bool Skin::StillSleeps(const Scene& scene) {
  const bool did_sleep = sleeps_;
  sleeps_ = bodies_.AllSleep(scene);
  return did_sleep && sleeps_ && AreSame(bodies_.room(), last_room_) && bodies_.others().empty();
}

bool Skin::IsUnchanged(const Scene& scene) const {
  return built_.empty() ||
         std::memcmp(scene.boxes.data(), built_.data(), built_.size() * sizeof(Box)) == 0;
}

/// Pairs (id, other) with all whose fat boxes overlap `box`, until the next call.
std::span<const Pair> Skin::Near(const kernels::FatBox& box, Id id) {
  raw_.Clear();
  grid_.QueryOne(box, id, raw_.sink());
  const std::size_t in_grid = raw_.size();
  regrown_.QueryOne(box, id, kernels_, raw_.sink());
  const std::span<Pair> found = raw_.pairs();
  std::size_t kept = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    // The grid has those that grew as they were.
    const Id other = found[i].b;
    if (other != id && (i >= in_grid || !regrown_.Has(other))) found[kept++] = found[i];
  }
  return found.first(kept);
}

/// False where it is a runner, as it left for good or would meet too many.
bool Skin::Regrow(const Scene& scene, Id id) {
  if (regrowths_[id] == kMostRegrowths) return false;
  const kernels::FatBox old = fat_[id];
  const auto larger = Larger(old, scene.boxes[id]);
  const std::span<const Pair> near = larger ? Near(*larger, id) : std::span<const Pair>();
  if (!larger || near.size() > kMostCandidates) {
    regrowths_[id] = kMostRegrowths;
    return false;
  }
  ++regrowths_[id];
  if (LiesInside(old, room_) && !LiesInside(*larger, room_)) near_walls_.push_back(id);
  fat_[id] = *larger;
  regrown_.Put(id, *larger);
  // Candidates are all pairs whose fat boxes overlap: those that overlap only now are to add.
  for (const auto& [self, other] : near)
    if (!Overlap(old, fat_[other]) && scene.MayCollide(id, other))
      candidates_.Add(Ordered(id, other));
  return true;
}

/// Gives escaped bodies larger fat boxes. Returns the number of untracked ones, with which
/// `escaped_` then begins.
std::size_t Skin::RegrowEscaped(const Scene& scene, std::size_t count) {
  std::size_t untracked = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const Id id = escaped_[i];
    if (!Regrow(scene, id)) escaped_[untracked++] = id;
  }
  return untracked;
}

// What untracked bodies have to add are pairs whose fat boxes do not overlap. Other untracked
// bodies are met apart: they are not where their fat boxes are.
void Skin::AppendUntracked(const Scene& scene, std::size_t count, kernels::PairBuffer& pairs) {
  const auto put = [&](Id a, Id b) {
    if (Overlap(scene.boxes[a], scene.boxes[b]) && !Overlap(fat_[a], fat_[b]) &&
        scene.MayCollide(a, b))
      pairs.Add(Ordered(a, b));
  };
  untracked_boxes_.clear();
  for (std::size_t i = 0; i < count; ++i) is_untracked_[escaped_[i]] = 1;
  for (std::size_t i = 0; i < count; ++i)  // of the others it is known whether they are near
    if (LiesInside(fat_[escaped_[i]], room_))
      bodies_.MeetBounds(scene, std::span(escaped_).subspan(i, 1), pairs);
  for (std::size_t i = 0; i < count; ++i) {
    const Box& box = scene.boxes[escaped_[i]];
    untracked_boxes_.push_back(box);
    for (const auto& [self, other] : Near(kernels::Around(box, kernels_), escaped_[i]))
      if (!is_untracked_[other]) put(self, other);
  }
  for (std::size_t i = 0; i < count; ++i) is_untracked_[escaped_[i]] = 0;
  raw_.Clear();
  runner_grid_.Build(untracked_boxes_.data(), count);
  runner_grid_.QueryPart(0, 1, raw_.sink());
  for (const Pair& pair : raw_.pairs()) put(escaped_[pair.a], escaped_[pair.b]);
}

void Skin::MakeList(const Scene& scene) {
  const std::size_t movers = bodies_.movers();
  if (is_built_) {
    LearnCost();
    LearnMotion(scene);
  } else {
    built_.assign(scene.boxes.begin(), scene.boxes.end());
    age_ = 1;
  }
  LearnBodies(scene);
  fat_.resize(movers);
  escaped_.resize(movers);
  regrown_.Clear(movers);
  regrowths_.assign(movers, 0);
  untracked_ = 0;
  is_untracked_.assign(movers, 0);
  // Bodies that jump about would get boxes as large as the scene: less, then.
  share_ = std::min(4 * share_, 1.);
  for (Fatten(scene); !FindCandidates(scene, share_ > 0); Fatten(scene)) {
    share_ = share_ > kLeastShare ? share_ / 4 : 0;
    grid_.Reshape();
  }
  share_ = std::max(share_, kLeastShare);
  FindNearWalls();
  std::ranges::copy(scene.boxes, built_.begin());
  candidates_.Clear();
  parts_.AppendTo(candidates_);
  made_ = candidates_.size();
  age_ = 0;
  is_built_ = true;
  stray_cost_ = 0;
  cost_ = making_cost_ = (kListCost + kOccupancyCost * (grid_.MeanOccupancy() +
                                                        static_cast<double>(grid_.TooLong()))) *
                             static_cast<double>(movers) +
                         kListedCost * static_cast<double>(candidates_.size());
}

void Skin::FindNearWalls() {
  room_ = bodies_.room();
  near_walls_.clear();
  for (Id id = 0; id < bodies_.movers(); ++id)
    if (!LiesInside(fat_[id], room_)) near_walls_.push_back(id);
}

/// False if it is limited and there are far too many.
bool Skin::FindCandidates(const Scene& scene, bool is_limited) {
  grid_.Arrange(bodies_.movers());
  std::atomic<bool> is_too_much = false;
  parts_.Run(bodies_.movers(), [&](unsigned part, unsigned parts, kernels::PairBuffer& found) {
    const std::size_t begin = grid_.Size() * part / parts, end = grid_.Size() * (part + 1) / parts;
    for (std::size_t at = begin; at < end && !is_too_much; at += kSlice) {
      const std::size_t stop = std::min(at + kSlice, end);
      grid_.Query(at, stop, found.sink());
      if (is_limited && found.size() > kMostCandidates * (stop - begin + kSlice))
        is_too_much = true;
    }
    bodies_.Sieve(scene, true, found);
  });
  return !is_too_much;
}

double Skin::Cost() const {
  const double now = cost_ / (age_ + 1);
  return (last_cost_ > 0 ? std::min(now, last_cost_) : now) / static_cast<double>(bodies_.movers());
}

double Skin::GridCost() const {
  const double occupancy = grid_.MeanOccupancy() + static_cast<double>(grid_.TooLong());
  return kGridCost + kOccupancyCost * occupancy +
         kListedCost * static_cast<double>(parts_.size()) / static_cast<double>(bodies_.movers());
}

// A longer list costs less to make a cycle and more to test.
void Skin::LearnCost() {
  last_cost_ = cost_ / age_;
  if (!goes_on_) {
    last_tried_ = 0;
  } else if (age_ < horizon_) {  // escaped bodies ended it
    horizon_ = std::max(age_ / 1.25, 1.);
    step_ = 1.2;
    last_tried_ = 0;
  } else {
    // What does not depend on how long a list lasts counts for nothing.
    const double tests =
        cost_ - making_cost_ - kCheckCost * age_ * static_cast<double>(bodies_.movers());
    if (making_cost_ > 4 * tests) {
      step_ = making_cost_ > 16 * tests ? 6 : 3;
    } else {
      if (step_ > 1.5) step_ = 1.5;
      if (last_tried_ > 0 && last_cost_ > last_tried_) step_ = 1 / step_;
    }
    last_tried_ = last_cost_;
    horizon_ = std::clamp(horizon_ * step_, 1., static_cast<double>(kMaxAge));
  }
}

// Both ways to foresee where boxes go are judged by where some of them went.
void Skin::LearnMotion(const Scene& scene) {
  const std::size_t movers = bodies_.movers(), most = std::min(movers, kSample);
  double resting[kSample], going[kSample], speed = 0;
  std::size_t size = 0;
  for (std::size_t k = 0; k < most; ++k) {
    const std::size_t i = most < movers ? kernels::SamplePlace(k, movers) : k;
    const Vec3 shift = Shift(built_[i], scene.boxes[i]);
    const double stayed = Length(shift), went = Length(Rest(shift, velocity_[i], age_));
    if (!std::isfinite(stayed + went)) continue;
    resting[size] = stayed;
    going[size++] = went;
    speed += stayed / age_;
  }
  if (size == 0) return;
  const auto at = [size](double* values, double share) {
    const auto place = static_cast<std::size_t>(share * static_cast<double>(size));
    std::nth_element(values, values + place, values + size);
    return values[place];
  };
  goes_on_ = at(going, 0.75) < at(resting, 0.75) / 2 || at(going, 0.5) < at(resting, 0.5) / 2;
  double* deviations = goes_on_ ? going : resting;
  margin_ = kMarginFactor * at(deviations, 0.75);
  // In a long list many were turned round; they must not decide for the others.
  if (goes_on_) margin_ = std::min(margin_, kHalfMarginFactor * at(deviations, 0.5));
  // Who goes on and yet deviated was turned round once; it will not be all the time.
  most_margin_ = goes_on_ ? margin_ : kMarginFactor * at(deviations, 0.95);
  most_speed_ = 16 * speed / static_cast<double>(size);
}

// The grid takes fat boxes as the floats that they are, so it finds their pairs exactly.
void Skin::Fatten(const Scene& scene) {
  const std::size_t movers = bodies_.movers();
  const kernels::Columns& room = grid_.Room(movers);
  const double time = goes_on_ ? share_ * horizon_ : 0, most_way = most_speed_ * time;
  // What a velocity is off by adds up.
  const double longer = goes_on_ ? std::max(horizon_ / age_, 1.) : 1;
  for (std::size_t i = 0; i < movers; ++i) {
    const Box& box = scene.boxes[i];
    const double margin = longer * share_ * margins_[i];
    const auto fatten = [&](std::size_t axis, double lower, double upper, double velocity) {
      double way = velocity * time;
      // In this order what is not a number is left out.
      way = way < most_way ? way : most_way;
      way = way > -most_way ? way : -most_way;
      fat_[i].lower[axis] = room.lower[axis][i] = Below(lower + (way < 0 ? way : 0) - margin);
      fat_[i].upper[axis] = room.upper[axis][i] = Above(upper + (way > 0 ? way : 0) + margin);
    };
    fatten(0, box.lower.x, box.upper.x, velocity_[i].x);
    fatten(1, box.lower.y, box.upper.y, velocity_[i].y);
    fatten(2, box.lower.z, box.upper.z, velocity_[i].z);
  }
}

// Who was turned round goes on as it did at the end of the list. Of the others all cycles say more,
// as boxes are rounded.
void Skin::LearnBodies(const Scene& scene) {
  const double cycles = goes_on_ ? age_ : 0;
  const bool has_recent = recent_age_ > 0 && recent_age_ < age_;
  const double each = 1. / age_, each_recent = has_recent ? 1. / (age_ - recent_age_) : 0;
  for (std::size_t i = 0; i < bodies_.movers(); ++i) {
    const Vec3 way = Shift(built_[i], scene.boxes[i]);
    const double deviation = Length(Rest(way, velocity_[i], cycles));
    const double own = kOwnMarginFactor * deviation;
    // In this order what is not a number is left out.
    margins_[i] = std::max(margin_, own < most_margin_ ? own : most_margin_);
    velocity_[i] = has_recent && deviation > margin_
                       ? Scaled(Shift(recent_[i], scene.boxes[i]), each_recent)
                       : Scaled(way, each);
  }
  recent_age_ = 0;
}

std::unique_ptr<Detector> MakeSkin(const Options& options, const kernels::Kernels& kernels) {
  return std::make_unique<Skin>(options, kernels);
}

}  // namespace cdb::builtin
