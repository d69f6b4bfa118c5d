#include "library/detectors/builtin/skin_motion.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace cdb::builtin {
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
