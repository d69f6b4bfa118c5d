// What the narrow phases of other libraries share: a body is the union of convex pieces, and each
// pair of pieces that may touch is one question to the library.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "library/detectors/detector.h"
#include "library/detectors/third_party/convex.h"

namespace cdb::third_party {

/// m: bodies so near are worth a contact (detector.h).
inline constexpr double kNear = 0.02;

/// Threads: one, as every detector.
class PiecePairs : public Detector {
 public:
  void Prepare(const Scene& scene) final;
  /// Planes go to Bullet, and all of a scene that has boxes alone.
  bool Handles(const Scene& scene, Id a, Id b) const final;
  void FindContacts(const Scene& scene, std::span<const Pair> pairs,
                    std::vector<Contact>& contacts) final;

 protected:
  /// Bodies of equal shape share a form.
  using FormId = std::size_t;
  struct Place {
    Id body;
    FormId form;
    std::size_t piece;
  };

  virtual bool Takes(const Shape& shape) const { return shape.kind != ShapeKind::kPlane; }
  /// Once for each form, in order from 0.
  virtual void AddForm(const Shape& /*shape*/) {}
  /// Appends the contacts of two pieces.
  virtual void Touch(const Scene& scene, const Place& a, const Place& b,
                     std::vector<Contact>& contacts) = 0;

  /// The ball around a piece, in the body's frame.
  struct Ball {
    Eigen::Vector3d centre;
    double radius;
  };
  const Ball& BallOf(const Place& place) const { return forms_[place.form].balls[place.piece]; }

  /// Appends a contact halfway about `at`, unless it is no number; `normal` unit, from b to a.
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
  /// Those of the body's pieces that come near the box.
  void Gather(const Scene& scene, Id body, const Box& box, std::vector<PlacedBall>& near) const;

  std::vector<ConvexDecomposition> forms_;
  std::vector<FormId> form_of_;
  std::vector<PlacedBall> near_a_, near_b_;
};

}  // namespace cdb::third_party
