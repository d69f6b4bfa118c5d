// Objects fall onto one another and come to rest.
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <vector>

#include "runtime/engine/worker/contact_reuse.h"
#include "runtime/engine/world/engine.h"

namespace cdb::worker {

/// At rest: of all but so many, which roll or tremble, no point moves farther than this in a unit
/// of time, in mean diameters, for kRestChecks units in a row.
inline constexpr double kRestDisplacement = 0.03;
inline constexpr double kRestless = 0.02;  ///< of the objects
inline constexpr int kRestChecks = 3;
/// Units of time, beside that of the fall, after which objects are given up.
inline constexpr double kSettleTime = 400;

/// Objects that fall in an engine in which all others stand still.
struct Falling {
  std::vector<std::uint32_t> objects;
  // Means of them.
  double diameter = 0;           ///< of the ball around one, m
  double least_half_extent = 0;  ///< m
  double gravity = 0;            ///< m/s^2

  /// In which an object at rest falls half a diameter; s.
  double UnitOfTime() const { return std::sqrt(diameter / gravity); }
  /// Short enough for impacts, and for thin objects not to sink into one another; s.
  double Timestep() const;
};

/// Steps `engine`, whose time step is that of `falling`, until the objects are at rest. They are
/// damped so little that they find their places, and somewhat more once nearly all have stopped
/// falling; an object that nothing holds still falls. `bodies` are all objects of the
/// engine. Calls `tell` with the number of objects at rest, once in a unit of time. Throws
/// library::SceneError if they do not come to rest.
void ComeToRest(world::Engine& engine, const Falling& falling,
                std::vector<ContactReuse::Body> bodies,
                const std::function<void(std::size_t at_rest)>& tell);

}  // namespace cdb::worker
