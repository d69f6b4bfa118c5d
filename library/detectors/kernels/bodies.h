// What our detectors share: which bodies are many and which are walls, and what the filters refuse.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "library/detectors/detector.h"
#include "library/detectors/kernels/kernels.h"
#include "library/detectors/kernels/pair_buffer.h"

namespace cdb::kernels {

/// The k-th of a few bodies that stand for all: spread evenly, but without a step that a pattern of
/// the ids could meet.
inline std::size_t SamplePlace(std::size_t k, std::size_t count) {
  const auto turn = static_cast<std::uint32_t>((k + 1) * 2654435769u);  // by the golden section
  return static_cast<std::size_t>(std::uint64_t{turn} * count >> 32);
}

/// The bodies of a scene: `movers` are those before the fixed ones at its end, which are walls as
/// long as they are few and then meet the movers one by one; a wall's box is often infinite and
/// would crowd whatever the movers are sorted into. Threads: one at a time.
class Bodies {
 public:
  /// Looks at the filters; they hold until the number of bodies changes.
  void Learn(const Scene& scene);
  /// The same if it knows as many bodies.
  void LearnOnce(const Scene& scene) {
    if (scene.size != size_) Learn(scene);
  }
  std::size_t movers() const { return movers_; }

  /// Appends the pairs of movers and walls.
  void MeetWalls(const Scene& scene, const Kernels& kernels, PairBuffer& pairs) const;
  /// Drops pairs of movers that may not collide, and, unless `is_exact`, those whose boxes do not
  /// overlap in double. Keeps the order.
  void Sieve(const Scene& scene, bool is_exact, PairBuffer& pairs) const;

 private:
  std::size_t size_ = static_cast<std::size_t>(-1), movers_ = 0;
  bool movers_collide_ = true;  ///< any two of them
};

}  // namespace cdb::kernels
