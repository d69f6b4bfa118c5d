// Which pairs `skin` listed last, so that it can list only the changes.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "library/detectors/detector.h"
#include "library/detectors/kernels/kernels.h"
#include "library/detectors/kernels/pair_parts.h"

namespace cdb::builtin {

/// A flag for each candidate: whether its boxes overlapped in the last call. Cost: that of testing
/// the candidates, and of the changes. Errors: bad_alloc. Threads: one caller; tests use those of
/// `parts`.
class SkinChanges {
 public:
  explicit SkinChanges(kernels::PairParts& parts) : parts_(parts) {}

  /// The next call lists all pairs.
  void Forget();
  /// To be called before these candidates are replaced or reordered.
  void Replace(std::span<const Pair> candidates);
  /// What Detector::FindChanges does. Candidates may have been added at the end since the last
  /// call; `rest` are the other pairs that overlap.
  bool Find(const Scene& scene, const kernels::Kernels& kernels, std::span<const Pair> candidates,
            std::span<const Pair> rest, std::vector<Pair>& came, std::vector<Pair>& went);
  /// The last call was of Find, and not Forget.
  bool knows_last() const { return knows_last_; }
  /// Number of pairs in the last call of Find.
  std::size_t size() const { return met_count_ + rest_.size(); }

 private:
  void FindRest(const Scene& scene, std::span<const Pair> rest, std::vector<Pair>& came,
                std::vector<Pair>& went);

  kernels::PairParts& parts_;
  bool knows_last_ = false;
  bool has_flags_ = false;         ///< of the candidates in use
  std::vector<std::uint8_t> met_;  ///< flags
  std::size_t met_count_ = 0;
  std::vector<Pair> replaced_;  ///< candidates that overlapped when they were replaced
  std::vector<Pair> rest_;      ///< of the last call
  std::vector<Pair> changed_;
};

}  // namespace cdb::builtin
