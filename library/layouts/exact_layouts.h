// Layouts that define each position: grid, stack, pyramid, pile, ring, line, at, pair, poses, path.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string_view>
#include <vector>

#include "compiler/plan/plan.h"
#include "library/layouts/bodies.h"
#include "library/layouts/initial_state.h"

namespace cdb::layouts {

/// True if the layout of the group is one of these, so that it is not drawn.
bool HasExactLayout(const plan::Group& group);
/// True if the layout is `pile` and the group has objects, which the engine then settles.
bool IsPile(const plan::Group& group);

/// Gives every object of a group with such a layout its place. Nothing is left to chance but the
/// direction of a pair. Coordinates in m, the cube's centre at the origin; boxes are along the
/// world's axes, around the turned objects. Objects are taken in order, x running fastest, then z,
/// then upwards:
///   grid     the first places of a cubic lattice about the origin with ceil(cbrt n) along each
///            edge; the box's centre at the cell's. fit: the cells fill the cube
///   stack    columns, each filled from the floor before the next begins; boxes `gap` apart and
///            above the floor, centred on the column's axis. The axes are a square lattice about
///            x = z = 0 with ceil(sqrt columns) along each edge. fit: see
///            compiler/schema/parametrised_words.cc; the first object's gap to the floor is a
///            thousandth of its own height
///   pyramid  square layers about x = z = 0 from the smallest base that holds n, each one fewer
///            along both sides; cells as large as the largest box along each axis and `gap`; boxes
///            stand on the cell's floor
///   ring     boxes' centres at the angles 2 pi i/n about y, the first on +x. fit: the smallest
///            radius at which the boxes of neighbours are a tenth of the largest extent apart
///   line     the centres of mass on a line through the origin, the surfaces `gap` apart along it;
///            what they reach along it, centred. fit: a tenth of the largest extent
///   at       the centre of mass, of each object in order where it lists points
///   pair     the surfaces `distance` apart where the second, coming from afar in a direction drawn
///            uniformly on the sphere from the stream `<group>.location`, first is so near; the
///            middle of the centres of mass at the origin. A direction in which it passes by is
///            drawn again
///   poses    as the file says, DrawObjects having read it
///   path     where the path begins, DrawObjects having read it
///   pile     as PlacesAbovePile
/// O(n). Does not look at other groups, nor at the cube's walls. Throws SceneError where the layout
/// does not take so many objects.
void PlaceExactly(const plan::Scene& scene, const GroupRange& range, Bodies& bodies);

/// Where the objects of a group with `location pile` are dropped from: a loose lattice that stands
/// on the floor about x = z = 0, its cells a little larger than the largest object however it is
/// turned, `width` wide at most; the centre of mass at the cell's. fit: as many cells along x and z
/// as ceil(cbrt n). `side` is the cube's, m; `objects` are those of the group, already drawn.
/// Throws SceneError where the lattice is higher than the cube, or `width` is less than one object
/// needs.
std::vector<Eigen::Vector3d> PlacesAbovePile(const plan::Group& group, double side,
                                             std::span<const ObjectState> objects);

/// What to change where objects of one group, of any layout, are in each other's place, and where
/// one leaves the cube: `make radius larger`.
struct LayoutAdvice {
  std::string_view overlap, wall;
};
const LayoutAdvice& AdviceOf(const plan::Group& group);

}  // namespace cdb::layouts
