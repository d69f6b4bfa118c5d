// Compounds: solids made of convex pieces of a mesh, and surfaces, whose pieces are its triangles;
// a height field computes them when asked.
//
// A form holds the data that all solids of one mesh share, whatever their size; a compound is a
// form with its three sides. Lengths in m. Threads: any, once made.
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "library/meshes/decompose.h"
#include "library/meshes/mass_properties.h"
#include "library/objects/height_surface.h"
#include "library/terrain/voxel_grid.h"

namespace cdb::objects {

// A bounding volume hierarchy over static boxes.
//
// Built once by splitting at the median of the longest axis. A query visits the boxes that overlap
// another one, in an order that depends only on the boxes. O(n log^2 n) to build, O(log n) for each
// box found. Threads: any, once built. Source: Ericson, Real-Time Collision Detection, 2005,
// section 6.2.

class BoxTree {
 public:
  explicit BoxTree(std::vector<Eigen::AlignedBox3d> boxes);

  std::size_t size() const { return boxes_.size(); }
  /// Calls `visit(index)` for boxes that overlap or touch `box`, until it returns true; returns
  /// whether it did.
  template <typename Visit>
  bool AnyOf(const Eigen::AlignedBox3d& box, Visit visit) const {
    return !nodes_.empty() && AnyBelow(0, box, visit);
  }

 private:
  static constexpr std::uint32_t kLeafSize = 4;
  /// A leaf contains order_ in [first, end); the children of an inner node are the next node and
  /// `second`.
  struct Node {
    Eigen::AlignedBox3d box;
    std::uint32_t first, end, second;
  };

  std::uint32_t Build(std::uint32_t first, std::uint32_t end);

  template <typename Visit>
  bool AnyBelow(std::uint32_t index, const Eigen::AlignedBox3d& box, Visit& visit) const {
    const Node& node = nodes_[index];
    if (!node.box.intersects(box)) return false;
    if (node.second != 0)
      return AnyBelow(index + 1, box, visit) || AnyBelow(node.second, box, visit);
    for (std::uint32_t i = node.first; i < node.end; ++i)
      if (boxes_[order_[i]].intersects(box) && visit(std::size_t{order_[i]})) return true;
    return false;
  }

  std::vector<Eigen::AlignedBox3d> boxes_;
  std::vector<std::uint32_t> order_;
  std::vector<Node> nodes_;
};

/// Vertices are relative to the centre of the piece's box.
struct ConvexPiece {
  Eigen::Vector3d centre, half;  ///< of the box
  std::vector<Eigen::Vector3d> vertices;
  std::vector<meshes::Triangle> faces;  ///< counter-clockwise from outside
  bool operator==(const ConvexPiece&) const = default;
};

/// A mesh and its pieces, each scaled so that the box around it is the cube of side 1 about the
/// origin. Pieces and mesh differ slightly; scaled in this way, a compound has exactly the
/// requested sides.
struct ConvexDecomposition {
  std::string name;             ///< as written in a scenario: `bunny`, `mesh("rock.obj")`
  Eigen::Vector3d proportions;  ///< sides of the mesh's own box, the longest 1
  std::vector<ConvexPiece> pieces;
  double native_side = 0;  ///< the longest side, in the unit of the file
  Eigen::Vector3d file_origin = Eigen::Vector3d::Zero();     ///< that of the file; in the cube
  double volume = 0;                                         ///< of the mesh; in the cube
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();          ///< of mass, of the mesh
  Eigen::Matrix3d second_moments = Eigen::Matrix3d::Zero();  ///< mean of x x^T about the centre
  double volume_error = 0, iou = 0, overlap = 0,
         hull_overlap = 0;  ///< of the pieces: library/meshes/decompose.h
  double unit = 1;          ///< m, of the file
  /// Of ground that a formula gives: m, how far its triangles are from it, at so many points.
  double deviation = 0;
  std::size_t points_compared = 0;
  std::string left_out = {};  ///< parts of the file: library/meshes/mesh.h
  /// The point that a user places; in the cube.
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();
  /// For a surface (library/objects/surface.h): a tree of the boxes of its triangles. Null for
  /// others.
  std::shared_ptr<const BoxTree> tree = nullptr;
  /// For a height field, instead of pieces, as there may be millions. Null for others.
  std::shared_ptr<const HeightSurface> heights = nullptr;
  bool IsSurface() const { return tree != nullptr || heights != nullptr; }
  /// For a surface around solid cells (library/terrain/voxel_grid.h): these, so that its inside is
  /// known. Null for others.
  std::shared_ptr<const terrain::VoxelGrid> voxels = nullptr;
  /// Of a surface, the number of triangles.
  std::size_t PieceCount() const { return heights ? heights->TriangleCount() : pieces.size(); }
  bool operator==(const ConvexDecomposition&) const = default;
};

/// `properties` are those of `mesh`, in its axes and unit.
ConvexDecomposition MakeDecomposition(std::string name, const meshes::Mesh& mesh,
                                      const meshes::MassProperties& properties,
                                      const meshes::Decomposition& pieces);

/// In the body's frame: the centre of mass is the origin, the axes are the principal ones.
class Compound {
 public:
  Compound(std::shared_ptr<const ConvexDecomposition> form, const Eigen::Vector3d& sides);

  const ConvexDecomposition& form() const { return *form_; }
  const std::shared_ptr<const ConvexDecomposition>& shared_form() const { return form_; }
  const Eigen::Vector3d& sides() const { return sides_; }
  double Volume() const { return volume_; }
  const Eigen::Vector3d& InertiaPerMass() const { return inertia_; }
  /// The rotation from the axes of the mesh, along which the sides are, to those of the body.
  const Eigen::Matrix3d& from_mesh() const { return from_mesh_; }
  /// From the point that a user places to the centre of mass.
  Eigen::Vector3d OriginToCentre() const {
    return from_mesh_ * (form_->centre - form_->origin).cwiseProduct(sides_);
  }
  /// The centre of the box of a piece.
  Eigen::Vector3d PieceCentre(std::size_t piece) const;
  /// A vertex of a piece.
  Eigen::Vector3d Corner(std::size_t piece, std::size_t vertex) const {
    if (form_->heights) return ToBody(form_->heights->Corner(piece, vertex));
    return ToBody(form_->pieces[piece].centre + form_->pieces[piece].vertices[vertex]);
  }
  /// For a surface: calls `visit(piece)` for triangles whose boxes overlap `box`, until it returns
  /// true; returns whether it did.
  template <typename Visit>
  bool AnyPieceIn(const Eigen::AlignedBox3d& box, Visit visit) const {
    const Eigen::AlignedBox3d in_form(box.min().cwiseQuotient(sides_),
                                      box.max().cwiseQuotient(sides_));
    return form_->heights ? form_->heights->AnyOf(in_form, visit)
                          : form_->tree->AnyOf(in_form, visit);
  }
  /// For a surface around solid cells: whether a point is in one of these. False for others.
  bool IsInCells(const Eigen::Vector3d& point) const;
  /// Whether a point is in the piece.
  bool PieceContains(std::size_t piece, const Eigen::Vector3d& point) const;
  /// The farthest point of the piece along `direction`.
  Eigen::Vector3d Support(std::size_t piece, const Eigen::Vector3d& direction) const;
  /// The farthest point of all pieces.
  Eigen::Vector3d Support(const Eigen::Vector3d& direction) const;
  /// Radius of a ball about the origin that is inside one piece; 0 if the origin is in none.
  double inner_radius() const { return inner_radius_; }
  /// Radius of the smallest ball about the origin that contains the compound.
  double outer_radius() const { return outer_radius_; }
  /// The smallest half extent of a piece along the axes of the mesh.
  double PieceHalfExtent(std::size_t piece) const {
    return form_->pieces[piece].half.cwiseProduct(sides_).minCoeff();
  }
  /// The smallest of all pieces; for a surface, which is thin everywhere, that of its longest side,
  /// so that the other object of a contact is the smaller one.
  double least_half_extent() const { return least_half_extent_; }

 private:
  Eigen::Vector3d ToBody(const Eigen::Vector3d& in_form) const {
    return from_mesh_ * (in_form - form_->centre).cwiseProduct(sides_);
  }
  double InnerRadiusOf(const ConvexPiece& piece) const;
  void MeasureSurface();

  std::shared_ptr<const ConvexDecomposition> form_;
  Eigen::Vector3d sides_, inertia_;
  Eigen::Matrix3d from_mesh_;
  double volume_ = 0, inner_radius_ = 0, outer_radius_ = 0, least_half_extent_ = 0;
};

}  // namespace cdb::objects
