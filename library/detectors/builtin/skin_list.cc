#include "library/detectors/builtin/skin_list.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <utility>

namespace cdb::builtin {
namespace {

// In nanoseconds, measured once on one machine: of a mover; of a candidate.
constexpr double kMarkCost = 3, kFattenCost = 14, kQueryCost = 18, kListedCost = 8;
constexpr double kOccupancyCost = 0.25;  ///< of each box in the cell of one that is looked up
/// Fraction of the cycles until a list is used that its fat boxes need not cover. A body that turns
/// round in these cycles is not where it was predicted to be.
constexpr double kHeadStart = 1;
constexpr double kLookUpCost = 100;  ///< of a mover that is looked up on its own
constexpr double kSampleCost = 80;   ///< of a mover in the sample, whose boxes are far apart
constexpr double kFirstCost = 60;
/// Safety factor: the next list may cost more than the last.
constexpr double kSurplus = 1.1;
/// The most movers that are looked up in one step; the movers of a slice, after which a search
/// checks for crowds.
constexpr std::size_t kChunk = 4096, kSlice = 256;
/// The number of movers whose cells are assumed to hold as many boxes as that of the first; an
/// eighth of it if that cell holds kCrowded or more.
constexpr std::size_t kGlance = 64;
constexpr double kCrowded = 64;
/// Candidates per mover above which fat boxes are made smaller; candidates of a slice above which
/// the search stops at once.
constexpr std::size_t kMostCandidates = 24, kMostOfSlice = 8 * kMostCandidates * kSlice;
/// If a first list has more candidates than intended by this factor, its fat boxes are made
/// smaller.
constexpr double kFarMore = 1.25;
/// Typical number of candidates per mover in the list after a guess.
constexpr double kUsualCandidates = 4;
/// The share of the expected motion is divided by four each time, down to this.
constexpr double kLeastShare = 1. / 256;

std::size_t StepOf(double budget, double cost, std::size_t left) {
  const double most = budget / cost;
  if (most >= static_cast<double>(left)) return left;
  constexpr std::size_t kBlock = PastBoxes::kBlock;
  return std::min(left, (static_cast<std::size_t>(std::max(most, 0.)) / kBlock + 1) * kBlock);
}

}  // namespace

void SkinList::Reserve(const Scene& scene, std::size_t movers) {
  fat.resize(movers);
  past.Resize(scene.size);
  grid.Reserve(movers);
}

void SkinListBuilder::Prepare(const Scene& scene, std::size_t movers) {
  next_->Reserve(scene, movers);
  movers_ = movers;
  stage_ = Stage::kIdle;
  motion_.Prepare(movers);
  share_ = 1;
  whole_cost_ = kFirstCost * static_cast<double>(movers);
}

void SkinListBuilder::Start(const Scene& scene, const kernels::Bodies& bodies, const Plan& plan,
                            const SkinList* last) {
  movers_ = bodies.movers();
  plan_ = plan;
  last_ = last;
  next_->Reserve(scene, movers_);
  next_->candidates.Clear();
  if (last != nullptr) next_->candidates.Reserve(last->candidates.size() * 3 / 2);
  next_->horizon = plan.horizon;
  next_->end = plan.begin + plan.horizon;
  next_->is_guess = last == nullptr;
  next_->life = kUnlimited;
  // Recovers from a reduced share gradually: bodies that jump about would get boxes as large as the
  // scene.
  share_ = std::min(4 * share_, 1.);
  cursor_ = learnt_ = found_ = 0;
  spent_ = 0;
  if (last == nullptr) {
    motion_.Guess(scene, movers_);
    learnt_ = movers_;
    last_found_ = 0;
    stage_ = Stage::kFatten;
  } else {
    next_->grid.TakeShape(last->grid);
    motion_.StartSampling();
    stage_ = Stage::kSample;
  }
}

void SkinListBuilder::Observe(const Scene& scene, std::uint32_t cycle, SkinList& guess) {
  guess.life = std::sqrt(share_) * motion_.Observe(scene, movers_, guess.past, cycle);
}

double SkinListBuilder::Mark(const Scene& scene, std::uint32_t cycle, double budget) {
  const std::size_t begin = motion_.marked(), step = StepOf(budget, kMarkCost, movers_ - begin);
  if (step > 0) motion_.Mark(scene, begin, begin + step, cycle);
  return kMarkCost * static_cast<double>(step);
}

double SkinListBuilder::CostLeft() const {
  return std::max(whole_cost_ - spent_, kLeastShare * whole_cost_);
}

bool SkinListBuilder::Advance(const Scene& scene, const kernels::Bodies& bodies,
                              std::uint32_t cycle, double& budget) {
  const double before = budget;
  double left = budget;
  while (stage_ != Stage::kDone && left > 0) {
    switch (stage_) {
      case Stage::kIdle:
      case Stage::kDone:
        return false;
      case Stage::kSample:
        Sample(scene, cycle, left);
        break;
      case Stage::kFatten:
        Fatten(scene, cycle, left);
        break;
      case Stage::kArrange:
        if (next_->grid.Arrange(left)) {
          stage_ = Stage::kQuery;
          cursor_ = 0;
        }
        break;
      case Stage::kQuery:
        Query(scene, bodies, left);
        if (stage_ == Stage::kQuery && cursor_ == LookUps(bodies)) stage_ = Stage::kDone;
        break;
    }
  }
  budget = left;
  spent_ += before - left;
  return stage_ == Stage::kDone;
}

void SkinListBuilder::Sample(const Scene& scene, std::uint32_t cycle, double& budget) {
  const double count = std::ceil(
      std::min(budget / kSampleCost, static_cast<double>(SkinMotion::SampleSize(movers_))));
  if (motion_.Sample(scene, movers_, last_->past, cycle, static_cast<std::size_t>(count)))
    stage_ = Stage::kFatten;
  budget -= kSampleCost * count;
}

void SkinListBuilder::Fatten(const Scene& scene, std::uint32_t cycle, double& budget) {
  const std::size_t begin = cursor_, end = begin + StepOf(budget, kFattenCost, movers_ - begin);
  const kernels::Columns& room = next_->grid.Room(movers_);
  const double until_use = plan_.begin > cycle ? plan_.begin - cycle : 0;
  // Velocities are rounded: no body should reach the end of its fat box in the last cycle.
  const double cycles = until_use + plan_.horizon + 0.5;
  // A list after a guess is used as soon as it is done.
  const double until_begin =
      last_ == nullptr || last_->is_guess ? 0 : std::max(kHeadStart * until_use - 1, 0.);
  const std::uint32_t age =
      last_ != nullptr && begin < movers_ ? cycle - last_->past.CycleOf(begin) : 1;
  const SkinMotion::Span span = {until_begin, cycles, cycles / std::max(age, 1u), share_};
  const double work = kFattenCost * static_cast<double>(end - begin);
  parts_.ForEach(work, begin, end, PastBoxes::kBlock,
                 [&](unsigned, std::size_t from, std::size_t to) {
                   if (last_ != nullptr && learnt_ <= from)
                     motion_.LearnBodies(scene, from, to, last_->past, cycle);
                   motion_.Fatten(scene, from, to, span, next_->fat.data(), room, next_->past);
                   next_->past.SetCycle(from, to, cycle);
                 });
  learnt_ = std::max(learnt_, end);
  budget -= work;
  cursor_ = end;
  if (cursor_ < movers_) return;
  next_->grid.StartArranging(movers_);
  stage_ = Stage::kArrange;
}

/// Calls look_up(from, to, pairs) for slices of the next `step` look-ups and appends what it finds
/// to the candidates. Reduces the budget by `cost` and by that of listing pairs; makes the fat
/// boxes smaller instead if they are too fat.
template <typename LookUp>
void SkinListBuilder::FindCandidates(const Scene& scene, const kernels::Bodies& bodies,
                                     std::size_t step, double cost, const LookUp& look_up,
                                     double& budget) {
  const std::size_t begin = cursor_, end = begin + step;
  std::atomic<bool> is_crowd = false;
  std::atomic<std::size_t> listed = 0;
  parts_.Run(cost, [&](std::size_t part, std::size_t parts, kernels::PairBuffer& found) {
    // Slices are the same for any number of parts.
    const std::size_t slices = (step + kSlice - 1) / kSlice;
    for (std::size_t i = slices * part / parts; i < slices * (part + 1) / parts; ++i) {
      const std::size_t from = begin + i * kSlice, size = found.size();
      if (is_crowd) return;
      look_up(from, std::min(from + kSlice, end), found);
      if (share_ > 0 && found.size() - size > kMostOfSlice) is_crowd = true;
    }
    listed += found.size();
    bodies.Sieve(scene, true, found);
  });
  if (is_crowd) return Shrink();
  parts_.AppendTo(next_->candidates);
  // A guess assumes that boxes are spread evenly, and makes them too fat if they are not.
  const double most = next_->is_guess && share_ == 1
                          ? std::min<double>(kFarMore * motion_.guessed(), kMostCandidates)
                          : kMostCandidates;
  if (share_ > 0 &&
      static_cast<double>(next_->candidates.size()) > most * static_cast<double>(end + kSlice))
    return Shrink();
  found_ += listed;
  cursor_ = end;
  budget -= cost + kListedCost * static_cast<double>(listed);
}

/// Number of bodies whose pairs are looked up in the grid.
std::size_t SkinListBuilder::LookUps(const kernels::Bodies& bodies) const {
  return bodies.HasFewFree() ? bodies.free().size() : next_->grid.Size();
}

void SkinListBuilder::Query(const Scene& scene, const kernels::Bodies& bodies, double& budget) {
  if (bodies.HasFewFree()) return QueryFree(scene, bodies, budget);
  const double seen =
      static_cast<double>(found_) / static_cast<double>(std::max<std::size_t>(cursor_, 1));
  const double listed = kListedCost * std::max(seen, last_found_);
  const std::size_t left = std::min(next_->grid.Size() - cursor_, kChunk);
  std::size_t step = 0;
  double cost = 0;
  while (step < left && cost + listed * static_cast<double>(step) <= budget) {
    const auto occupancy = static_cast<double>(next_->grid.OccupancyAt(cursor_ + step));
    const double each = kQueryCost + kOccupancyCost * occupancy;
    const double spare = budget - cost - listed * static_cast<double>(step);
    const auto affordable = static_cast<std::size_t>(std::min(spare / (each + listed), 1e6)) + 1;
    const std::size_t size =
        std::min({left - step, occupancy < kCrowded ? kGlance : kGlance / 8, affordable});
    cost += each * static_cast<double>(size);
    step += size;
  }
  const auto look_up = [&](std::size_t from, std::size_t to, kernels::PairBuffer& found) {
    next_->grid.Query(from, to, found.sink());
  };
  FindCandidates(scene, bodies, step, cost, look_up, budget);
}

/// Looks up only the bodies that are not fixed, if these are few.
void SkinListBuilder::QueryFree(const Scene& scene, const kernels::Bodies& bodies, double& budget) {
  const std::vector<Id>& free = bodies.free();
  const double affordable = std::min(budget / kLookUpCost, static_cast<double>(kChunk)) + 1;
  const std::size_t step = std::min(free.size() - cursor_, static_cast<std::size_t>(affordable));
  const auto look_up = [&](std::size_t from, std::size_t to, kernels::PairBuffer& found) {
    const std::size_t before = found.size();
    for (std::size_t i = from; i < to; ++i)
      next_->grid.QueryOne(next_->fat[free[i]], free[i], found.sink());
    // A pair of two of them is found from both.
    const std::span<Pair> pairs = found.pairs().subspan(before);
    const auto rest = std::ranges::remove_if(pairs, [&](const Pair& pair) {
      return pair.a == pair.b || (pair.b < pair.a && !scene.filters[pair.b].is_fixed);
    });
    found.Cut(found.size() - rest.size());
    for (Pair& pair : found.pairs().subspan(before))
      if (pair.b < pair.a) std::swap(pair.a, pair.b);
  };
  FindCandidates(scene, bodies, step, kLookUpCost * static_cast<double>(step), look_up, budget);
}

void SkinListBuilder::Shrink() {
  share_ = share_ > kLeastShare ? share_ / 4 : 0;
  spent_ = 0;  // the work so far is discarded
  next_->grid.Reshape();
  next_->candidates.Clear();
  cursor_ = found_ = 0;
  stage_ = Stage::kFatten;
}

void SkinListBuilder::Take(std::unique_ptr<SkinList>& list) {
  share_ = std::max(share_, kLeastShare);
  next_->goes_on = motion_.goes_on();
  const auto listed = static_cast<double>(next_->candidates.size());
  // The list after a guess will not have as many candidates.
  const double fewer =
      next_->is_guess ? std::max(listed - kUsualCandidates * static_cast<double>(movers_), 0.) : 0;
  whole_cost_ = kSurplus * (spent_ - kListedCost * fewer);
  last_found_ =
      static_cast<double>(found_) / static_cast<double>(std::max<std::size_t>(movers_, 1));
  stage_ = Stage::kIdle;
  last_ = nullptr;
  motion_.ForgetMarks();
  std::swap(next_, list);
}

}  // namespace cdb::builtin
