#include "library/detectors/auto.h"

#include <algorithm>

#include "library/detectors/grid.h"
#include "library/detectors/skin.h"
#include "library/detectors/sweep.h"

namespace cdb::library {
namespace {

/// So many bodies are sorted before a grid is made.
constexpr std::size_t kFew = 24;
/// Cycles of skin until it is judged; of grid until skin is tried again, at first and at most.
constexpr unsigned kTrial = 24, kFirstPause = 64, kLastPause = 4096;

class Auto final : public Detector {
 public:
  Auto(const Options& options, const Kernels& kernels)
      : sweep_(MakeSweep(options, kernels)),
        grid_(MakeGrid(options, kernels)),
        skin_(options, kernels) {}

  void Prepare(const Scene& scene) override {
    sweep_->Prepare(scene);
    grid_->Prepare(scene);
    skin_.Prepare(scene);
  }

  void FindPairs(const Scene& scene, std::vector<Pair>& pairs) override {
    if (scene.size <= kFew) return sweep_->FindPairs(scene, pairs);
    if (pause_ > 0) {
      if (--pause_ == 0) {
        skin_.Forget();
        trial_ = 0;
      }
      return grid_->FindPairs(scene, pairs);
    }
    skin_.FindPairs(scene, pairs);
    if (++trial_ < kTrial) return;
    if (skin_.RelativeCost() > 1) {
      pause_ = next_pause_;
      next_pause_ = std::min(2 * next_pause_, kLastPause);
    } else {
      next_pause_ = kFirstPause;
    }
  }

 private:
  std::unique_ptr<Detector> sweep_, grid_;
  Skin skin_;
  unsigned trial_ = 0;  ///< cycles of skin
  unsigned pause_ = 0, next_pause_ = kFirstPause;
};

}  // namespace

std::unique_ptr<Detector> MakeAuto(const Options& options, const Kernels& kernels) {
  return std::make_unique<Auto>(options, kernels);
}

}  // namespace cdb::library
