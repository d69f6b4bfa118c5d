#include "library/detectors/skin.h"

#include <algorithm>
#include <cmath>
#include <cstring>

namespace cdb::library {
namespace {

// In nanoseconds, measured once on one machine; only their ratios matter.
constexpr double kGridCost = 45;                   ///< of a body in a cycle of `grid`
constexpr double kListCost = 65, kListedCost = 4;  ///< of making a list: a body, a candidate
constexpr double kCheckCost = 2.5, kTestCost = 1.2, kStrayCost = 150;

/// A list is made anew after so many cycles at the latest: what came to rest gets thin again.
constexpr unsigned kMaxAge = 256;
/// Margins, in mean deviations: all of what jitters evenly lies in three.
constexpr double kMarginFactor = 3.5;

Vec3 Shift(const Box& from, const Box& to) {
  return {(to.lower.x - from.lower.x + to.upper.x - from.upper.x) / 2,
          (to.lower.y - from.lower.y + to.upper.y - from.upper.y) / 2,
          (to.lower.z - from.lower.z + to.upper.z - from.upper.z) / 2};
}
double Length(double x, double y, double z) { return std::fabs(x) + std::fabs(y) + std::fabs(z); }

}  // namespace

Skin::Skin(const Options& options, const Kernels& kernels)
    : kernels_(kernels), grid_(kernels), stray_grid_(kernels), parts_(options.threads) {}

void Skin::Prepare(const Scene& scene) {
  bodies_.Learn(scene);
  is_built_ = knows_motion_ = false;
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
  const Candidates candidates = {anchors_.data(), starts_.data(), partners_.data(),
                                 anchors_.size()};
  cost_ +=
      kCheckCost * static_cast<double>(movers) + kTestCost * static_cast<double>(partners_.size());
  parts_.Run(partners_.size() / 8, [&](unsigned part, unsigned parts, PairBuffer& found) {
    kernels_.filter(scene.boxes.data(), candidates, candidates.count * part / parts,
                    candidates.count * (part + 1) / parts, found.sink());
  });
  if (strays > 0) AppendStrays(scene, strays, parts_.last());
  bodies_.MeetWalls(scene, kernels_, parts_.last());
  pairs_are_of_built_ = age_ == 0;
  parts_.AppendTo(pairs);
}

bool Skin::IsUnchanged(const Scene& scene) const {
  return std::memcmp(scene.boxes.data(), built_.data(), built_.size() * sizeof(Box)) == 0;
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
  stray_grid_.QueryPart(0, 1, false, raw_.sink());
  for (const Pair& pair : raw_.pairs()) put(strays_[pair.a], strays_[pair.b]);
}

void Skin::MakeList(const Scene& scene) {
  const std::size_t movers = bodies_.movers();
  if (is_built_) LearnCost();
  if (is_built_) LearnMotion(scene);
  built_.resize(scene.size);
  fat_.resize(movers);
  velocity_.resize(movers);
  strays_.resize(movers + 8);
  is_stray_.assign(movers, 0);
  Fatten(scene);
  std::copy(scene.boxes.begin(), scene.boxes.end(), built_.begin());
  grid_.Build(fat_.data(), movers);
  parts_.Run(movers, [&](unsigned part, unsigned parts, PairBuffer& found) {
    grid_.QueryPart(part, parts, true, found.sink());
    bodies_.Sieve(scene, true, found);
  });
  anchors_.clear();
  starts_.clear();
  partners_.resize(parts_.size());
  std::uint32_t at = 0;
  parts_.ForEach([&](const Pair& pair) {
    if (anchors_.empty() || anchors_.back() != pair.a) {
      anchors_.push_back(pair.a);
      starts_.push_back(at);
    }
    partners_[at++] = pair.b;
  });
  starts_.push_back(at);
  age_ = 0;
  stray_cost_ = 0;
  is_built_ = true;
  cost_ = kListCost * static_cast<double>(movers) + kListedCost * static_cast<double>(at);
}

void Skin::LearnCost() {
  const double cost = cost_ / age_;
  relative_cost_ = cost / (kGridCost * static_cast<double>(bodies_.movers()));
  if (goes_on_ && age_ + 1 >= horizon_) {
    if (last_cost_ > 0 && cost > last_cost_) step_ = 1 / step_;
    last_cost_ = cost;
    horizon_ = std::clamp(horizon_ * step_, 1., static_cast<double>(kMaxAge));
  } else {
    last_cost_ = 0;
  }
}

// Both ways to foresee where boxes go are judged by where they went.
void Skin::LearnMotion(const Scene& scene) {
  const std::size_t movers = bodies_.movers();
  double resting = 0, going = 0, speed = 0;
  std::size_t counted = 0;
  for (std::size_t i = 0; i < movers; ++i) {
    const Vec3 shift = Shift(built_[i], scene.boxes[i]);
    Vec3& velocity = velocity_[i];
    const double stayed = Length(shift.x, shift.y, shift.z);
    const double went = Length(shift.x - velocity.x * age_, shift.y - velocity.y * age_,
                               shift.z - velocity.z * age_);
    velocity = {shift.x / age_, shift.y / age_, shift.z / age_};
    if (!std::isfinite(stayed + went)) {
      velocity = {0, 0, 0};
      continue;
    }
    resting += stayed;
    going += went;
    speed += stayed / age_;
    ++counted;
  }
  const double share = counted > 0 ? 1 / (3. * static_cast<double>(counted)) : 0;
  goes_on_ = knows_motion_ && going < resting / 2;
  margin_ = kMarginFactor * share * (goes_on_ ? going : resting);
  mean_speed_ = share * speed;
  knows_motion_ = true;
}

// Fat boxes are floats, so that the grid finds their pairs exactly.
void Skin::Fatten(const Scene& scene) {
  const std::size_t movers = bodies_.movers();
  if (!knows_motion_) velocity_.assign(movers, {0, 0, 0});
  const double time = goes_on_ ? horizon_ : 0, most = 8 * mean_speed_ * time;
  const auto fatten = [&](double lower, double upper, double velocity, double& fat_lower,
                          double& fat_upper) {
    const double way = std::clamp(velocity * time, -most, most);
    // A float is off by less than this.
    const double low = std::fabs(lower) * 0x1p-22, high = std::fabs(upper) * 0x1p-22;
    fat_lower = static_cast<float>(lower - margin_ - low + std::min(way, 0.));
    fat_upper = static_cast<float>(upper + margin_ + high + std::max(way, 0.));
  };
  for (std::size_t i = 0; i < movers; ++i) {
    const Box& box = scene.boxes[i];
    Box& fat = fat_[i];
    fatten(box.lower.x, box.upper.x, velocity_[i].x, fat.lower.x, fat.upper.x);
    fatten(box.lower.y, box.upper.y, velocity_[i].y, fat.lower.y, fat.upper.y);
    fatten(box.lower.z, box.upper.z, velocity_[i].z, fat.lower.z, fat.upper.z);
  }
}

std::unique_ptr<Detector> MakeSkin(const Options& options, const Kernels& kernels) {
  return std::make_unique<Skin>(options, kernels);
}

}  // namespace cdb::library
