#include "library/detectors/builtin/builtin.h"

#include "library/detectors/builtin/auto.h"
#include "library/detectors/builtin/grid.h"
#include "library/detectors/builtin/hierarchical_grid.h"
#include "library/detectors/builtin/kd_tree.h"
#include "library/detectors/builtin/octree.h"
#include "library/detectors/builtin/skin.h"
#include "library/detectors/builtin/sweep.h"

namespace cdb::builtin {
namespace {

/// Finds nothing: what calling a detector costs.
class Null final : public Detector {};

using Maker = std::unique_ptr<Detector>(const Options& options, const kernels::Kernels& kernels);

template <Maker make>
Detector* Make(const Options& options) {
  return make(options, kernels::BestKernels()).release();
}

constexpr DetectorEntry kEntries[] = {
    {"auto", "skin, grid or sweep, as the scene moves", kBroad, 0, Make<MakeAuto>},
    {"skin", "a list of candidates that lasts for several cycles", kBroad, 0, Make<MakeSkin>},
    {"grid", "a uniform grid, rows of eight boxes at once", kBroad, 0, Make<MakeGrid>},
    {"hierarchical_grid", "a uniform grid for each size of box", kBroad, 0,
     Make<MakeHierarchicalGrid>},
    {"sweep", "sweep and prune along one axis, eight boxes at once", kBroad, 0, Make<MakeSweep>},
    {"octree", "a loose octree", kBroad, 0, MakeOctree},
    {"kd_tree", "a k-d tree", kBroad, 0, MakeKdTree},
    {"null", "finds nothing", kBroad, 0, [](const Options&) -> Detector* { return new Null; }},
};

}  // namespace

std::span<const DetectorEntry> BuiltinDetectors() { return kEntries; }

}  // namespace cdb::builtin
