// The common part of third-party narrow phases: a body is the union of convex pieces, and the
// library is called for each pair of pieces that may touch.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "library/detectors/detector.h"
#include "library/detectors/third_party/convex.h"

namespace cdb::third_party {

/// m: bodies within this distance get a contact (detector.h).
inline constexpr double kNear = 0.02;

/// Threads: one, as for every detector.
class PiecePairs : public Detector {
 public:
  void Prepare(const Scene& scene) final;
  /// False for planes, surfaces, and every pair of a scene without shapes; Bullet then handles
  /// them.
  bool Handles(const Scene& scene, Id a, Id b) const final;
  void FindContacts(const Scene& scene, std::span<const Pair> pairs,
                    std::vector<Contact>& contacts) final;

 protected:
  /// Bodies of equal shape share a form, the library's representation.
  using FormId = std::size_t;
  struct Place {
    Id body;
    FormId form;
    std::size_t piece;
  };

  /// Of superellipsoids, only the support point is known here.
  virtual bool Takes(const Shape& shape) const {
    return shape.kind != ShapeKind::kPlane && shape.kind != ShapeKind::kSurface &&
           shape.kind != ShapeKind::kSuperellipsoid;
  }
  /// Called once for each form, numbered from 0.
  virtual void AddForm(const Shape& /*shape*/) {}
  /// Appends the contacts of two pieces.
  virtual void Touch(const Scene& scene, const Place& a, const Place& b,
                     std::vector<Contact>& contacts) = 0;

  /// The bounding sphere of a piece, in the body's frame.
  struct Ball {
    Eigen::Vector3d centre;
    double radius;
  };
  const Ball& BallOf(const Place& place) const { return forms_[place.form].balls[place.piece]; }

  /// Appends a contact centred at `at`, unless it contains a NaN; `normal` is unit, from b to a.
  static void Add(const Place& a, const Place& b, const Eigen::Vector3d& at,
                  const Eigen::Vector3d& normal, double distance, std::vector<Contact>& contacts);

 private:
  struct ConvexDecomposition {
    Shape shape;
    std::vector<Ball> balls;
  };
  struct PlacedBall {
    std::size_t piece;
    Eigen::Vector3d centre;
    double radius;
  };
  FormId FormOf(const Shape& shape);
  /// Gathers the pieces of the body that are near the box.
  void Gather(const Scene& scene, Id body, const Box& box, std::vector<PlacedBall>& near) const;

  std::vector<ConvexDecomposition> forms_;
  std::vector<FormId> form_of_;
  std::vector<PlacedBall> near_a_, near_b_;
};

}  // namespace cdb::third_party
