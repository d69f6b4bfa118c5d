#include "library/detectors/builtin/sweep.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

namespace cdb::builtin {
namespace {

/// Number of cycles for which an axis is kept.
constexpr unsigned kAxisAge = 32;
constexpr std::size_t kLeastSample = 64, kMostSample = 256;

constexpr auto kIsBefore = [](const auto& a, const auto& b) {
  return std::tie(a.lower, a.id) < std::tie(b.lower, b.id);
};

}  // namespace

void Sweep::FindPairs(const Scene& scene, std::vector<Pair>& pairs) {
  bodies_.LearnOnce(scene);
  const std::size_t count = bodies_.movers();
  loose_.Reserve(count);
  sorted_.Reserve(count);
  const bool is_exact = kernels_.narrow(scene.boxes.data(), count, loose_.get());
  Sort(count);
  found_.Clear();
  kernels_.sweep(sorted_.get(), ids_.data(), count, 0, count, found_.sink());
  bodies_.Sieve(scene, is_exact, found_);
  bodies_.MeetWalls(scene, kernels_, found_);
  pairs.insert(pairs.end(), found_.pairs().begin(), found_.pairs().end());
}

double Sweep::ForeseenTests(const Scene& scene) {
  bodies_.LearnOnce(scene);
  const std::size_t count = bodies_.movers();
  const std::size_t size = std::min(count, std::clamp(count / 16, kLeastSample, kMostSample));
  double fewest = std::numeric_limits<double>::infinity();
  for (const auto axis : {&Vec3::x, &Vec3::y, &Vec3::z}) {
    std::vector<double> lower, upper;
    for (std::size_t k = 0; k < size; ++k) {
      const Box& box = scene.boxes[size < count ? kernels::SampleIndex(k, count) : k];
      const double side = box.upper.*axis - box.lower.*axis;
      if (!std::isfinite(side) || side < 0) continue;
      lower.push_back(box.lower.*axis);
      upper.push_back(box.upper.*axis);
    }
    std::ranges::sort(lower);
    std::ranges::sort(upper);
    // Two intervals overlap if the second begins before the first ends.
    double overlaps = 0;
    for (std::size_t ended = 0, begun = 0; begun < lower.size(); ++begun) {
      while (ended < begun && upper[ended] < lower[begun]) ++ended;
      overlaps += static_cast<double>(begun - ended);
    }
    const auto all = static_cast<double>(lower.size());
    fewest = std::min(fewest, all > 0 ? overlaps / (all * all) * static_cast<double>(count) : 0);
  }
  return 1 + fewest / 8;
}

void Sweep::Sort(std::size_t count) {
  const bool is_new = entries_.size() != count;
  if (is_new) {
    entries_.resize(count);
    ids_.resize(count + 8);
    for (Id id = 0; id < count; ++id) entries_[id].id = id;
  }
  const int last_axis = axis_;
  if (is_new || ++age_ >= kAxisAge) {
    axis_ = BestAxis(count);
    age_ = 0;
  }
  const float* lower = loose_.get().lower[axis_];
  const float* x = loose_.get().lower[0];
  // Boxes with a NaN are sorted to the end, where no other box reaches them.
  for (Entry& entry : entries_)
    entry.lower =
        std::isnan(x[entry.id]) ? std::numeric_limits<float>::infinity() : lower[entry.id];
  if (is_new || axis_ != last_axis || !Insert()) std::ranges::sort(entries_, kIsBefore);
  const kernels::Columns &from = loose_.get(), &to = sorted_.get();
  for (int k = 0; k < 3; ++k) {
    const int axis = (axis_ + k) % 3;
    for (std::size_t i = 0; i < count; ++i) {
      to.lower[k][i] = from.lower[axis][entries_[i].id];
      to.upper[k][i] = from.upper[axis][entries_[i].id];
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    ids_[i] = entries_[i].id;
    if (std::isnan(x[ids_[i]])) to.lower[0][i] = x[ids_[i]];
  }
}

/// Insertion sort. False if it would take longer than sorting from scratch; the order is then
/// unspecified.
bool Sweep::Insert() {
  std::size_t budget = 32 * entries_.size() + 64;
  for (std::size_t i = 1; i < entries_.size(); ++i) {
    const Entry entry = entries_[i];
    std::size_t at = i;
    for (; at > 0 && kIsBefore(entry, entries_[at - 1]); --at) entries_[at] = entries_[at - 1];
    entries_[at] = entry;
    if (i - at > budget) return false;
    budget -= i - at;
  }
  return true;
}

/// The axis along which the finite boxes are spread the widest relative to their extents.
int Sweep::BestAxis(std::size_t count) const {
  int best = 0;
  double best_crowding = std::numeric_limits<double>::infinity();
  for (int axis = 0; axis < 3; ++axis) {
    double length = 0, square = 0, sum = 0, boxes = 0;
    for (std::size_t i = 0; i < count; ++i) {
      const double lower = loose_.get().lower[axis][i], upper = loose_.get().upper[axis][i];
      if (!std::isfinite(upper - lower)) continue;
      length += upper - lower;
      sum += lower;
      square += lower * lower;
      ++boxes;
    }
    const double spread = std::sqrt(std::max(square * boxes - sum * sum, 0.));
    const double crowding = spread > 0 ? length / spread : std::numeric_limits<double>::max();
    if (crowding < best_crowding) {
      best = axis;
      best_crowding = crowding;
    }
  }
  return best;
}

std::unique_ptr<Detector> MakeSweep(const Options&, const kernels::Kernels& kernels) {
  return std::make_unique<Sweep>(kernels);
}

}  // namespace cdb::builtin
