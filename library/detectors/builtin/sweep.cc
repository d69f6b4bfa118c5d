#include "library/detectors/builtin/sweep.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <tuple>

#include "library/detectors/builtin/skin.h"
#include "library/detectors/detector.h"
#include "library/detectors/kernels/bodies.h"
#include "library/detectors/kernels/box_grid.h"
#include "library/detectors/kernels/kernels.h"
#include "library/detectors/kernels/pair_buffer.h"

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

// `auto`: chooses among the built-in broad phases according to the motion of the scene.

namespace {

/// Up to this number of bodies, sweep is used.
constexpr std::size_t kFew = 24;
/// Cycles of skin before it is judged, and before it is judged if it seems hopeless; cycles of
/// another detector before skin is tried again, at first and at most.
constexpr unsigned kTrial = 24, kShortTrial = 6, kFirstPause = 64, kLastPause = 4096;
/// The most judgements in a row that leave sweep out after one in which it showed no gain.
constexpr unsigned kMostSkipped = 64;
/// Mean number of bodies in a cell above which sweep may be faster.
constexpr double kCrowded = 64;
/// Cost of a body and of a test, in nanoseconds, as in skin's cost model.
constexpr double kSweepCost = 10, kSweepTestCost = 1.2;

class Auto final : public Detector {
 public:
  Auto(const Options& options, const kernels::Kernels& kernels)
      : sweep_(kernels), grid_(MakeGrid(options, kernels)), skin_(options, kernels) {}

  void Prepare(const Scene& scene) override {
    sweep_.Prepare(scene);
    grid_->Prepare(scene);
    skin_.Prepare(scene);
    trial_ = left_ = to_skip_ = 0;
    next_pause_ = kFirstPause;
    next_skip_ = 1;
  }

  void FindPairs(const Scene& scene, std::vector<Pair>& pairs) override {
    InUse(scene).FindPairs(scene, pairs);
    Learn(scene);
  }
  // A detector that takes over from another does not know the last call and lists all pairs.
  bool FindChanges(const Scene& scene, std::vector<Pair>& came, std::vector<Pair>& went) override {
    const bool are_changes = InUse(scene).FindChanges(scene, came, went);
    Learn(scene);
    return are_changes;
  }

 private:
  Detector& InUse(const Scene& scene) {
    if (scene.size <= kFew) return sweep_;
    return left_ > 0 ? *other_ : skin_;
  }
  /// Updates the decision after a call.
  void Learn(const Scene& scene) {
    if (scene.size <= kFew) return;
    if (left_ > 0) {
      if (--left_ == 0) skin_.Forget();
      return;
    }
    ++trial_;
    const bool is_hopeless = trial_ >= kShortTrial && (skin_.MeanOccupancy() > 16 * kCrowded ||
                                                       skin_.Cost() > 3 * skin_.GridCost());
    if (is_hopeless || trial_ >= kTrial) Judge(scene);
  }
  void Judge(const Scene& scene) {
    trial_ = 0;
    if (to_skip_ > 0) {
      --to_skip_;
    } else if (skin_.Crowding() > kCrowded) {
      if (kSweepCost + kSweepTestCost * sweep_.ForeseenTests(scene) <
          std::min(skin_.Cost(), skin_.GridCost()))
        return Pause(sweep_);
      to_skip_ = next_skip_;
      next_skip_ = std::min(2 * next_skip_, kMostSkipped);
    }
    if (skin_.Cost() > skin_.GridCost()) {
      Pause(*grid_);
    } else {
      next_pause_ = kFirstPause;
    }
  }
  void Pause(Detector& other) {
    other_ = &other;
    left_ = next_pause_;
    next_pause_ = std::min(2 * next_pause_, kLastPause);
  }

  Sweep sweep_;
  std::unique_ptr<Detector> grid_;
  Skin skin_;
  unsigned trial_ = 0;         ///< cycles of skin since the last judgement
  unsigned left_ = 0;          ///< cycles of `other_` that remain
  Detector* other_ = nullptr;  ///< used instead of skin
  unsigned next_pause_ = kFirstPause;
  unsigned to_skip_ = 0, next_skip_ = 1;  ///< judgements that leave sweep out
};

}  // namespace

/// Exact pairs. Method: `sweep` for few bodies, otherwise `skin`. If skin's lists expire too soon
/// to pay off, `grid` for a while. If many bodies share the cells of the grid, such as bodies along
/// a slanted line, `sweep`, provided that a sample shows few overlaps along an axis. Skin is
/// then tried again at growing intervals. Decisions are based on numbers of tests, not on time, so
/// that the same motion yields the same list in the same order. Cost: that of the best of them,
/// plus the trials. Memory: up to the sum of theirs. Errors: bad_alloc. Threads: as theirs.
std::unique_ptr<Detector> MakeAuto(const Options& options, const kernels::Kernels& kernels) {
  return std::make_unique<Auto>(options, kernels);
}

namespace {

class Grid final : public Detector {
 public:
  Grid(const Options& options, const kernels::Kernels& kernels)
      : kernels_(kernels), grid_(kernels), parts_(options.threads) {}

  void Prepare(const Scene& scene) override { bodies_.Learn(scene); }

  void FindPairs(const Scene& scene, std::vector<Pair>& pairs) override {
    bodies_.LearnOnce(scene);
    const double cost = kGridCost * static_cast<double>(bodies_.movers());
    const auto session = parts_.Begin(cost);
    if (bodies_.second_class() > 0)
      FindBetweenClasses(scene, cost);
    else
      FindAll(scene, cost);
    bodies_.MeetWalls(scene, kernels_, parts_.last());
    parts_.AppendTo(pairs);
  }

 private:
  // Half of the cost is building the grid.

  void FindAll(const Scene& scene, double cost) {
    const bool is_exact = grid_.Build(scene.boxes.data(), bodies_.movers(), &parts_.pool());
    parts_.Run(cost / 2, [&](unsigned part, unsigned parts, kernels::PairBuffer& found) {
      grid_.QueryPart(part, parts, found.sink());
      bodies_.Sieve(scene, is_exact, found);
    });
  }

  /// Puts the smaller class into the grid, which is asked for each body of the larger one, so that
  /// no two of a class are tested.
  void FindBetweenClasses(const Scene& scene, double cost) {
    const std::size_t second = bodies_.second_class(), after = bodies_.movers() - second;
    const std::size_t first_in_grid = after < second ? second : 0,
                      in_grid = std::min(after, second);
    const std::size_t first_asking = after < second ? 0 : second, asking = std::max(after, second);
    const bool is_grid_exact =
        grid_.Build(scene.boxes.data() + first_in_grid, in_grid, &parts_.pool());
    parts_.Run(cost / 2, [&](unsigned part, unsigned parts, kernels::PairBuffer& found) {
      bool is_exact = is_grid_exact;
      const std::size_t end = first_asking + asking * (part + 1) / parts;
      for (std::size_t id = first_asking + asking * part / parts; id < end; ++id) {
        kernels::FatBox box;
        is_exact &= kernels_.narrow(
            &scene.boxes[id], 1,
            {{box.lower, box.lower + 1, box.lower + 2}, {box.upper, box.upper + 1, box.upper + 2}});
        // Those of a grid of the first class are ids, and so lower.
        if (!std::isnan(box.lower[0]))
          grid_.QueryOne(box, static_cast<Id>(id), found.sink(), first_in_grid == 0);
      }
      for (Pair& pair : found.pairs()) pair.b += static_cast<Id>(first_in_grid);
      if (is_exact) return;
      const auto rest = std::ranges::remove_if(found.pairs(), [&](const Pair& pair) {
        return !Overlap(scene.boxes[pair.a], scene.boxes[pair.b]);
      });
      found.Cut(found.size() - rest.size());
    });
  }

  const kernels::Kernels& kernels_;
  kernels::Bodies bodies_;
  kernels::BoxGrid grid_;
  kernels::PairParts parts_;
};

}  // namespace

std::unique_ptr<Detector> MakeGrid(const Options& options, const kernels::Kernels& kernels) {
  return std::make_unique<Grid>(options, kernels);
}

}  // namespace cdb::builtin
