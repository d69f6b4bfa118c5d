// The packing fraction of the cube, and the errors that report it.
#pragma once

#include <string>
#include <string_view>

#include "library/layouts/bodies.h"

namespace cdb::layouts {

/// Objects of exact layouts must stand already; they count with that part of them that is inside
/// the cube, by their boxes. The bodies must outlive it. Not for several threads.
class PackingFraction {
 public:
  explicit PackingFraction(const Bodies& bodies);

  /// m^3: the cube's, and of all objects: balls' own, and the boxes around the others.
  double Cube() const { return bodies_.side() * bodies_.side() * bodies_.side(); }
  double balls_and_boxes() const { return balls_and_boxes_; }

  /// Throws SceneError where drawn layouts can never succeed: an object is larger than the cube,
  /// all together are, or a group's equal objects need more than chance can fill.
  void RefuseWhatCannotFit() const;
  /// `index` has found its place.
  void CountPlaced(std::size_t index) { placed_volume_ += bodies_.object(index).solid.Volume(); }

  static constexpr std::string_view kGivenUp = "every place drawn was taken";
  static constexpr std::string_view kNoPlaceLeft = "no free place was left";
  [[noreturn]] void TooFull(std::size_t index, std::string_view when) const;

 private:
  void RefuseLarge(std::size_t index) const;
  void RefuseGroup(const GroupRange& range) const;
  /// Of its box.
  double PartInside(std::size_t index) const;
  std::string Advice() const;

  const Bodies& bodies_;
  double volume_ = 0, placed_volume_ = 0, boxes_ = 0, balls_and_boxes_ = 0;  ///< m^3
};

}  // namespace cdb::layouts
