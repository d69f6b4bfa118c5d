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

/// True if the group has one of these layouts, whose positions are not drawn.
bool HasExactLayout(const plan::Group& group);
/// True if the layout is `pile` and the group has objects, which the engine then settles.
bool IsPile(const plan::Group& group);

/// Sets the position of every object of a group with such a layout. Nothing is random except the
/// direction of a pair. Coordinates in m, with the origin at the cube's centre; boxes are along the
/// world's axes, around the rotated objects. The origin is the centre of the group's region
/// (library/layouts/region.h), the floor its lower face; at, poses, path and pile have none. A
/// group that is not a stack or pyramid moves up or down as a whole if it is to stand. Objects are
/// taken in order, x running fastest, then z, then upwards:
///   grid     the first positions of a cubic lattice about the origin with ceil(cbrt n) along each
///            edge; boxes are centred in the cells. fit: the cells fill the region
///   stack    columns, each filled from the floor before the next begins; boxes `gap` apart and
///            above the floor, centred on the column's axis. The axes are a square lattice about
///            x = z = 0 with ceil(sqrt columns) along each edge. fit: see
///            compiler/schema/parametrised_words.cc; the first object's gap to the floor is a
///            thousandth of its own height
///   pyramid  square layers about x = z = 0 from the smallest base that holds n, each with one
///            object fewer along both sides; cells are `gap` larger along each axis than the
///            largest box; boxes stand on the cell's floor
///   ring     boxes' centres at the angles 2 pi i/n about y, the first on +x. fit: the smallest
///            radius at which the boxes of neighbours are a tenth of the largest extent apart
///   line     the centres of mass on a line through the origin, the surfaces `gap` apart along it;
///            the whole is centred along the line. fit: a tenth of the largest extent
///   at       the centre of mass; that of each object in order if several points are listed
///   pair     the second object approaches from afar, in a direction drawn uniformly on the sphere
///            from the stream `<group>.location`, until the surfaces are `distance` apart; the
///            midpoint of the centres of mass is the origin. A direction in which it passes by is
///            drawn again, up to 1000 times
///   relative_to  at the offset from the origin of object i of the other group, or of its single
///   one,
///            in the frame of that object, and turned with it; see GroupBefore
///   poses    as in the file, which DrawObjects has read
///   path     the start of the path, which DrawObjects has read
///   pile     see PlacesAbovePile
/// O(n). Does not consider other groups or the cube's walls. Throws SceneError if the layout cannot
/// hold this number of objects, or if no direction brings a pair together.
void PlaceExactly(const plan::Scene& scene, const GroupRange& range, Bodies& bodies);

/// The positions from which the objects of a group with `location pile` are dropped: a loose
/// lattice that stands on the floor about x = z = 0. Its cells are slightly larger than the largest
/// object in any orientation, with the centre of mass at the centre of the cell; it is at most
/// `width` wide. fit: ceil(cbrt n) cells along x and z. `side` is the side of the cube, m;
/// `objects` are those of the group, already drawn. Throws SceneError if the lattice is higher than
/// the cube, or if `width` is less than one object needs.
std::vector<Eigen::Vector3d> PlacesAbovePile(const plan::Group& group, double side,
                                             std::span<const ObjectState> objects);

/// What to change if objects of one group, of any layout, overlap, and if one leaves the cube:
/// `make radius larger`.
struct LayoutAdvice {
  std::string_view overlap, wall;
};
const LayoutAdvice& AdviceOf(const plan::Group& group);

}  // namespace cdb::layouts
