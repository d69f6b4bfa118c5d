// Compounds: solids made of convex pieces of a mesh, and surfaces, whose pieces are its triangles.
//
// A form is what all solids of one mesh share, whatever their size; a compound is a form with its
// three sides. Lengths in m. Threads: any, once made.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "library/meshes/decompose.h"
#include "library/meshes/heights.h"
#include "library/meshes/mass_properties.h"
#include "library/objects/box_tree.h"

namespace cdb::objects {

/// Vertices are relative to the centre of the piece's own box.
struct ConvexPiece {
  Eigen::Vector3d centre, half;  ///< of the box
  std::vector<Eigen::Vector3d> vertices;
  std::vector<meshes::Triangle> faces;  ///< counter-clockwise from outside
  bool operator==(const ConvexPiece&) const = default;
};

/// A mesh and its pieces, each stretched so that the box around it is the cube of side 1 about the
/// origin. Pieces and mesh differ by a little, so a compound has just the sides that it is asked
/// for.
struct ConvexDecomposition {
  std::string name;             ///< as a scenario writes it: `bunny`, `mesh("rock.obj")`
  Eigen::Vector3d proportions;  ///< sides of the mesh's own box, the longest 1
  std::vector<ConvexPiece> pieces;
  double volume = 0;                                         ///< of the mesh; of the cube
  Eigen::Vector3d centre = Eigen::Vector3d::Zero();          ///< of mass, of the mesh
  Eigen::Matrix3d second_moments = Eigen::Matrix3d::Zero();  ///< mean of x x^T about the centre
  double volume_error = 0, iou = 0;  ///< of the pieces: library/meshes/decompose.h
  /// Of a surface (library/objects/surface.h): its triangles' boxes. Null for solids.
  std::shared_ptr<const BoxTree> tree = nullptr;
  bool IsSurface() const { return tree != nullptr; }
  /// Of a surface that is a height field: its grid. Null for others.
  std::shared_ptr<const meshes::HeightGrid> heights = nullptr;
  bool operator==(const ConvexDecomposition&) const = default;
};

/// `properties` are those of `mesh`, in its own axes and unit.
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
  /// Takes a vector of the mesh's axes, those that the sides are along, to the body's.
  const Eigen::Matrix3d& from_mesh() const { return from_mesh_; }
  /// The middle of a piece's box.
  Eigen::Vector3d PieceCentre(std::size_t piece) const;
  /// One of its vertices.
  Eigen::Vector3d Corner(std::size_t piece, std::size_t vertex) const {
    return ToBody(form_->pieces[piece].centre + form_->pieces[piece].vertices[vertex]);
  }
  /// Of a surface: calls `visit(piece)` for triangles whose boxes meet `box`, until it returns
  /// true; returns whether it did.
  template <typename Visit>
  bool AnyPieceIn(const Eigen::AlignedBox3d& box, Visit visit) const {
    return form_->tree->AnyOf({box.min().cwiseQuotient(sides_), box.max().cwiseQuotient(sides_)},
                              visit);
  }
  /// The farthest point of the piece along `direction`.
  Eigen::Vector3d Support(std::size_t piece, const Eigen::Vector3d& direction) const;
  /// The farthest of all pieces.
  Eigen::Vector3d Support(const Eigen::Vector3d& direction) const;
  /// Of a ball about the origin that is inside one piece; 0 where the origin is in none.
  double inner_radius() const { return inner_radius_; }
  /// Of the smallest ball about the origin that holds all.
  double outer_radius() const { return outer_radius_; }
  /// Of all pieces, along the mesh's axes; of a surface, which is thin everywhere, of its longest
  /// side, so that what touches it is the smaller one.
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
