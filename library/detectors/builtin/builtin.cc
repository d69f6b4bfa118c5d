#include "library/detectors/builtin/builtin.h"

#include <algorithm>
#include <array>
#include <iterator>

#include "library/detectors/catalogue_entry.h"
#include "library/detectors/narrow/batch.h"

namespace cdb::builtin {

using WithKernels = std::unique_ptr<Detector>(const Options& options,
                                              const kernels::Kernels& kernels);
using Alone = Detector*(const Options& options);

// Each is defined in the file of its detector.
WithKernels MakeAuto, MakeGrid, MakeHierarchicalGrid, MakeSkin, MakeSweep;
Alone MakeKdTree, MakeOctree, MakeRefitTree;

namespace {

/// Finds no pairs: measures the cost of calling a detector.
class Null final : public Detector {};

struct Row {
  DetectorEntry entry;
  WithKernels* with_kernels = nullptr;
};

consteval Row Of(std::string_view name, Alone* make) {
  return {.entry = detectors::CatalogueEntry(name, make)};
}

template <WithKernels make>
consteval Row Of(std::string_view name) {
  return {
      .entry = detectors::CatalogueEntry(
          name,
          [](const Options& options) { return make(options, kernels::BestKernels()).release(); }),
      .with_kernels = make};
}

constexpr Row kRows[] = {
    Of<MakeAuto>("auto"),
    Of<MakeSkin>("skin"),
    Of<MakeGrid>("grid"),
    Of<MakeHierarchicalGrid>("hierarchical_grid"),
    Of<MakeSweep>("sweep"),
    Of("octree", MakeOctree),
    Of("kd_tree", MakeKdTree),
    Of("refit_tree", MakeRefitTree),
    Of("batch", narrow::MakeBatch),
    Of("null", [](const Options&) -> Detector* { return new Null; }),
};
static_assert(std::ranges::count_if(schema::kDetectorTable, &schema::DetectorInfo::IsOwn) ==
                  std::ssize(kRows),
              "a detector of the table has no entry");

constexpr auto kEntries = [] {
  std::array<DetectorEntry, std::size(kRows)> entries = {};
  std::ranges::transform(kRows, entries.begin(), &Row::entry);
  return entries;
}();

}  // namespace

std::span<const DetectorEntry> BuiltinDetectors() { return kEntries; }

std::unique_ptr<Detector> MakeWithKernels(std::string_view name, const Options& options,
                                          const kernels::Kernels& kernels) {
  const auto* row = std::ranges::find(kRows, name, [](const Row& one) { return one.entry.name; });
  return row->with_kernels == nullptr ? nullptr : row->with_kernels(options, kernels);
}

}  // namespace cdb::builtin
