#include "library/detectors/third_party/piece_pairs.h"

#include <algorithm>
#include <cmath>

namespace cdb::third_party {
namespace {

using Eigen::Vector3d;

bool IsSame(const Vec3& a, const Vec3& b) { return a.x == b.x && a.y == b.y && a.z == b.z; }

bool IsSame(const Shape& a, const Shape& b) {
  return a.kind == b.kind && IsSame(a.half, b.half) && IsSame(a.centre, b.centre) &&
         a.hulls.data() == b.hulls.data() && a.hulls.size() == b.hulls.size();
}

}  // namespace

void PiecePairs::Prepare(const Scene& scene) {
  form_of_.clear();
  form_of_.reserve(scene.shapes.size());
  for (const Shape& shape : scene.shapes) form_of_.push_back(FormOf(shape));
}

PiecePairs::FormId PiecePairs::FormOf(const Shape& shape) {
  // Scenes have few shapes, or only different ones, so the most recent ones are tried first.
  constexpr std::size_t kTried = 64;
  const std::size_t first = forms_.size() > kTried ? forms_.size() - kTried : 0;
  for (FormId form = forms_.size(); form-- > first;)
    if (IsSame(forms_[form].shape, shape)) return form;
  ConvexDecomposition form{.shape = shape, .balls = {}};
  if (Takes(shape)) {
    for (std::size_t piece = 0; piece < PieceCount(shape); ++piece) {
      Ball ball{.centre = PieceCentre(shape, piece), .radius = 0};
      if (shape.hulls.empty()) {
        ball.centre = ToEigen(shape.centre);
        ball.radius = ToEigen(shape.half).norm();
      } else {
        for (const Vec3& vertex : shape.hulls[piece].vertices)
          ball.radius = std::max(ball.radius, (ToEigen(vertex) - ball.centre).norm());
      }
      form.balls.push_back(ball);
    }
  }
  AddForm(shape);
  forms_.push_back(std::move(form));
  return forms_.size() - 1;
}

bool PiecePairs::Handles(const Scene& scene, Id a, Id b) const {
  return !scene.shapes.empty() && Takes(scene.shapes[a]) && Takes(scene.shapes[b]);
}

void PiecePairs::Gather(const Scene& scene, Id body, const Box& box,
                        std::vector<PlacedBall>& near) const {
  near.clear();
  const Eigen::Matrix3d axes = AxesOf(scene.poses[body]);
  const Vector3d at = ToEigen(scene.poses[body].position);
  const Vector3d lower = ToEigen(box.lower), upper = ToEigen(box.upper);
  const std::vector<Ball>& balls = forms_[form_of_[body]].balls;
  for (std::size_t piece = 0; piece < balls.size(); ++piece) {
    const Vector3d centre = at + axes * balls[piece].centre;
    const Vector3d away = centre - centre.cwiseMax(lower).cwiseMin(upper);
    if (away.norm() <= balls[piece].radius + kNear)
      near.push_back({piece, centre, balls[piece].radius});
  }
}

void PiecePairs::FindContacts(const Scene& scene, std::span<const Pair> pairs,
                              std::vector<Contact>& contacts) {
  for (const Pair& pair : pairs) {
    Gather(scene, pair.a, scene.boxes[pair.b], near_a_);
    Gather(scene, pair.b, scene.boxes[pair.a], near_b_);
    for (const PlacedBall& a : near_a_)
      for (const PlacedBall& b : near_b_)
        if ((a.centre - b.centre).norm() <= a.radius + b.radius + kNear)
          Touch(scene, {pair.a, form_of_[pair.a], a.piece}, {pair.b, form_of_[pair.b], b.piece},
                contacts);
  }
}

void PiecePairs::Add(const Place& a, const Place& b, const Vector3d& at, const Vector3d& normal,
                     double distance, std::vector<Contact>& contacts) {
  if (!at.allFinite() || !std::isfinite(distance) || !(std::abs(normal.norm() - 1) < 1e-6)) return;
  contacts.push_back({.a = a.body,
                      .b = b.body,
                      .on_a = FromEigen(at + distance / 2 * normal),
                      .on_b = FromEigen(at - distance / 2 * normal),
                      .normal = FromEigen(normal),
                      .distance = distance});
}

}  // namespace cdb::third_party
