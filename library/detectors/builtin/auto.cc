// `auto`: chooses among the built-in broad phases according to the motion of the scene.
#include <algorithm>
#include <memory>

#include "library/detectors/builtin/grid.h"
#include "library/detectors/builtin/skin.h"
#include "library/detectors/builtin/sweep.h"
#include "library/detectors/detector.h"
#include "library/detectors/kernels/kernels.h"

namespace cdb::builtin {
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

}  // namespace cdb::builtin
