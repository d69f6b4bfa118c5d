// Convex hulls of many sets of points, for a search that needs only their volumes.
//
// Plain double arithmetic in a fixed order: the same points give the same bytes with any compiler.
// Points less than 1e-7 of the largest extent outside count as inside. Lengths in the unit of the
// points. Errors: none; flat points have volume 0. Threads: one at a time for each object, which
// keeps its memory. Source: Barber, Dobkin & Huhdanpaa, "The Quickhull algorithm for convex hulls",
// ACM TOMS 22(4), 1996.
#pragma once

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace cdb::meshes {

class QuickHull {
 public:
  double Volume(std::span<const Eigen::Vector3d> points);
  /// Of at most `most` of the points, 4 or more, or as many as have the volume `enough`: the next
  /// one is always the one that adds most.
  double Volume(std::span<const Eigen::Vector3d> points, std::size_t most, double enough);
  /// The corners of the last hull, as indices of its points, ascending. Empty for flat points.
  std::vector<std::uint32_t> Corners() const;

 private:
  static constexpr std::uint32_t kNone = 0xffffffff;
  struct Face {
    std::array<std::uint32_t, 3> corner;
    std::array<std::uint32_t, 3> next;  ///< the face across the edge from corner i to i + 1
    Eigen::Vector3d normal;
    double offset;
    std::uint32_t outside;  ///< the first point of a list: outside this face, in none of the others
    std::uint32_t farthest;  ///< of that list
    double distance;         ///< of the farthest point; 0 without points
    std::uint32_t seen_from;
    bool is_alive;
  };
  struct HorizonEdge {
    std::uint32_t from, to, beyond;  ///< `beyond`: the face that is not seen
  };

  bool Start();
  std::uint32_t AddFace(std::uint32_t a, std::uint32_t b, std::uint32_t c);
  double Distance(const Face& face, std::uint32_t point) const;
  void Assign(std::uint32_t point, std::size_t first_face);
  void FindVisible(std::uint32_t face, std::uint32_t eye);
  /// Six times the volume that `eye` adds.
  double AddedVolume(std::uint32_t face, std::uint32_t eye);
  void Add(std::uint32_t face);
  void Drop(std::uint32_t face);
  std::uint32_t LargestGain();
  bool Begin(std::span<const Eigen::Vector3d> points);
  double Measure() const;

  std::span<const Eigen::Vector3d> points_;
  double tolerance_ = 0;
  std::vector<Face> faces_;
  std::vector<std::uint32_t> next_point_;  ///< by point, the next of its list
  std::vector<std::uint32_t> starts_;      ///< by point, the new face at the horizon edge from it
  std::vector<std::uint32_t> visible_, stack_;
  std::vector<HorizonEdge> horizon_;
};

}  // namespace cdb::meshes
