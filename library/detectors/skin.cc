#include "library/detectors/skin.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>

namespace cdb::library {
namespace {

// In nanoseconds, measured once on one machine; only their ratios matter.
constexpr double kGridCost = 38;                   ///< of a body in a cycle of `grid`
constexpr double kListCost = 80, kListedCost = 1;  ///< of making a list: a body, a candidate
constexpr double kCrowdCost = 0.1;                 ///< of each other body in a cell, or too long
constexpr double kCheckCost = 3, kTestCost = 2.2, kStrayCost = 100;

/// A list is made anew after so many cycles at the latest: what came to rest gets thin again.
constexpr unsigned kMaxAge = 256;

constexpr std::size_t kSample = 512;
/// Of a body, above which boxes get less fat; looked at after so many bodies.
constexpr std::size_t kMostCandidates = 24, kSlice = 256;
/// Boxes get less fat in quarters, down to this.
constexpr double kLeastShare = 1. / 256;
/// Deviations of all but a quarter, times this, hold nearly all of what jitters evenly.
constexpr double kMarginFactor = 1.6;
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
bool Overlap(const FatBox& a, const FatBox& b) {
  for (int axis = 0; axis < 3; ++axis)
    if (!(a.lower[axis] <= b.upper[axis] && b.lower[axis] <= a.upper[axis])) return false;
  return true;
}

}  // namespace

Skin::Skin(const Options& options, const Kernels& kernels)
    : kernels_(kernels), grid_(kernels), stray_grid_(kernels), parts_(options.threads) {}

void Skin::Prepare(const Scene& scene) {
  bodies_.Learn(scene);
  is_built_ = false;
  velocity_.assign(bodies_.movers(), {0, 0, 0});
  goes_on_ = false;
  share_ = 1;
  margin_ = most_margin_ = 0;
  last_cost_ = last_tried_ = 0;
}

void Skin::FindPairs(const Scene& scene, std::vector<Pair>& pairs) {
  if (scene.size != built_.size()) Prepare(scene);
  const std::size_t movers = bodies_.movers();
  if (is_built_) {
    ++age_;
    if (pairs_are_of_built_ && IsUnchanged(scene)) {
      parts_.AppendTo(pairs);
      return;
    }
  }
  std::size_t strays = 0;
  const bool is_over = !is_built_ || age_ >= kMaxAge || (goes_on_ && age_ > horizon_);
  if (!is_over) {
    strays = kernels_.find_strays(scene.boxes.data(), fat_.data(), movers, strays_.data());
    const double stray_cost = static_cast<double>(strays) * kStrayCost;
    stray_cost_ += stray_cost;
    cost_ += stray_cost;
  }
  if (is_over || stray_cost_ > kListCost * static_cast<double>(movers)) {
    MakeList(scene);
    strays = 0;
  }
  const std::span<const Pair> all = candidates_.pairs();
  cost_ += kCheckCost * static_cast<double>(movers) + kTestCost * static_cast<double>(all.size());
  parts_.Run(all.size() / 16, [&](unsigned part, unsigned parts, PairBuffer& found) {
    const std::size_t begin = all.size() * part / parts, end = all.size() * (part + 1) / parts;
    kernels_.filter(scene.boxes.data(), all.data() + begin, end - begin, found.sink());
  });
  if (strays > 0) AppendStrays(scene, strays, parts_.last());
  bodies_.MeetWalls(scene, kernels_, parts_.last());
  pairs_are_of_built_ = age_ == 0;
  parts_.AppendTo(pairs);
}

bool Skin::IsUnchanged(const Scene& scene) const {
  return built_.empty() ||
         std::memcmp(scene.boxes.data(), built_.data(), built_.size() * sizeof(Box)) == 0;
}

// Candidates are all pairs whose fat boxes overlap, so what a stray has to add are pairs whose fat
// boxes do not. Other strays are met apart: they are not where the grid has them.
void Skin::AppendStrays(const Scene& scene, std::size_t count, PairBuffer& pairs) {
  const auto put = [&](Id a, Id b) {
    if (!Overlap(scene.boxes[a], scene.boxes[b]) || Overlap(fat_[a], fat_[b]) ||
        !scene.MayCollide(a, b))
      return;
    PairSink& sink = pairs.sink();
    if (sink.at == sink.end) sink.grow(sink);
    *sink.at++ = {std::min(a, b), std::max(a, b)};
  };
  raw_.Clear();
  stray_boxes_.clear();
  for (std::size_t i = 0; i < count; ++i) is_stray_[strays_[i]] = 1;
  for (std::size_t i = 0; i < count; ++i) {
    grid_.QueryOne(scene.boxes[strays_[i]], strays_[i], raw_.sink());
    stray_boxes_.push_back(scene.boxes[strays_[i]]);
  }
  for (const Pair& pair : raw_.pairs())
    if (!is_stray_[pair.b]) put(pair.a, pair.b);
  for (std::size_t i = 0; i < count; ++i) is_stray_[strays_[i]] = 0;
  raw_.Clear();
  stray_grid_.Build(stray_boxes_.data(), count);
  stray_grid_.QueryPart(0, 1, raw_.sink());
  for (const Pair& pair : raw_.pairs()) put(strays_[pair.a], strays_[pair.b]);
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
  fat_.resize(movers);
  strays_.resize(movers);
  is_stray_.assign(movers, 0);
  // Bodies that jump about would get boxes as large as the scene: less, then.
  share_ = std::min(4 * share_, 1.);
  for (Fatten(scene); !FindCandidates(scene, share_ > 0); Fatten(scene)) {
    share_ = share_ > kLeastShare ? share_ / 4 : 0;
    grid_.Reshape();
  }
  share_ = std::max(share_, kLeastShare);
  LearnVelocities(scene);
  std::ranges::copy(scene.boxes, built_.begin());
  candidates_.Clear();
  parts_.AppendTo(candidates_);
  age_ = 0;
  is_built_ = true;
  stray_cost_ = 0;
  cost_ = making_cost_ =
      (kListCost + kCrowdCost * (grid_.Crowd() + static_cast<double>(grid_.TooLong()))) *
          static_cast<double>(movers) +
      kListedCost * static_cast<double>(candidates_.size());
}

/// False if it is limited and there are far too many.
bool Skin::FindCandidates(const Scene& scene, bool is_limited) {
  grid_.Arrange(bodies_.movers());
  std::atomic<bool> is_too_much = false;
  parts_.Run(bodies_.movers(), [&](unsigned part, unsigned parts, PairBuffer& found) {
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
  const double crowd = grid_.Crowd() + static_cast<double>(grid_.TooLong());
  return kGridCost + kCrowdCost * crowd +
         kListedCost * static_cast<double>(parts_.size()) / static_cast<double>(bodies_.movers());
}

// A longer list costs less to make a cycle and more to test.
void Skin::LearnCost() {
  last_cost_ = cost_ / age_;
  if (!goes_on_) {
    last_tried_ = 0;
  } else if (age_ < horizon_) {  // strays ended it
    horizon_ = std::max(age_ / 1.25, 1.);
    step_ = 1.2;
    last_tried_ = 0;
  } else {
    if (making_cost_ >
        4 * (cost_ - making_cost_ - kCheckCost * age_ * static_cast<double>(bodies_.movers()))) {
      step_ = 3;
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
    const std::size_t i = most < movers ? SamplePlace(k, movers) : k;
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
  goes_on_ = at(going, 0.75) < at(resting, 0.75) / 2;
  double* deviations = goes_on_ ? going : resting;
  margin_ = kMarginFactor * at(deviations, 0.75);
  // Who goes on and yet deviated was turned round once; it will not be all the time.
  most_margin_ = goes_on_ ? margin_ : kMarginFactor * at(deviations, 0.95);
  most_speed_ = 16 * speed / static_cast<double>(size);
}

// The grid takes fat boxes as the floats that they are, so it finds their pairs exactly.
void Skin::Fatten(const Scene& scene) {
  const std::size_t movers = bodies_.movers();
  const Columns& room = grid_.Room(movers);
  const double time = goes_on_ ? share_ * horizon_ : 0, most_way = most_speed_ * time;
  const double cycles = goes_on_ ? age_ : 0, each = 1. / age_;
  for (std::size_t i = 0; i < movers; ++i) {
    const Box& box = scene.boxes[i];
    const Vec3 shift = Shift(built_[i], box);
    const double own = kOwnMarginFactor * Length(Rest(shift, velocity_[i], cycles));
    // In this order what is not a number is left out.
    const double margin = share_ * std::max(margin_, own < most_margin_ ? own : most_margin_);
    const auto fatten = [&](std::size_t axis, double lower, double upper, double velocity) {
      double way = velocity * time;
      way = way < most_way ? way : most_way;
      way = way > -most_way ? way : -most_way;
      // A float is off by less than the last term.
      fat_[i].lower[axis] = room.lower[axis][i] =
          static_cast<float>(lower + (way < 0 ? way : 0) - margin - std::fabs(lower) * 0x1p-23);
      fat_[i].upper[axis] = room.upper[axis][i] =
          static_cast<float>(upper + (way > 0 ? way : 0) + margin + std::fabs(upper) * 0x1p-23);
    };
    fatten(0, box.lower.x, box.upper.x, shift.x * each);
    fatten(1, box.lower.y, box.upper.y, shift.y * each);
    fatten(2, box.lower.z, box.upper.z, shift.z * each);
  }
}

void Skin::LearnVelocities(const Scene& scene) {
  const double each = 1. / age_;
  for (std::size_t i = 0; i < bodies_.movers(); ++i) {
    const Vec3 shift = Shift(built_[i], scene.boxes[i]);
    velocity_[i] = {shift.x * each, shift.y * each, shift.z * each};
  }
}

std::unique_ptr<Detector> MakeSkin(const Options& options, const Kernels& kernels) {
  return std::make_unique<Skin>(options, kernels);
}

}  // namespace cdb::library
