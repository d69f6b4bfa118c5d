#include "library/detectors/builtin/builtin.h"

#include "library/detectors/builtin/auto.h"
#include "library/detectors/builtin/grid.h"
#include "library/detectors/builtin/hierarchical_grid.h"
#include "library/detectors/builtin/kd_tree.h"
#include "library/detectors/builtin/octree.h"
#include "library/detectors/builtin/skin.h"
#include "library/detectors/builtin/sweep.h"
#include "library/detectors/catalogue_entry.h"

namespace cdb::builtin {
namespace {

/// Finds no pairs: measures the cost of calling a detector.
class Null final : public Detector {};

using Maker = std::unique_ptr<Detector>(const Options& options, const kernels::Kernels& kernels);

template <Maker make>
Detector* Make(const Options& options) {
  return make(options, kernels::BestKernels()).release();
}

using detectors::CatalogueEntry;

constexpr DetectorEntry kEntries[] = {
    CatalogueEntry("auto", Make<MakeAuto>),
    CatalogueEntry("skin", Make<MakeSkin>),
    CatalogueEntry("grid", Make<MakeGrid>),
    CatalogueEntry("hierarchical_grid", Make<MakeHierarchicalGrid>),
    CatalogueEntry("sweep", Make<MakeSweep>),
    CatalogueEntry("octree", MakeOctree),
    CatalogueEntry("kd_tree", MakeKdTree),
    CatalogueEntry("null", [](const Options&) -> Detector* { return new Null; }),
};

}  // namespace

std::span<const DetectorEntry> BuiltinDetectors() { return kEntries; }

}  // namespace cdb::builtin
