#include "library/detectors/builtin/grid.h"

#include "library/detectors/builtin/skin_costs.h"
#include "library/detectors/kernels/bodies.h"
#include "library/detectors/kernels/box_grid.h"
#include "library/detectors/kernels/pair_parts.h"

namespace cdb::builtin {
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
    const bool is_exact = grid_.Build(scene.boxes.data(), bodies_.movers(), &parts_.pool());
    // The other half is building the grid.
    parts_.Run(cost / 2, [&](unsigned part, unsigned parts, kernels::PairBuffer& found) {
      grid_.QueryPart(part, parts, found.sink());
      bodies_.Sieve(scene, is_exact, found);
    });
    bodies_.MeetWalls(scene, kernels_, parts_.last());
    parts_.AppendTo(pairs);
  }

 private:
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
