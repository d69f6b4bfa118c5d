// The box in which a layout places the objects of a group: `objects.region`.
//
// Lengths in m, with the origin at the cube's centre. Errors: SceneError that names the group and
// its region or location. Threads: any.
#pragma once

#include <Eigen/Core>
#include <string_view>

#include "compiler/plan/plan.h"
#include "library/layouts/bodies.h"

namespace cdb::layouts {

struct Region {
  objects::Box box;
  bool stands = false;   ///< the objects stand on the lower face of the box
  bool is_cube = false;  ///< the box is the cube
  bool IsDefault() const { return is_cube && !stands; }
  Eigen::Vector3d Centre() const { return (box.lower + box.upper) / 2; }
  Eigen::Vector3d Extents() const { return box.upper - box.lower; }
  double Volume() const { return Extents().prod(); }
};

/// The group about whose objects the region is; empty if it is about none.
std::string GroupOfRegion(const plan::Group& group);
/// The group whose objects the layout of this one refers to; empty if there is none.
std::string GroupOfLayout(const plan::Group& group);

/// The gap below an object that stands, as a fraction of its height.
inline constexpr double kStandingGap = 1e-3;

/// The region of a group, whose objects lie in it together with the cube. A region at another group
/// is about the boxes around the objects of that group, which must be placed before: it comes
/// before this one in the plan, has objects, and has an exact layout if this one has.
Region RegionOf(const Bodies& bodies, const GroupRange& range);

/// The group `name`, at whose objects those of `range` are placed by their `parameter`, region or
/// location: it comes before in the plan, has objects, and has an exact layout if `range` has one.
const GroupRange& GroupBefore(const Bodies& bodies, const GroupRange& range, std::string_view name,
                              std::string_view parameter);

/// Around the origin.
objects::Box CubeOf(double side);
/// Of a call `box(lower, upper)`.
objects::Box BoxOf(const schema::Call& box);

/// The region of a group that is at no other group.
Region FixedRegionOf(const plan::Group& group, double side);

/// The positions of the centre of mass of an object of bounds `bounds` that keep it within the
/// region and the cube, which is `side` wide; open. One that stands has a gap of half to one and a
/// half times kStandingGap.
objects::Box DomainOf(const Region& region, double side, const objects::Box& bounds);

}  // namespace cdb::layouts
