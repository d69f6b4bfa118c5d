// Places every object according to its layout, so that it reaches neither through a wall nor into
// another object.
#pragma once

#include "compiler/plan/plan.h"
#include "library/layouts/initial_state.h"

namespace cdb::layouts {

/// Draws for one object, and for all together, before the search is given up. Voxels that are
/// looked at count as draws.
inline constexpr std::uint64_t kMaxTriesOfOne = 100000;
inline constexpr std::uint64_t kMinTriesOfAll = 1000000;
inline constexpr std::uint64_t kMeanTriesOfAll = 1000;  ///< times the objects

/// Up to this packing fraction (of boxes around shapes other than balls) positions are drawn until
/// kMaxTriesOfOne; beyond it, an object that failed kMissesBeforeVoxels times in a row is placed by
/// way of the voxels.
inline constexpr double kMaxPlainFill = 0.25;
inline constexpr std::uint64_t kMissesBeforeVoxels = 1000;

/// Packing fractions of equal solids at which random sequential addition ends: a little above .3841
/// for balls (Zhang and Torquato 2013) and .4227 for aligned cubes, the densest of the other
/// shapes. They hold for many objects that are small against the cube: then a group that needs more
/// is refused before the first draw.
inline constexpr double kMaxFillOfBalls = 0.40;
inline constexpr double kMaxFillOfOthers = 0.45;
inline constexpr std::uint64_t kManyObjects = 1000;
inline constexpr double kShortOfSide = 0.25;

/// Sets the position of every object of `state`: first of the groups whose layout says where each
/// object is (layouts/exact_layouts.h), in order, then of those that are drawn around them, in
/// order, from the stream `<group>.location`:
///   uniform  each coordinate uniform over where the object fits between the walls: what is left of
///            "uniform over the cube" once places that touch a wall are drawn again
///   normal   each coordinate normal with mean 0 and a third of the wall's coordinate as standard
///            deviation, drawn again until it fits
/// Nothing overlaps another object of any group, or a wall of the cube, whichever walls stand; but
/// fixed objects of exact layouts may leave the cube and overlap one another, as obstacles and
/// floors are built of them. Objects of exact layouts may touch. A drawn place that touches
/// something is drawn again. Boxes are
/// compared first, by a grid with a cell for each object, then the solids: O(N) while the cube is
/// not crowded.
///
/// In a crowded cube, uniform draws come from the voxels that still hold a free place
/// (layouts/free_voxels.h), which changes no probability. So equal solids find a place for as long
/// as there is one, and the end is proven. A normal layout is only drawn again: its voxels would
/// need weights, and it crowds at the centre long before it is full.
///
/// Throws SceneError where an exact layout does not take so many objects or puts one where it may
/// not be, saying by how much and what to change (layouts/clearance.h). Throws it, saying how full
/// the cube is, how much of it was filled and what to change, where an object that is drawn is
/// larger than the cube, no free place is left, the objects can never fit, or the limits above are
/// reached; it never goes on for ever. One thread; the same on every machine, but that std::sin and
/// std::cos decide the last bit of a ring.
void Place(const plan::Scene& scene, InitialState& state);

/// Throws the SceneErrors of Place that need no place drawn by chance: an exact layout that does
/// not take its objects or puts one where it may not be, an object larger than the cube, objects
/// that can never fit. O(N), and far less than Place where the cube is crowded.
void CheckPlacement(const plan::Scene& scene);

}  // namespace cdb::layouts
