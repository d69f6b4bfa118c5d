// The bodies of a scene, split into movers and walls, and their collision filters.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "library/detectors/detector.h"
#include "library/detectors/kernels/kernels.h"
#include "library/detectors/kernels/pair_buffer.h"

namespace cdb::kernels {

/// The k-th body of a sample. The sample is evenly spread, but without a constant stride, which
/// could coincide with a pattern of the ids.
inline std::size_t SampleIndex(std::size_t k, std::size_t count) {
  const auto turn = static_cast<std::uint32_t>((k + 1) * 2654435769u);  // golden ratio
  return static_cast<std::size_t>(std::uint64_t{turn} * count >> 32);
}

/// The bodies of a scene. The fixed bodies at its end are walls if they are few; all bodies before
/// them are `movers`. Walls are not put into a grid, because their boxes are often infinite and
/// would fill every cell. Threads: one at a time.
class Bodies {
 public:
  /// Reads the filters; valid until the number of bodies changes.
  void Learn(const Scene& scene);
  /// Does the same if the number of bodies has changed.
  void LearnOnce(const Scene& scene) {
    if (scene.size != size_) Learn(scene);
  }
  std::size_t movers() const { return movers_; }
  /// The movers that are not fixed, in order; only these can meet fixed ones.
  const std::vector<Id>& free() const { return free_; }
  /// True if so few movers are free that it is faster to visit these alone.
  bool HasFewFree() const { return kFewFree * free_.size() < movers_; }

  /// The first mover of the second class, if the movers are two classes by their filters, one after
  /// the other, and two of them may collide if and only if they are of different ones, as vertices
  /// and faces; otherwise 0.
  std::size_t second_class() const { return second_class_; }

  /// Appends the pairs of movers and walls. Cost: one pass over the movers, and a test of each that
  /// is not well inside the room.
  void MeetWalls(const Scene& scene, const Kernels& kernels, PairBuffer& pairs);

  /// Measures the room between the walls: a box that lies inside it overlaps none of the walls that
  /// bound it. The boxes of the other walls contain the middle of the movers, as those of oblique
  /// planes do.
  void MeasureRoom(const Scene& scene);
  const Box& room() const { return room_; }
  const std::vector<Id>& bounds() const { return bounds_; }  ///< walls that bound the room
  const std::vector<Id>& others() const { return others_; }  ///< walls that do not bound the room
  /// True if all bodies sleep. If it is true in two calls in a row, no body has moved in between.
  /// False if this is not known.
  bool AllSleep(const Scene& scene) const;
  /// Appends the pairs of these movers and the walls that bound the room.
  void MeetBounds(const Scene& scene, std::span<const Id> movers, PairBuffer& pairs) const;
  /// Appends the pairs of all movers and the other walls.
  void MeetOthers(const Scene& scene, const Kernels& kernels, PairBuffer& pairs) const;
  /// Drops pairs of movers that may not collide, and, unless `is_exact`, those whose boxes do not
  /// overlap in double. Keeps the order.
  void Sieve(const Scene& scene, bool is_exact, PairBuffer& pairs) const;

 private:
  /// One mover in so many.
  static constexpr std::size_t kFewFree = 8;

  std::size_t size_ = static_cast<std::size_t>(-1), movers_ = 0;
  std::size_t second_class_ = 0;
  bool movers_collide_ = true;  ///< any two movers may collide
  Vec3 middle_ = {};            ///< of the finite boxes of movers, when they were learnt
  Box room_ = {};
  std::vector<Id> bounds_, others_;  ///< walls
  std::vector<Id> outside_;          ///< movers
  std::vector<Id> free_;             ///< movers that are not fixed: the others never meet walls
};

}  // namespace cdb::kernels
