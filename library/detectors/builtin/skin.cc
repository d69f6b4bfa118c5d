#include "library/detectors/builtin/skin.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>

#include "library/detectors/builtin/skin_costs.h"

namespace cdb::builtin {
namespace {

/// Upper bound for the usual cost of a body in a cycle of a first list. In nanoseconds, as in
/// skin_costs.h.
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

}  // namespace cdb::builtin
