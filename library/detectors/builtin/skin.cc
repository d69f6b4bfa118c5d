#include "library/detectors/builtin/skin.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <iterator>
#include <utility>

namespace cdb::builtin {
namespace {

/// Upper bound for the usual cost of a body in a cycle of a first list. In nanoseconds, as in
/// the costs of skin.h.
constexpr double kMostOfGuess = 2.15;
/// Fraction of a cycle's usual work that building the next list may add: normally, and at most.
/// More than the normal fraction is used only if building would otherwise take longer than
/// kBuildingLife, a fraction of a list's lifetime.
constexpr double kBuildingShare = 0.9, kMostBuildingShare = 1.45;
constexpr double kBuildingLife = 0.4;
/// Fraction of a guess's life up to which the lifetime of the next list may be raised. If boxes
/// keep their velocity, a list may last longer.
constexpr double kCalmShare = 0.25;
/// Boxes are marked this fraction of a list's lifetime before the next list is started, so that
/// those that turned round get the velocity that they have had since.
constexpr double kMarkedShare = 0.25;
/// Escapes become more frequent as a list ages.
constexpr double kMoreEscapes = 1.3;
/// Smallest and largest factor between the present lifetime and the next one that is tried.
constexpr double kLeastStep = 1.12, kMostStep = 1.5;
/// Greatest age of a list, in cycles in which more than a few bodies moved. A new list lets the fat
/// boxes of bodies at rest shrink again.
constexpr unsigned kMaxAge = 256;
/// The cost of a body from which follows how much of the next list is built in a cycle in which few
/// bodies move. Such a cycle costs less, but a list would then take thousands of cycles to build.
constexpr double kCostIfFewMoved = 0.5;
/// Age at which a first list is observed; it is replaced as soon as the next one is built.
constexpr unsigned kSeen = 1;

bool AreSame(const Box& a, const Box& b) { return std::memcmp(&a, &b, sizeof a) == 0; }

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

/// Updates the list to the boxes; false if the pairs are the same as in the last call. `awake` may
/// be null, if it is not known which bodies have moved since the last call.
bool Skin::Follow(const Scene& scene, const SkinAwake* awake) {
  if (scene.size != list_->past.boxes.size()) Prepare(scene);
  bodies_.MeasureRoom(scene);
  work_ = 0;
  ++cycle_;
  const bool still_sleeps = StillSleeps(scene);
  if (is_built_) {
    ++age_;
    if (still_sleeps || (pairs_are_of_past_ && IsUnchanged(scene))) return false;
    // Bodies at rest do not leave their fat boxes, so these cycles do not age the list.
    const bool have_few_moved = awake != nullptr && awake->HaveFewMoved();
    if (have_few_moved)
      ++list_->end;
    else
      ++worn_;
    BuildAhead(scene, have_few_moved);
    if (!TrackEscaped(scene, awake)) MakeList(scene);
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
  const auto session = parts_.Begin(work_);
  if (Follow(scene, nullptr) || !parts_are_pairs_) {
    const std::span<const Pair> all = list_->candidates.pairs();
    const std::size_t size = all.size();
    parts_.Run(kTestCost * static_cast<double>(size),
               [&](std::size_t part, std::size_t parts, kernels::PairBuffer& found) {
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
  const auto session = parts_.Begin(work_);
  const SkinAwake& awake = changes_.See(scene);
  if (!Follow(scene, &awake) && changes_.knows_last()) return true;
  parts_are_pairs_ = false;
  rest_.Clear();
  AppendRest(scene, rest_);
  const bool are_changes =
      changes_.Find(scene, kernels_, list_->candidates.pairs(), rest_.pairs(), came, went);
  found_ = changes_.size();
  return are_changes;
}

/// Appends the pairs that are not candidates. Pairs of walls come first, because they are mostly
/// the same in each cycle.
void Skin::AppendRest(const Scene& scene, kernels::PairBuffer& pairs) {
  bodies_.MeetOthers(scene, kernels_, pairs);
  if (untracked_ > 0) AppendUntracked(scene, pairs);
}

/// Number of cycles after which this list ends, because of its age or of escaped boxes. Cycles in
/// which few bodies move do not count.
double Skin::CyclesLeft() const {
  double left = kMaxAge - static_cast<double>(worn_);
  if (list_->goes_on) left = std::min(list_->end + 1 - cycle_, left);
  if (list_->is_guess) left = std::min(list_->life - worn_, left);
  const double limit = kListCost * static_cast<double>(bodies_.movers());
  if (last_escape_cost_ <= 0) return left;
  return std::min(left, (limit - escape_cost_) / (kMoreEscapes * last_escape_cost_));
}

// Builds the next list as late as possible, because its fat boxes must last from the cycle in which
// they are made.
void Skin::BuildAhead(const Scene& scene, bool have_few_moved) {
  if (list_->is_guess && age_ < kSeen) return;
  if (list_->is_guess && age_ == kSeen) return builder_.Observe(scene, cycle_, *list_);
  const double left = CyclesLeft();
  const double movers = static_cast<double>(bodies_.movers());
  double usual = kReadCost * movers + kTestCost * static_cast<double>(list_->candidates.size()) +
                 last_escape_cost_;
  // The lists after a guess may have far fewer candidates: their cycles should not be long either.
  if (list_->is_guess) usual = std::min(usual, kMostOfGuess * movers);
  if (have_few_moved) usual = kCostIfFewMoved * movers;
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
    // Short-lived lists leave too little time to build the next one: extend them where boxes allow
    // it.
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

/// True if all movers have been asleep since the last call, so that the pairs are still the same.
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

/// Builds a whole list in this cycle.
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
  age_ = worn_ = 0;
  is_built_ = true;
  escape_cost_ = last_escape_cost_ = 0;
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

// A list that lasts longer costs less per cycle to build, and more to test.
void Skin::LearnCost(double life) {
  const double age = std::max(age_, 1u), movers = static_cast<double>(bodies_.movers());
  const double each = (cost_ - making_cost_) / age;
  const double cost = making_cost_ / life + each;
  // Checking the boxes is left out, because its cost does not depend on the lifetime.
  const double tests = life * (each - kCheckCost * movers);
  if (!list_->goes_on) {
    last_tried_ = 0;
    // If boxes keep their velocity from now on, the next list may last as long as this one,
    // provided that tests are few.
    if (making_cost_ > 4 * tests || list_->is_guess)
      horizon_ = std::max(horizon_, std::min<double>(life, kMaxAge));
  } else if (life < list_->horizon) {  // ended by escaped bodies
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

using kernels::kMetBits;

void SkinChanges::Forget() {
  knows_last_ = has_flags_ = false;
  awake_.Forget();
  replaced_.clear();
  rest_.clear();
}

void SkinChanges::Replace(std::span<const Pair> candidates) {
  if (!has_flags_) return;
  has_flags_ = false;
  awake_.ForgetIndex();
  for (std::size_t word = 0; word < met_.size(); ++word)
    for (std::uint64_t bits = met_[word]; bits != 0; bits &= bits - 1)
      replaced_.push_back(
          candidates[word * kMetBits + static_cast<std::size_t>(std::countr_zero(bits))]);
}

bool SkinChanges::Find(const Scene& scene, const kernels::Kernels& kernels,
                       std::span<const Pair> candidates, std::span<const Pair> rest,
                       std::vector<Pair>& came, std::vector<Pair>& went) {
  const bool had_flags = has_flags_;
  if (!had_flags) {
    met_.clear();
    met_count_ = 0;
    has_flags_ = true;
  }
  met_.resize((candidates.size() + kMetBits - 1) / kMetBits, 0);
  changed_.clear();
  if (had_flags && awake_.UpdateIndex(scene, candidates))
    FindAwake(scene, candidates);
  else
    FindAll(scene, kernels, candidates);
  awake_.Tested();
  const auto overlaps = [&](const Pair& pair) {
    return Overlap(scene.boxes[pair.a], scene.boxes[pair.b]);
  };
  for (const Pair& pair : changed_) (overlaps(pair) ? came : went).push_back(pair);
  met_count_ = met_count_ + came.size() - went.size();
  for (const Pair& pair : replaced_)
    if (!overlaps(pair)) went.push_back(pair);
  replaced_.clear();
  FindRest(scene, rest, came, went);
  const bool did_know = knows_last_;
  knows_last_ = true;
  return did_know;
}

void SkinChanges::FindAll(const Scene& scene, const kernels::Kernels& kernels,
                          std::span<const Pair> candidates) {
  const std::size_t size = candidates.size();
  parts_.Run(kTestCost * static_cast<double>(size),
             [&](std::size_t part, std::size_t parts, kernels::PairBuffer& found) {
               const std::size_t first = met_.size() * part / parts, begin = first * kMetBits;
               const std::size_t end = std::min(size, met_.size() * (part + 1) / parts * kMetBits);
               kernels.find_changed(scene.boxes.data(), candidates.data() + begin,
                                    met_.data() + first, end - begin, found.sink());
             });
  parts_.AppendTo(changed_);
}

void SkinChanges::FindAwake(const Scene& scene, std::span<const Pair> candidates) {
  awake_.ForEach(candidates, [&](std::size_t i) {
    const Pair& pair = candidates[i];
    const std::uint64_t bit = std::uint64_t{1} << i % kMetBits;
    if (Overlap(scene.boxes[pair.a], scene.boxes[pair.b]) == ((met_[i / kMetBits] & bit) != 0))
      return;
    met_[i / kMetBits] ^= bit;
    changed_.push_back(pair);
  });
}

void SkinChanges::FindRest(const Scene& scene, std::span<const Pair> rest, std::vector<Pair>& came,
                           std::vector<Pair>& went) {
  if (rest.size() == rest_.size() &&
      (rest.empty() || std::memcmp(rest.data(), rest_.data(), rest.size_bytes()) == 0))
    return;
  const auto [is, was] = std::ranges::mismatch(rest, rest_);
  came.insert(came.end(), is, rest.end());
  std::copy_if(was, rest_.end(), std::back_inserter(went), [&](const Pair& pair) {
    return !Overlap(scene.boxes[pair.a], scene.boxes[pair.b]);
  });
  rest_.assign(rest.begin(), rest.end());
}

namespace {

/// Cycles with few moved bodies before the index is made.
constexpr unsigned kPatience = 4;
/// One in so many candidates may have been appended to those in the index.
constexpr std::size_t kAppended = 8;

}  // namespace

void SkinAwake::See(const Scene& scene) {
  if (last_asleep_.size() == scene.size && scene.is_asleep.size() == scene.size) {
    // Writes of bytes may change the members, but not local pointers: so the loop is vectorized.
    const std::uint8_t *asleep = scene.is_asleep.data(), *was_asleep = last_asleep_.data();
    std::uint8_t* moved = may_have_moved_.data();
    for (std::size_t i = 0, size = scene.size; i < size; ++i)
      moved[i] |=
          static_cast<std::uint8_t>(asleep[i] == 0) | static_cast<std::uint8_t>(was_asleep[i] == 0);
  } else {
    may_have_moved_.assign(scene.size, 1);
  }
  moved_count_ = static_cast<std::size_t>(std::ranges::count(may_have_moved_, std::uint8_t{1}));
  last_asleep_.assign(scene.is_asleep.begin(), scene.is_asleep.end());
}

bool SkinAwake::UpdateIndex(const Scene& scene, std::span<const Pair> candidates) {
  if (!HaveFewMoved()) {
    few_cycles_ = 0;
    return false;
  }
  if (++few_cycles_ < kPatience) return false;
  if (indexed_ == 0 || kAppended * (candidates.size() - indexed_) > candidates.size())
    MakeIndex(scene, candidates);
  return true;
}

void SkinAwake::MakeIndex(const Scene& scene, std::span<const Pair> candidates) {
  begins_.assign(scene.size + 2, 0);
  for (const auto& [a, b] : candidates) {
    ++begins_[a + 2];
    ++begins_[b + 2];
  }
  for (std::size_t body = 2; body < begins_.size(); ++body) begins_[body] += begins_[body - 1];
  entries_.resize(2 * candidates.size());
  for (std::size_t i = 0; i < candidates.size(); ++i)
    for (const Id id : {candidates[i].a, candidates[i].b})
      entries_[begins_[id + 1]++] = static_cast<std::uint32_t>(i);
  begins_.pop_back();
  indexed_ = candidates.size();
}

}  // namespace cdb::builtin
