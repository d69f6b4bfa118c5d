#include "library/detectors/builtin/skin_list.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <limits>
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

namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr std::size_t kLeastSample = 64;
/// The 75th percentile of deviations times this covers nearly all bodies that jitter uniformly.
constexpr double kMarginFactor = 1.6;
/// The same for the median.
constexpr double kHalfMarginFactor = 2.7;
/// Candidates per body that a first list may have, if boxes were spread evenly; or, if more, this
/// factor times the pairs.
constexpr double kGuessedMost = 5, kGuessedFactor = 1.25;
/// Margins in mean sides: the largest usual one, and the largest one, which is tried if it leaves
/// at most kFewCandidates per body.
constexpr double kUsualGuess = 0.7, kMostGuess = 4, kFewCandidates = 0.2;

Vec3 Shift(const Box& from, const Box& to) {
  return {(to.lower.x - from.lower.x + to.upper.x - from.upper.x) / 2,
          (to.lower.y - from.lower.y + to.upper.y - from.upper.y) / 2,
          (to.lower.z - from.lower.z + to.upper.z - from.upper.z) / 2};
}
double Length(const Vec3& displacement) {
  return std::max(std::max(std::fabs(displacement.x), std::fabs(displacement.y)),
                  std::fabs(displacement.z));
}
/// The part of a displacement that is not explained by a constant velocity.
Vec3 Rest(const Vec3& shift, const Vec3& velocity, double cycles) {
  return {shift.x - velocity.x * cycles, shift.y - velocity.y * cycles,
          shift.z - velocity.z * cycles};
}
Vec3 Scaled(const Vec3& displacement, double by) {
  return {displacement.x * by, displacement.y * by, displacement.z * by};
}

/// The largest displacement by which a box is enlarged, in m. Infinite ones would make NaN boxes.
constexpr double kMostDisplacement = 1e300;

Vec3 VelocityOf(const kernels::BodyMotion& motion) {
  return {motion.velocity[0], motion.velocity[1], motion.velocity[2]};
}

std::size_t SampledBody(std::size_t k, std::size_t movers) {
  return SkinMotion::SampleSize(movers) < movers ? kernels::SampleIndex(k, movers) : k;
}

/// A sample of the finite boxes: the mean of their sides, and twice the distance between their
/// quartiles.
struct Spread {
  Vec3 side = {}, width = {};
  bool is_known = false;
};
Spread SpreadOf(const Scene& scene, std::size_t movers) {
  constexpr std::size_t kMost = 256;
  Spread spread;
  for (const auto axis : {&Vec3::x, &Vec3::y, &Vec3::z}) {
    std::vector<double> corners;
    const std::size_t size = std::min(movers, kMost);
    for (std::size_t k = 0; k < size; ++k) {
      const Box& box = scene.boxes[size < movers ? kernels::SampleIndex(k, movers) : k];
      const double side = box.upper.*axis - box.lower.*axis;
      if (!std::isfinite(side)) continue;
      corners.push_back(box.lower.*axis);
      spread.side.*axis += side;
    }
    if (corners.size() < 4) return {};
    std::ranges::sort(corners);
    spread.side.*axis /= static_cast<double>(corners.size());
    spread.width.*axis = 2 * (corners[corners.size() * 3 / 4] - corners[corners.size() / 4]);
  }
  spread.is_known = true;
  return spread;
}

}  // namespace

void PastBoxes::SetCycle(std::size_t begin, std::size_t end, std::uint32_t cycle) {
  for (std::size_t block = begin / kBlock; block * kBlock < end; ++block) cycles[block] = cycle;
}

std::size_t SkinMotion::SampleSize(std::size_t movers) {
  return std::min(movers, std::clamp(movers / 24, kLeastSample, kMostSample));
}

void SkinMotion::Prepare(std::size_t movers) {
  goes_on_ = false;
  marked_ = 0;
  margin_ = most_margin_ = most_speed_ = 0;
  motions_.assign(movers, {});
  marks_.Resize(movers);
}

void SkinMotion::Guess(const Scene& scene, std::size_t movers) {
  goes_on_ = false;
  marked_ = 0;
  margin_ = 0;
  guessed_ = kGuessedMost;
  observed_.clear();
  const Spread spread = SpreadOf(scene, movers);
  const auto candidates = [&](double margin) {
    double share = static_cast<double>(movers) / 2;
    for (const auto axis : {&Vec3::x, &Vec3::y, &Vec3::z}) {
      const double reach = 2 * (spread.side.*axis + 2 * margin);
      share *= std::min(1., reach / std::max(spread.width.*axis, 1e-300));
    }
    return share;
  };
  const double side = Length(spread.side);
  if (spread.is_known && side > 0 && side < kInfinity) {
    const double most = std::max(kGuessedFactor * candidates(0), kGuessedMost);
    guessed_ = most;
    for (double margin = side / 64; margin <= kMostGuess * side; margin *= 1.25)
      if (candidates(margin) <= (margin <= kUsualGuess * side ? most : kFewCandidates))
        margin_ = margin;
  }
  most_margin_ = margin_;
  std::ranges::fill(motions_, kernels::BodyMotion{{0, 0, 0}, margin_});
}

double SkinMotion::Observe(const Scene& scene, std::size_t movers, const PastBoxes& past,
                           std::uint32_t cycle) {
  observed_.clear();
  observed_in_ = cycle;
  std::vector<double> speeds;
  for (std::size_t k = 0; k < SampleSize(movers); ++k) {
    const std::size_t i = SampledBody(k, movers);
    observed_.push_back(scene.boxes[i]);
    const double speed =
        Length(Shift(past.boxes[i], scene.boxes[i])) / std::max(cycle - past.CycleOf(i), 1u);
    if (std::isfinite(speed)) speeds.push_back(speed);
  }
  if (speeds.empty()) return kInfinity;
  const auto most = speeds.begin() + static_cast<std::ptrdiff_t>(speeds.size() * 19 / 20);
  std::nth_element(speeds.begin(), most, speeds.end());
  return *most > 0 ? margin_ / *most : kInfinity;
}

bool SkinMotion::Sample(const Scene& scene, std::size_t movers, const PastBoxes& past,
                        std::uint32_t cycle, std::size_t count) {
  const std::size_t all = SampleSize(movers), end = sampled_ + std::min(count, all - sampled_);
  for (; sampled_ < end; ++sampled_) {
    const std::size_t i = SampledBody(sampled_, movers);
    const double cycles = cycle - past.CycleOf(i);
    if (cycles == 0) continue;
    const Vec3 shift = Shift(past.boxes[i], scene.boxes[i]);
    const std::uint32_t observed = observed_in_ - past.CycleOf(i);
    const Vec3 velocity = observed_.empty() || observed == 0
                              ? VelocityOf(motions_[i])
                              : Scaled(Shift(past.boxes[i], observed_[sampled_]), 1. / observed);
    const double stayed = Length(shift), went = Length(Rest(shift, velocity, cycles));
    if (!std::isfinite(stayed + went)) continue;
    resting_[sample_size_] = stayed;
    going_[sample_size_++] = went;
    sample_speed_ += stayed / cycles;
  }
  if (sampled_ < all) return false;
  Judge();
  return true;
}

/// Judges both motion models by the sample.
void SkinMotion::Judge() {
  observed_.clear();
  const std::size_t size = sample_size_;
  if (size == 0) return;
  const auto at = [size](std::array<double, kMostSample>& values, double share) {
    const auto place = static_cast<std::ptrdiff_t>(share * static_cast<double>(size));
    const auto end = values.begin() + static_cast<std::ptrdiff_t>(size);
    std::nth_element(values.begin(), values.begin() + place, end);
    return *(values.begin() + place);
  };
  goes_on_ = at(going_, 0.75) < at(resting_, 0.75) / 2 || at(going_, 0.5) < at(resting_, 0.5) / 2;
  std::array<double, kMostSample>& deviations = goes_on_ ? going_ : resting_;
  margin_ = kMarginFactor * at(deviations, 0.75);
  // Many bodies turn round during a long list; they must not decide for the others.
  if (goes_on_) margin_ = std::min(margin_, kHalfMarginFactor * at(deviations, 0.5));
  // If boxes keep their velocity, a body that deviated has turned round once, and will not do so in
  // every cycle.
  most_margin_ = goes_on_ ? margin_ : kMarginFactor * at(deviations, 0.95);
  most_speed_ = 16 * sample_speed_ / static_cast<double>(size);
}

void SkinMotion::Mark(const Scene& scene, std::size_t begin, std::size_t end, std::uint32_t cycle) {
  std::copy(scene.boxes.begin() + static_cast<std::ptrdiff_t>(begin),
            scene.boxes.begin() + static_cast<std::ptrdiff_t>(end),
            marks_.boxes.begin() + static_cast<std::ptrdiff_t>(begin));
  marks_.SetCycle(begin, end, cycle);
  marked_ = end;
}

// A body that turned round keeps the velocity that it had at the end of the list. For the others,
// all cycles are used, because boxes are rounded and a longer time gives a smaller error.
void SkinMotion::LearnBodies(const Scene& scene, std::size_t begin, std::size_t end,
                             const PastBoxes& past, std::uint32_t cycle) {
  for (std::size_t i = begin; i < end; i += PastBoxes::kBlock) {
    const std::uint32_t age = cycle - past.CycleOf(i);
    if (age == 0) continue;  // no time has passed
    const std::uint32_t recent_age = i < marked_ ? cycle - marks_.CycleOf(i) : 0;
    const bool was_marked = recent_age > 0 && recent_age < age;
    kernels_.learn(scene.boxes.data() + i, past.boxes.data() + i, marks_.boxes.data() + i,
                   std::min(PastBoxes::kBlock, end - i),
                   {.predicted = goes_on_ ? static_cast<double>(age) : 0.,
                    .per_age = 1. / age,
                    .per_recent_age = was_marked ? 1. / recent_age : 0.,
                    .margin = margin_,
                    .most_margin = most_margin_},
                   motions_.data() + i);
  }
}

// Fat boxes consist of floats, which the grid uses unchanged, so that it finds their pairs exactly.
void SkinMotion::Fatten(const Scene& scene, std::size_t begin, std::size_t end, const Span& span,
                        kernels::FatBox* fat, const kernels::Columns& columns,
                        PastBoxes& past) const {
  const double share = goes_on_ ? span.share : 0;
  const double to = share * span.to;
  kernels_.fatten(
      scene.boxes.data() + begin, motions_.data() + begin, end - begin,
      {.from = share * span.from,
       .to = to,
       .most_displacement =
           std::isfinite(most_speed_) ? std::min(most_speed_ * to, kMostDisplacement) : 0,
       .margin = (goes_on_ ? std::max(span.longer, 1.) : 1) * span.share},
      fat + begin, kernels::From(columns, begin), past.boxes.data() + begin);
}

}  // namespace cdb::builtin
