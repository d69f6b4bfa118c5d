// The pairs that `skin` listed last, so that it can list only the changes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "library/detectors/builtin/skin_awake.h"
#include "library/detectors/detector.h"
#include "library/detectors/kernels/kernels.h"
#include "library/detectors/kernels/pair_parts.h"

namespace cdb::builtin {

/// Keeps a flag for each candidate: whether its boxes overlapped in the last call. Cost: testing
/// the candidates, of few awake bodies if most sleep, plus the number of changes. Errors:
/// bad_alloc. Threads: one caller; the tests use the threads of `parts`.
class SkinChanges {
 public:
  explicit SkinChanges(kernels::PairParts& parts) : parts_(parts) {}

  /// Makes the next call of Find list all pairs.
  void Forget();
  /// Call before the candidates are replaced or reordered.
  void Replace(std::span<const Pair> candidates);
  /// Notes which bodies may have moved since the last cycle; call once in a cycle, before Find or
  /// in its place if the pairs are the same as in the last cycle.
  const SkinAwake& See(const Scene& scene) {
    awake_.See(scene);
    return awake_;
  }
  /// Lists the changes as Detector::FindChanges does. Candidates may have been appended since the
  /// last call; `rest` are the pairs of overlapping boxes that are not candidates.
  bool Find(const Scene& scene, const kernels::Kernels& kernels, std::span<const Pair> candidates,
            std::span<const Pair> rest, std::vector<Pair>& came, std::vector<Pair>& went);
  /// True if Find has been called since the last Forget.
  bool knows_last() const { return knows_last_; }
  /// Number of pairs in the last call of Find.
  std::size_t size() const { return met_count_ + rest_.size(); }

 private:
  void FindAll(const Scene& scene, const kernels::Kernels& kernels,
               std::span<const Pair> candidates);
  void FindAwake(const Scene& scene, std::span<const Pair> candidates);
  void FindRest(const Scene& scene, std::span<const Pair> rest, std::vector<Pair>& came,
                std::vector<Pair>& went);

  kernels::PairParts& parts_;
  bool knows_last_ = false;
  bool has_flags_ = false;          ///< met_ has the flags of the candidates in use
  std::vector<std::uint64_t> met_;  ///< a bit for each candidate; see Kernels::find_changed
  std::size_t met_count_ = 0;
  std::vector<Pair> replaced_;  ///< candidates that overlapped when they were replaced
  std::vector<Pair> rest_;      ///< of the last call
  std::vector<Pair> changed_;
  SkinAwake awake_;
};

}  // namespace cdb::builtin
