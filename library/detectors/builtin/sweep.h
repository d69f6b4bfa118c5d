// `sweep`: sweep and prune along one axis.
#pragma once

#include <memory>
#include <vector>

#include "library/detectors/detector.h"
#include "library/detectors/kernels/bodies.h"
#include "library/detectors/kernels/kernels.h"
#include "library/detectors/kernels/pair_buffer.h"
#include "library/detectors/kernels/soa_boxes.h"

namespace cdb::builtin {

/// Exact pairs. Method: boxes are sorted by their lower end along the axis with the fewest expected
/// overlaps (chosen every 32 cycles), by insertion from the order of the last cycle. Each is tested
/// with those that begin before it ends, eight at once. Suits few bodies, bodies along a line, and
/// infinite boxes. Cost: bodies, plus exchanges since the last cycle, plus overlaps along the axis
/// / 8. Memory: about 70 bytes a body. Errors: bad_alloc. Threads: only the caller's. Source:
/// Cohen, Lin, Manocha & Ponamgi, I-COLLIDE, 1995.
class Sweep final : public Detector {
 public:
  explicit Sweep(const kernels::Kernels& kernels = kernels::BestKernels()) : kernels_(kernels) {}

  void Prepare(const Scene& scene) override { bodies_.Learn(scene); }
  void FindPairs(const Scene& scene, std::vector<Pair>& pairs) override;

  /// Number of tests per body that a cycle would take, of eight boxes each, estimated from a
  /// sample.
  double ForeseenTests(const Scene& scene);

 private:
  struct Entry {
    float lower;
    Id id;
  };

  void Sort(std::size_t count);
  bool Insert();
  int BestAxis(std::size_t count) const;

  const kernels::Kernels& kernels_;
  kernels::Bodies bodies_;
  kernels::SoaBoxes loose_, sorted_;
  std::vector<Entry> entries_;
  std::vector<Id> ids_;
  kernels::PairBuffer found_;
  int axis_ = 0;
  unsigned age_ = 0;  ///< cycles since this axis was chosen
};

std::unique_ptr<Detector> MakeSweep(const Options& options,
                                    const kernels::Kernels& kernels = kernels::BestKernels());

// `grid`: a uniform grid, rebuilt every cycle.

/// Exact pairs. Method and source: box_grid.h; walls are handled separately (bodies.h). Suits
/// bodies that are close together and move fast, because it does not use temporal coherence. Cost:
/// linear in bodies and pairs if boxes are of similar size. Memory: about 70 bytes a body. Threads:
/// the search uses Options::threads; the list does not depend on them.
std::unique_ptr<Detector> MakeGrid(const Options& options,
                                   const kernels::Kernels& kernels = kernels::BestKernels());

}  // namespace cdb::builtin
