// The packing fraction of the cube, and the errors that report it.
#pragma once

#include <string>
#include <string_view>

#include "library/layouts/bodies.h"

namespace cdb::layouts {

/// Objects of exact layouts must already be placed; only the part of their boxes inside the cube
/// counts. The bodies must outlive it. Not thread-safe.
class PackingFraction {
 public:
  explicit PackingFraction(const Bodies& bodies);

  /// m^3: the volume of the cube, and of all objects: of balls themselves, and of the boxes around
  /// others.
  double Cube() const { return bodies_.side() * bodies_.side() * bodies_.side(); }
  double balls_and_boxes() const { return balls_and_boxes_; }

  /// Throws SceneError if drawn layouts can never succeed: an object is larger than the cube, all
  /// objects together are, or the equal objects of a group exceed the limit of random placement.
  void RefuseWhatCannotFit() const;
  /// Counts object `index`, which has been placed.
  void CountPlaced(std::size_t index) { placed_volume_ += bodies_.object(index).solid.Volume(); }

  static constexpr std::string_view kGivenUp = "every position drawn was taken";
  static constexpr std::string_view kNoPlaceLeft = "no free position was left";
  [[noreturn]] void TooFull(std::size_t index, std::string_view when) const;

 private:
  void RefuseLarge(std::size_t index) const;
  void RefuseGroup(const GroupRange& range) const;
  /// The fraction of its box that is inside the cube.
  double PartInside(std::size_t index) const;
  std::string Advice() const;

  const Bodies& bodies_;
  double volume_ = 0, placed_volume_ = 0, boxes_ = 0, balls_and_boxes_ = 0;  ///< m^3
};

}  // namespace cdb::layouts
