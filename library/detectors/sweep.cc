#include "library/detectors/sweep.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>
#include <vector>

#include "library/detectors/bodies.h"
#include "library/detectors/box_columns.h"
#include "library/detectors/pair_buffer.h"

namespace cdb::library {
namespace {

/// Cycles that an axis is kept.
constexpr unsigned kAxisAge = 32;

class Sweep final : public Detector {
 public:
  explicit Sweep(const Kernels& kernels) : kernels_(kernels) {}

  void Prepare(const Scene& scene) override { bodies_.Learn(scene); }

  void FindPairs(const Scene& scene, std::vector<Pair>& pairs) override {
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

 private:
  struct Entry {
    float lower;
    Id id;
    bool operator<(const Entry& other) const {
      return std::tie(lower, id) < std::tie(other.lower, other.id);
    }
  };

  void Sort(std::size_t count) {
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
    // Those that are not numbers come last, where nothing reaches them.
    for (Entry& entry : entries_)
      entry.lower =
          std::isnan(x[entry.id]) ? std::numeric_limits<float>::infinity() : lower[entry.id];
    if (is_new || axis_ != last_axis || !Insert()) std::sort(entries_.begin(), entries_.end());
    const Columns &from = loose_.get(), &to = sorted_.get();
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

  /// False if it would take longer than sorting anew, the order then being any.
  bool Insert() {
    std::size_t budget = 32 * entries_.size() + 64;
    for (std::size_t i = 1; i < entries_.size(); ++i) {
      const Entry entry = entries_[i];
      std::size_t at = i;
      for (; at > 0 && entry < entries_[at - 1]; --at) entries_[at] = entries_[at - 1];
      entries_[at] = entry;
      if (i - at > budget) return false;
      budget -= i - at;
    }
    return true;
  }

  /// Where the finite boxes are spread the widest for their size.
  int BestAxis(std::size_t count) const {
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
      const double crowding = spread > 0 ? length / spread : 1e300;
      if (crowding < best_crowding) {
        best = axis;
        best_crowding = crowding;
      }
    }
    return best;
  }

  const Kernels& kernels_;
  Bodies bodies_;
  BoxColumns loose_, sorted_;
  std::vector<Entry> entries_;
  std::vector<Id> ids_;
  PairBuffer found_;
  int axis_ = 0;
  unsigned age_ = 0;
};

}  // namespace

std::unique_ptr<Detector> MakeSweep(const Options&, const Kernels& kernels) {
  return std::make_unique<Sweep>(kernels);
}

}  // namespace cdb::library
