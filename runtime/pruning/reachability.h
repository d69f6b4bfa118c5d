// Where the objects of a scene can get to in a run: which of them may touch a wall or one another,
// proven before the first cycle. Knows no physics engine. Source: issue "Leave out what a scene
// does not need"; Bullet 3.24 for what it relies on (runtime/needs/flight.h, crowds.h).
//
// Without contacts a body of Bullet's flies along x0 + (v0 + g dt/2) t + g t^2/2 up to rounding, so
// two bodies that no damping slows fly along a straight line in each other's frame. Bodies that may
// meet form a crowd; from the earliest moment of a meeting on, each of its members may be anywhere
// that the crowd's whole energy can take it, and whom it may meet there joins the crowd then.
//
// `nothing_touches` is proven outright, as nothing then ever leaves its free flight. What comes of
// a meeting rests on Bullet not adding more energy than crowds.cc allows for: have a tripwire.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "compiler/plan/plan.h"
#include "library/layouts/initial_state.h"

namespace cdb::pruning {

struct Reachability {
  /// By object: the bits of the standing walls (runtime/needs/needs.h) that it may touch. 0 for
  /// fixed objects.
  std::vector<std::uint8_t> walls;
  /// No two objects, and no object and wall, come within touching distance in the whole run.
  bool nothing_touches = false;
  /// The narrowest escape where nothing touches, of those with walls and of those between objects
  /// near enough to be looked at one by one; else the first meeting that decided against it, and
  /// why the search was given up if it was: `object 17 stays 42.1 m from the wall -y`, `objects 3
  /// and 9 may touch at 1.25 s`. Objects count from 1, as in every message.
  std::string closest;
  /// Moving objects in the largest crowd; 1 where none may meet another. All of them where the
  /// search was given up: too many may meet, one with a soft contact may touch something, one has
  /// `ccd`, or numbers overflow.
  std::size_t largest_crowd = 1;
  /// m: the largest diagonal of any moving object's box in any cycle, its way in one cycle
  /// included, if nothing touches. Bullet switches off what passes 1e6.
  double largest_box = 0;
  /// s: the longest time in a row that any moving object is slower than Bullet's thresholds of
  /// sleep, if nothing touches, or more. Bullet puts to sleep what stays below for 2 s; the
  /// forecast itself allows for that where `sleeping` is on.
  double longest_rest = 0;
};

/// `warmup` and `cycles` together are the run. Allows for rounding in the scene's `precision`. Does
/// not throw: what it cannot follow may touch everything. Deterministic. Any thread. About 5 ms for
/// 1000 objects, 0.2 s for 100000; gives up on a dense scene after about as long.
Reachability AnalyseReachability(const plan::Scene& scene, const layouts::InitialState& state);

}  // namespace cdb::pruning
