// Compares the pairs and contacts of a detector with exact ones (`record pairs`), between cycles
// and never in a timed run.
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "library/detectors/exact_pairs.h"
#include "library/exact/signed_distance.h"
#include "runtime/engine/detection/adapter_broad_phase.h"
#include "runtime/engine/world/engine.h"
#include "runtime/protocol/recording.h"

namespace cdb::probes {

// Exact pairs and overlaps of the bodies in their current poses, by brute force and library/exact,
// in double.
//
// Not thread-safe with respect to the engine.

/// Indices of bodies (getUserIndex), the smaller first.
using BodyPair = std::pair<std::uint32_t, std::uint32_t>;

/// All pairs of objects whose tightest boxes overlap, that may touch and are not both fixed, in
/// order.
std::vector<BodyPair> ExactPairs(const world::Engine& engine);

/// Two overlapping bodies.
struct ExactOverlap {
  BodyPair bodies;
  double depth = 0;                                   ///< m
  Eigen::Vector3d normal = Eigen::Vector3d::UnitY();  ///< from the second body to the first
  bool has_one_normal = true;  ///< false: another normal has about the same depth
  double size = 0;             ///< m, of the smaller object; walls have none
  /// One is in solid cells and meets none of their triangles: neither depth nor normal is known.
  bool is_inside = false;
};

/// In sizes. A shallower overlap is lost in rounding; no detector has to find it.
inline constexpr double kLeastOverlap = 1e-4;

struct ExactContacts {
  std::vector<ExactOverlap> overlaps;  ///< deeper than kLeastOverlap, in the order of their bodies
  /// Other pairs that may overlap as deeply: those whose depth is not known to a billionth of the
  /// size of the smaller object, and those that were not drawn.
  std::vector<BodyPair> uncompared;  ///< in their order
  /// Pairs that are not known to be apart, but overlap by no more than kLeastOverlap.
  std::size_t touching = 0;
  /// True if it is certain that no two of the bodies overlap.
  bool AreAllApart() const { return overlaps.empty() && uncompared.empty() && touching == 0; }
};

/// `pairs`, and those of objects and walls that may touch.
std::vector<BodyPair> WithWalls(const world::Engine& engine, std::vector<BodyPair> pairs);

/// Of the given pairs of objects, or of objects and walls, that may collide. If more than `most`
/// may overlap, plane walls aside, so many are drawn at random; `draw` selects the draw.
ExactContacts ExactOverlaps(const world::Engine& engine, const std::vector<BodyPair>& pairs,
                            std::uint64_t draw = 0,
                            std::size_t most = protocol::kMostComparedContacts);

/// Errors of the narrow phase over a set of overlaps.
struct NarrowPhaseErrors {
  double missed = 0;    ///< overlaps without a contact point
  double unlisted = 0;  ///< of these, those whose pair the broad phase did not list
  double bullet = 0;    ///< overlaps of pairs whose contacts Bullet makes, not the detector
  double bullet_missed = 0;
  double unknown = 0;     ///< found overlaps whose depth is not known
  double depth_sum = 0;   ///< sum of |depth - exact| over the other overlaps, in sizes
  double depth_max = 0;   ///< the largest of these
  double normal_sum = 0;  ///< sum of the angles between normals, rad, where the normal is unique
  double normal_max = 0;  ///< the largest of these
  double normals = 0;     ///< number of angles in normal_sum
  double false_ = 0;      ///< pairs with a contact deeper than kLeastFalse that are no overlap
};

/// In sizes. A contact as deep, or deeper, of bodies that do not overlap is false.
inline constexpr double kLeastFalse = 1e-3;

/// Compares each overlap with the deepest point in the manifolds, which hold the contacts of the
/// last step.
NarrowPhaseErrors CompareContacts(world::Engine& engine, const ExactContacts& exact);

/// Stores the comparison in the series of `record pairs` that begin with contacts. `exact`: in the
/// poses of the last detection.
void JudgeContacts(world::Engine& engine, const ExactContacts& exact,
                   protocol::Recording& recording, std::uint64_t cycle);

/// Who made the contacts of a pair in the last step.
enum class ContactMaker { kNone, kDetector, kBullet };  // kNone: the broad phase did not list it
ContactMaker ContactMakerOf(world::Engine& engine, const BodyPair& bodies);

/// Compares a list of pairs with brute force and records the counts of the cycle. The message of
/// the recording becomes the first pair that any cycle missed. `asked`: as in
/// library/detectors/exact_pairs.h. `collides`: whether the bodies of an exact pair collide; none
/// if only their boxes are known.
void RecordPairFaults(const Scene& scene, std::vector<Pair> listed, std::uint64_t cycle,
                      protocol::Recording& recording, const detectors::PairFilter& asked = {},
                      const detectors::PairFilter& collides = {});

/// Pairs are compared with brute force, in double, on the boxes of the cycle: the list of a
/// detector before cdb filters it, or, for Bullet's own broad phases, the pair cache. Contacts are
/// compared with exact overlaps, in the poses that the detector saw. Requires that the run records
/// pairs. Engine and recording must outlive it. Not thread-safe.
class PairReferee {
 public:
  PairReferee(world::Engine& engine, protocol::Recording& recording);

  /// Call before and after each step that belongs to a recorded cycle.
  void BeforeStep();
  void AfterStep(std::uint64_t cycle);
  /// Those of the last BeforeStep.
  const ExactContacts& contacts() const { return contacts_; }

 private:
  void ReadBoxes();
  std::vector<Pair> ListedPairs() const;
  void JudgePairs(std::uint64_t cycle);

  world::Engine& engine_;
  detection::AdapterBroadPhase* const adapter_;  ///< null if the broad phase is Bullet's own
  const bool detects_;                           ///< otherwise nothing is compared or stored
  protocol::Recording& recording_;
  std::vector<Box> boxes_;  ///< by user index; NaN for absent walls
  std::vector<Filter> filters_;
  std::uint64_t steps_ = 0;
  ExactContacts contacts_;  ///< in the poses before the step
};

}  // namespace cdb::probes
