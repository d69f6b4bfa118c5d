#include "library/detectors/builtin/skin.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <optional>
#include <utility>

namespace cdb::builtin {
namespace {

// In nanoseconds, measured once on one machine; only their ratios matter.
constexpr double kGridCost = 38;                   ///< of a body in a cycle of `grid`
constexpr double kListCost = 80, kListedCost = 1;  ///< of making a list: a body, a candidate
constexpr double kOccupancyCost = 0.1;             ///< of each other body in a cell, or too long
constexpr double kCheckCost = 3, kTestCost = 2.2, kRegrowCost = 250, kUntrackedCost = 100;

/// What reading a box takes if no more is done in a cycle.
constexpr double kReadCost = 1.4;
/// Of a body, in a cycle of a first list.
constexpr double kMostOfGuess = 2.15;
/// Of the work of a cycle, that building the next list may add to it without haste; and with haste,
/// where it would take more than this share of a list's life.
constexpr double kBuildingShare = 0.9, kMostBuildingShare = 1.45;
constexpr double kBuildingLife = 0.4;
/// Of the cycles for which a guess would do: if boxes keep their velocity, a list may last longer.
constexpr double kCalmShare = 0.25;
/// Of a list's cycles, before the next one is started: boxes are remembered then, so that those
/// that turned round get the velocity that they have since.
constexpr double kMarkedShare = 0.25;
/// Bodies from which several threads look for escaped ones sooner than one.
constexpr std::size_t kWorthThreads = 16000;
/// Escapes become more frequent as a list gets old.
constexpr double kMoreStrays = 1.3;
/// Escaped bodies that get larger boxes more often in one list are untracked.
constexpr std::uint8_t kMostRegrowths = 2;
/// Candidates that a larger box may have.
constexpr std::size_t kMostNear = 24;
/// Of a fat box's longest side: who is so far out of it was set elsewhere.
constexpr double kFarAway = 0.5;
/// Factors by which a lifetime is tried that differs from the last one.
constexpr double kLeastStep = 1.12, kMostStep = 1.5;
/// A list is made anew after so many cycles at the latest: what came to rest gets thin again.
constexpr unsigned kMaxAge = 256;
/// A first list is looked at in this cycle of it, and replaced as soon as the next is built.
constexpr unsigned kSeen = 1;

constexpr double kInfinity = std::numeric_limits<double>::infinity();

bool Overlap(const kernels::FatBox& fat, const Box& box) {
  return fat.lower[0] <= box.upper.x && box.lower.x <= fat.upper[0] &&
         fat.lower[1] <= box.upper.y && box.lower.y <= fat.upper[1] &&
         fat.lower[2] <= box.upper.z && box.lower.z <= fat.upper[2];
}
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
    : kernels_(kernels),
      parts_(options.threads),
      list_(std::make_unique<SkinList>(kernels)),
      builder_(kernels, parts_),
      untracked_grid_(kernels),
      changes_(parts_) {}

void Skin::Prepare(const Scene& scene) {
  bodies_.Learn(scene);
  Forget();
  list_->Reserve(scene, bodies_.movers());
  builder_.Prepare(scene, bodies_.movers());
  last_tried_ = 0;
}

/// Makes the list fit the boxes; false if the pairs are those of the last call.
bool Skin::Follow(const Scene& scene) {
  if (scene.size != list_->past.boxes.size()) Prepare(scene);
  bodies_.MeasureRoom(scene);
  work_ = 0;
  ++cycle_;
  const bool still_sleeps = StillSleeps(scene);
  if (is_built_) {
    ++age_;
    if (still_sleeps || (pairs_are_of_past_ && IsUnchanged(scene))) return false;
    BuildAhead(scene);
    if (!TrackEscaped(scene)) MakeList(scene);
    FollowWalls(scene);
  } else {
    MakeList(scene);
  }
  const double cost = kCheckCost * static_cast<double>(bodies_.movers()) +
                      kTestCost * static_cast<double>(list_->candidates.size());
  cost_ += cost;
  work_ += cost;
  pairs_are_of_past_ = age_ == 0 && IsUnchanged(scene);
  last_room_ = bodies_.room();
  return true;
}

void Skin::FindPairs(const Scene& scene, std::vector<Pair>& pairs) {
  if (Follow(scene) || !parts_are_pairs_) {
    const std::span<const Pair> all = list_->candidates.pairs();
    const std::size_t size = all.size();
    parts_.Run(size / 16, [&](std::size_t part, std::size_t parts, kernels::PairBuffer& found) {
      const std::size_t begin = size * part / parts, end = size * (part + 1) / parts;
      kernels_.filter(scene.boxes.data(), all.data() + begin, end - begin, found.sink());
    });
    AppendRest(scene, parts_.last());
    found_ = parts_.size();
    parts_are_pairs_ = true;
  }
  changes_.Forget();
  parts_.AppendTo(pairs);
}

bool Skin::FindChanges(const Scene& scene, std::vector<Pair>& came, std::vector<Pair>& went) {
  if (!Follow(scene) && changes_.knows_last()) return true;
  parts_are_pairs_ = false;
  rest_.Clear();
  AppendRest(scene, rest_);
  const bool are_changes =
      changes_.Find(scene, kernels_, list_->candidates.pairs(), rest_.pairs(), came, went);
  found_ = changes_.size();
  return are_changes;
}

/// Pairs that are no candidates. Those of walls are mostly the same in each cycle: they come first.
void Skin::AppendRest(const Scene& scene, kernels::PairBuffer& pairs) {
  bodies_.MeetOthers(scene, kernels_, pairs);
  if (untracked_ > 0) AppendUntracked(scene, pairs);
}

/// In how many cycles this list will be over, by its age or as boxes escape.
double Skin::CyclesLeft() const {
  double left = kMaxAge - static_cast<double>(age_);
  if (list_->goes_on) left = std::min(list_->end + 1 - cycle_, left);
  if (list_->is_guess) left = std::min(list_->life - age_, left);
  const double limit = kListCost * static_cast<double>(bodies_.movers());
  if (last_stray_cost_ <= 0) return left;
  return std::min(left, (limit - stray_cost_) / (kMoreStrays * last_stray_cost_));
}

// As late as it can be done in time, as fat boxes have to last from when they are made.
void Skin::BuildAhead(const Scene& scene) {
  if (list_->is_guess && age_ < kSeen) return;
  if (list_->is_guess && age_ == kSeen) return builder_.Observe(scene, cycle_, *list_);
  const double left = CyclesLeft();
  const double movers = static_cast<double>(bodies_.movers());
  double usual = kReadCost * movers + kTestCost * static_cast<double>(list_->candidates.size()) +
                 last_stray_cost_;
  // The lists after a guess may have far fewer candidates: cycles should not be long for those.
  if (list_->is_guess) usual = std::min(usual, kMostOfGuess * movers);
  if (!builder_.is_building()) {
    const double life = kBuildingLife * (age_ + std::max(left, 0.));
    building_share_ = list_->is_guess
                          ? kBuildingShare
                          : std::clamp(builder_.WholeCost() / (usual * std::max(life, 1.)),
                                       kBuildingShare, kMostBuildingShare);
    const double needed = std::ceil(builder_.WholeCost() / (building_share_ * usual));
    if (list_->goes_on && left <= needed + std::max(kMarkedShare * list_->horizon, 1.))
      work_ += builder_.Mark(scene, cycle_, building_share_ * usual);
    if (!list_->is_guess && left > needed) return;
    const double wait = std::max(std::min(left, needed), 0.);
    LearnCost(age_ + wait);
    // Short lists would leave too little time to build the next: longer, where boxes allow it.
    const double least = builder_.WholeCost() / (kMostBuildingShare * kReadCost * movers);
    if (list_->is_guess) horizon_ = std::max(horizon_, std::min(least, kCalmShare * list_->life));
    begin_ = cycle_ + static_cast<std::uint32_t>(wait);
    builder_.Start(scene, bodies_, {begin_, horizon_}, list_.get());
  }
  double budget =
      std::max(building_share_ * usual, builder_.CostLeft() / (std::floor(std::max(left, 0.)) + 1));
  if (left < 1) budget = SkinListBuilder::kUnlimited;
  const double before = budget;
  const bool is_done = builder_.Advance(scene, bodies_, cycle_, budget);
  work_ += before - budget;
  if (is_done && (cycle_ >= begin_ || left < 1 || list_->is_guess)) UseNewList(scene);
}

/// Lists the bodies that have left their fat boxes, in order; each thread those of a part.
std::size_t Skin::FindEscaped(const Scene& scene) {
  const std::size_t movers = bodies_.movers();
  const auto find = [&](std::size_t begin, std::size_t end) {
    return kernels_.find_escaped(scene.boxes.data() + begin, list_->fat.data() + begin, end - begin,
                                 escaped_.data() + begin);
  };
  if (movers < kWorthThreads || parts_.pool().size() == 1) return find(0, movers);
  const unsigned parts = parts_.pool().size();
  std::vector<std::size_t> found(parts);
  const auto begin_of = [&](std::size_t part) { return movers * part / parts; };
  parts_.pool().Run([&](unsigned part) { found[part] = find(begin_of(part), begin_of(part + 1)); });
  std::size_t count = 0;
  for (unsigned part = 0; part < parts; ++part)
    for (std::size_t i = 0; i < found[part]; ++i)
      escaped_[count++] = static_cast<Id>(escaped_[begin_of(part) + i] + begin_of(part));
  return count;
}

/// Finds and follows the bodies that have left their fat boxes; false if a new list costs less.
bool Skin::TrackEscaped(const Scene& scene) {
  const std::size_t movers = bodies_.movers();
  const double limit = kListCost * static_cast<double>(movers);
  const auto is_too_much = [&](std::size_t escaped) {
    return stray_cost_ + CostOfEscaped(escaped, std::min(escaped, untracked_)) > limit;
  };
  std::size_t escaped = FindEscaped(scene);
  if (is_too_much(escaped)) {
    if (!builder_.is_half_done()) return false;
    double budget = SkinListBuilder::kUnlimited;
    builder_.Advance(scene, bodies_, cycle_, budget);
    work_ += SkinListBuilder::kUnlimited - budget;
    UseNewList(scene);
    escaped = FindEscaped(scene);
    if (is_too_much(escaped)) return false;
  }
  untracked_ = RegrowEscaped(scene, escaped);
  const double cost = CostOfEscaped(escaped, untracked_);
  cost_ += cost;
  work_ += cost;
  const double stray = cost + kTestCost * static_cast<double>(list_->candidates.size() - made_);
  stray_cost_ += stray;
  // Those that turned round while the list was built are no sign of what is to come.
  last_stray_cost_ = age_ > 0 ? stray : 0;
  return true;
}

/// All movers have been asleep since the last call, so that its pairs are those of this one.
bool Skin::StillSleeps(const Scene& scene) {
  const bool did_sleep = sleeps_;
  sleeps_ = bodies_.AllSleep(scene);
  return did_sleep && sleeps_ && AreSame(bodies_.room(), last_room_) && bodies_.others().empty();
}

bool Skin::IsUnchanged(const Scene& scene) const {
  const std::vector<Box>& past = list_->past.boxes;
  return past.empty() ||
         std::memcmp(scene.boxes.data(), past.data(), past.size() * sizeof(Box)) == 0;
}

/// Pairs (id, other) with all whose fat boxes overlap `box`, until the next call.
std::span<const Pair> Skin::Near(const kernels::FatBox& box, Id id) {
  raw_.Clear();
  list_->grid.QueryOne(box, id, raw_.sink());
  const std::span<Pair> found = raw_.pairs();
  const auto rest = std::ranges::remove(found, id, &Pair::b);
  return found.first(found.size() - rest.size());
}

/// False where it becomes untracked, as it left for good or would meet too many.
bool Skin::Regrow(const Scene& scene, Id id) {
  if (regrowths_[id] == kMostRegrowths) return false;
  std::vector<kernels::FatBox>& fat = list_->fat;
  const kernels::FatBox old = fat[id];
  const auto larger = Larger(old, scene.boxes[id]);
  const std::span<const Pair> near = larger ? Near(*larger, id) : std::span<const Pair>();
  if (!larger || near.size() > kMostNear || !list_->grid.Grow(id, *larger)) {
    regrowths_[id] = kMostRegrowths;
    return false;
  }
  ++regrowths_[id];
  fat[id] = *larger;
  AddWallsOf(scene, id, &old);
  // Candidates are all pairs whose fat boxes overlap: those that overlap only now are to add.
  for (const auto& [self, other] : near)
    if (!Overlap(old, fat[other]) && scene.MayCollide(id, other))
      list_->candidates.Add(Ordered(id, other));
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
void Skin::AppendUntracked(const Scene& scene, kernels::PairBuffer& pairs) {
  const std::vector<kernels::FatBox>& fat = list_->fat;
  const std::span<const Id> untracked = std::span(escaped_).first(untracked_);
  const auto put = [&](Id a, Id b, const auto& other_fat) {
    if (Overlap(scene.boxes[a], scene.boxes[b]) && !Overlap(fat[a], other_fat) &&
        scene.MayCollide(a, b))
      pairs.Add(Ordered(a, b));
  };
  untracked_boxes_.clear();
  for (const Id id : untracked) is_untracked_[id] = 1;
  for (const Id id : untracked) {
    const Box& box = scene.boxes[id];
    untracked_boxes_.push_back(box);
    for (const Id wall : bodies_.bounds()) put(id, wall, scene.boxes[wall]);
    for (const auto& [self, other] : Near(kernels::Around(box, kernels_), id))
      if (!is_untracked_[other]) put(self, other, fat[other]);
  }
  for (const Id id : untracked) is_untracked_[id] = 0;
  raw_.Clear();
  untracked_grid_.Build(untracked_boxes_.data(), untracked_);
  untracked_grid_.QueryPart(0, 1, raw_.sink());
  for (const auto& [a, b] : raw_.pairs()) put(untracked[a], untracked[b], fat[untracked[b]]);
}

/// A whole list in this cycle.
void Skin::MakeList(const Scene& scene) {
  if (is_built_) LearnCost(std::max(age_, 1u));
  builder_.Start(scene, bodies_, {cycle_, horizon_}, is_built_ ? list_.get() : nullptr);
  double budget = SkinListBuilder::kUnlimited;
  builder_.Advance(scene, bodies_, cycle_, budget);
  work_ += SkinListBuilder::kUnlimited - budget;
  UseNewList(scene);
}

void Skin::UseNewList(const Scene& scene) {
  const std::size_t movers = bodies_.movers();
  if (is_built_ && age_ > 0) last_cost_ = cost_ / age_;
  changes_.Replace(list_->candidates.pairs());
  builder_.Take(list_);
  std::copy(scene.boxes.begin() + static_cast<std::ptrdiff_t>(movers), scene.boxes.end(),
            list_->past.boxes.begin() + static_cast<std::ptrdiff_t>(movers));
  AddWalls(scene);
  made_ = list_->candidates.size();
  age_ = 0;
  is_built_ = true;
  stray_cost_ = last_stray_cost_ = 0;
  untracked_ = 0;
  escaped_.resize(movers);
  regrowths_.assign(movers, 0);
  is_untracked_.assign(movers, 0);
  cost_ = making_cost_ =
      (kListCost + kOccupancyCost *
                       (list_->grid.MeanOccupancy() + static_cast<double>(list_->grid.TooLong()))) *
          static_cast<double>(movers) +
      kListedCost * static_cast<double>(made_);
}

/// Replaces the candidates with walls if these have moved.
void Skin::FollowWalls(const Scene& scene) {
  const std::size_t movers = bodies_.movers();
  const std::span<const Box> walls = scene.boxes.subspan(movers);
  const std::span<Box> past = std::span(list_->past.boxes).subspan(movers);
  if (walls.empty() || std::memcmp(walls.data(), past.data(), walls.size_bytes()) == 0) return;
  std::ranges::copy(walls, past.begin());
  kernels::PairBuffer& candidates = list_->candidates;
  changes_.Replace(candidates.pairs());
  const auto rest = std::ranges::remove_if(candidates.pairs(),
                                           [&](const Pair& pair) { return pair.b >= movers; });
  candidates.Cut(candidates.size() - rest.size());
  AddWalls(scene);
  made_ = std::min(made_, candidates.size());
}

void Skin::AddWalls(const Scene& scene) {
  if (bodies_.bounds().empty()) return;
  for (Id id = 0; id < bodies_.movers(); ++id) AddWallsOf(scene, id, nullptr);
}

/// Adds the walls that bound the room and overlap the body's fat box, but not those that overlap
/// `known`.
void Skin::AddWallsOf(const Scene& scene, Id id, const kernels::FatBox* known) {
  const kernels::FatBox& fat = list_->fat[id];
  if (LiesInside(fat, bodies_.room())) return;
  for (const Id wall : bodies_.bounds()) {
    const Box& box = scene.boxes[wall];
    if (Overlap(fat, box) && (known == nullptr || !Overlap(*known, box)) &&
        scene.MayCollide(id, wall))
      list_->candidates.Add({id, wall});
  }
}

double Skin::Cost() const {
  const double now = cost_ / (age_ + 1);
  return (last_cost_ > 0 ? std::min(now, last_cost_) : now) / static_cast<double>(bodies_.movers());
}

double Skin::GridCost() const {
  const kernels::BoxGrid& grid = list_->grid;
  const double occupancy = grid.MeanOccupancy() + static_cast<double>(grid.TooLong());
  return kGridCost + kOccupancyCost * occupancy +
         kListedCost * static_cast<double>(found_) / static_cast<double>(bodies_.movers());
}

// A longer list costs less to make a cycle and more to test.
void Skin::LearnCost(double life) {
  const double age = std::max(age_, 1u), movers = static_cast<double>(bodies_.movers());
  const double each = (cost_ - making_cost_) / age;
  const double cost = making_cost_ / life + each;
  // What does not depend on how long a list lasts counts for nothing.
  const double tests = life * (each - kCheckCost * movers);
  if (!list_->goes_on) {
    last_tried_ = 0;
    // Who has just begun to go on may do so for as long as this list lasted, if tests are few.
    if (making_cost_ > 4 * tests || list_->is_guess) horizon_ = std::max(horizon_, life);
  } else if (life < list_->horizon) {  // escaped bodies ended it
    horizon_ = std::max(life / 1.25, 1.);
    step_ = 1.2;
    gets_longer_ = true;
    last_tried_ = 0;
  } else {
    if (making_cost_ > 4 * tests) {
      step_ = making_cost_ > 16 * tests ? 6 : 3;
      gets_longer_ = true;
    } else {
      const bool is_worse = last_tried_ > 0 && cost > last_tried_;
      if (is_worse) gets_longer_ = !gets_longer_;
      step_ = std::clamp(1 + (step_ - 1) * (is_worse ? 0.5 : 1.25), kLeastStep, kMostStep);
    }
    last_tried_ = cost;
    horizon_ = std::clamp(gets_longer_ ? horizon_ * step_ : horizon_ / step_, 1.,
                          static_cast<double>(kMaxAge));
  }
}

std::unique_ptr<Detector> MakeSkin(const Options& options, const kernels::Kernels& kernels) {
  return std::make_unique<Skin>(options, kernels);
}

}  // namespace cdb::builtin
