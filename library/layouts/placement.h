// Places every object according to its layout, so that it neither reaches through a wall nor into
// another object.
#pragma once

#include "compiler/plan/plan.h"
#include "library/layouts/initial_state.h"

namespace cdb::layouts {

/// The maximum number of draws for one object, and for all together. Tested voxels count as draws.
inline constexpr std::uint64_t kMaxTriesOfOne = 100000;
inline constexpr std::uint64_t kMinTriesOfAll = 1000000;
inline constexpr std::uint64_t kMeanTriesOfAll = 1000;  ///< per object

/// Up to this packing fraction (of boxes around shapes other than balls), positions are drawn up to
/// kMaxTriesOfOne times; beyond it, an object that failed kMissesBeforeVoxels times in a row is
/// placed by means of the voxels.
inline constexpr double kMaxPlainFill = 0.25;
inline constexpr std::uint64_t kMissesBeforeVoxels = 1000;

/// Packing fractions of equal solids at which random sequential addition ends: slightly above .3841
/// for balls (Zhang and Torquato 2013) and .4227 for aligned cubes, the densest of the other
/// shapes. They hold for many objects that are small compared with the cube; a group of those that
/// needs more is rejected before the first draw.
inline constexpr double kMaxFillOfBalls = 0.40;
inline constexpr double kMaxFillOfOthers = 0.45;
inline constexpr std::uint64_t kManyObjects = 1000;
inline constexpr double kShortOfSide = 0.25;

/// Sets the position of every object of `state`: first, in order, of the groups whose layout
/// defines each position (library/layouts/exact_layouts.h), then, in order, of those drawn around
/// them, from the stream `<group>.location`:
///   uniform  each coordinate uniform over the range in which the object fits between the walls:
///            "uniform over the cube" with positions that touch a wall redrawn
///   normal   each coordinate normal with mean 0 and a third of the wall's coordinate as standard
///            deviation, redrawn until it fits
/// No object overlaps another one of any group, or a wall of the cube, whichever walls are in use;
/// but fixed objects of exact layouts may leave the cube and overlap one another, so that obstacles
/// and floors can be built from them. Objects of exact layouts may touch. A drawn position that
/// touches an object is redrawn. Boxes are compared first, by a grid with a cell for each object,
/// then the solids: O(N) unless the cube is crowded.
///
/// In a crowded cube, uniform positions are drawn from the voxels that still contain a free one
/// (library/layouts/free_voxels.h), which does not change the distribution. So equal solids are
/// placed as long as there is a free position, and its absence is proven. A normal layout is only
/// redrawn: its voxels would need weights, and it crowds at the centre long before the cube is
/// full.
///
/// Throws SceneError if an exact layout does not take this number of objects or gives an invalid
/// position, with the amount and a remedy (library/layouts/clearance.h). Throws it, with the
/// packing fraction, the fraction already filled and a remedy, if a drawn object is larger than the
/// cube, no free position is left, the objects can never fit, or the limits above are reached; so
/// it always terminates. One thread; the same result on every machine, except that the last bit of
/// a ring depends on std::sin and std::cos.
void Place(const plan::Scene& scene, InitialState& state);

/// Throws the SceneErrors of Place that need no random draw: an exact layout that does not take its
/// objects or gives an invalid position, an object larger than the cube, objects that can never
/// fit. O(N), and much faster than Place if the cube is crowded.
void CheckPlacement(const plan::Scene& scene);

}  // namespace cdb::layouts
