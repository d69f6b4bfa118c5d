#include "library/detectors/narrow/batch.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <vector>

#include "library/detectors/narrow/kernels.h"

namespace cdb::narrow {
namespace {

/// Hints by pair of pieces. Pairs mostly come in the order of the last cycle, so that the hint of
/// one is soon after that of the one before.
class Hints {
 public:
  void BeginCycle() {
    std::swap(last_, current_);
    current_.clear();
    cursor_ = 0;
  }
  /// That of the last cycle, to be changed for the next. Valid until the next call.
  Hint& Of(const Pair& pair, std::uint32_t piece_a, std::uint32_t piece_b) {
    current_.push_back({pair, piece_a, piece_b, {}});
    Entry& entry = current_.back();
    constexpr std::size_t kSoon = 16;
    const std::size_t end = std::min(last_.size(), cursor_ + kSoon);
    for (std::size_t i = cursor_; i < end; ++i) {
      const Entry& old = last_[i];
      if (old.pair != pair || old.piece_a != piece_a || old.piece_b != piece_b) continue;
      entry.hint = old.hint;
      cursor_ = i + 1;
      break;
    }
    return entry.hint;
  }

 private:
  struct Entry {
    Pair pair;
    std::uint32_t piece_a, piece_b;
    Hint hint;
  };
  std::vector<Entry> last_, current_;
  std::size_t cursor_ = 0;
};

/// How a pair of kinds is done.
struct Row {
  Kernel* kernel = nullptr;
  bool is_swapped = false;  ///< the second body comes first
  bool has_hint = false;
};

/// By the kinds of both bodies, in the order of Kind.
class Table {
 public:
  constexpr Table() {
    const auto set = [&](Kind a, Kind b, Kernel* kernel, bool has_hint) {
      At(a, b) = {kernel, false, has_hint};
      if (a != b) At(b, a) = {kernel, true, has_hint};
    };
    set(Kind::kBall, Kind::kBall, BallBall, false);
    set(Kind::kBall, Kind::kCapsule, BallCapsule, false);
    set(Kind::kCapsule, Kind::kCapsule, CapsuleCapsule, false);
    set(Kind::kBall, Kind::kBox, BallBox, false);
    set(Kind::kBox, Kind::kBox, BoxBox, true);
    constexpr Kind kConvex[] = {Kind::kBall,     Kind::kCapsule, Kind::kBox,  Kind::kHull,
                                Kind::kCylinder, Kind::kCone,    Kind::kRound};
    for (const Kind kind : kConvex) {
      for (const Kind other : {Kind::kHull, Kind::kCylinder, Kind::kCone, Kind::kRound})
        set(kind, other, Polytopes, true);
      set(kind, Kind::kPlane, AnyPlane, false);
    }
    set(Kind::kCapsule, Kind::kBox, Polytopes, true);
  }
  constexpr const Row& Of(Kind a, Kind b) const {
    return rows_[static_cast<std::size_t>(a)][static_cast<std::size_t>(b)];
  }

 private:
  constexpr Row& At(Kind a, Kind b) {
    return rows_[static_cast<std::size_t>(a)][static_cast<std::size_t>(b)];
  }
  Row rows_[kKinds][kKinds] = {};
};
constexpr Table kTable;

class Batch final : public Detector {
 public:
  void Prepare(const Scene& scene) override {
    pieces_.Prepare(scene);
    hints_ = {};
  }

  /// Not two compounds: they touch in several places with different normals, and Bullet keeps four
  /// points of a pair that a detector handles, which do not hold them.
  bool Handles(const Scene& scene, Id a, Id b) const override {
    if (scene.shapes.empty()) return false;
    const BodyPieces &of_a = pieces_.Of(a), &of_b = pieces_.Of(b);
    return (of_a.count == 1 || of_b.count == 1) &&
           kTable.Of(of_a.kind, of_b.kind).kernel != nullptr;
  }

  void FindContacts(const Scene& scene, std::span<const Pair> pairs,
                    std::vector<Contact>& contacts) override {
    hints_.BeginCycle();
    for (const Pair& pair : pairs) {
      const Row& row = kTable.Of(pieces_.Of(pair.a).kind, pieces_.Of(pair.b).kind);
      const Id a = row.is_swapped ? pair.b : pair.a, b = row.is_swapped ? pair.a : pair.b;
      const BodyPieces &of_a = pieces_.Of(a), &of_b = pieces_.Of(b);
      const Pose &pose_a = scene.poses[a], &pose_b = scene.poses[b];
      if (of_a.count == 1 && of_b.count == 1) {
        FindPoints(pair, row, {*of_a.first, pose_a}, {*of_b.first, pose_b}, 0, 0, contacts);
        continue;
      }
      if (AreFar(of_a, pose_a, of_b, pose_b)) continue;
      const std::size_t before = contacts.size();
      for (std::uint32_t i = 0; i < of_a.count; ++i)
        for (std::uint32_t j = 0; j < of_b.count; ++j)
          if (const Placed one = {of_a.first[i], pose_a}, other = {of_b.first[j], pose_b};
              !AreFar(one, other))
            FindPoints(pair, row, one, other, i, j, contacts);
      if (contacts.size() - before > kMostPoints) SortByDepth(std::span(contacts).subspan(before));
    }
  }

 private:
  /// Of pieces i and j, which come in the order of the row.
  void FindPoints(const Pair& pair, const Row& row, const Placed& one, const Placed& other,
                  std::uint32_t i, std::uint32_t j, std::vector<Contact>& contacts) {
    manifold_.Clear();
    row.kernel(one, other, row.has_hint ? hints_.Of(pair, i, j) : no_hint_, manifold_);
    const std::span<Point> points = manifold_.points();
    if (points.empty()) return;
    SortAroundNormal(points);
    for (const Point& point : points)
      if (IsFinite(point))
        contacts.push_back(ContactOf(pair, one.pose.position, point, row.is_swapped));
  }

  /// By balls about their positions; a plane comes second.
  static bool AreFar(const BodyPieces& a, const Pose& pose_a, const BodyPieces& b,
                     const Pose& pose_b) {
    const Vec3 between = pose_a.position - pose_b.position;
    if (b.kind == Kind::kPlane)
      return Dot(AxesOf(pose_b) * b.first->normal, between) >
             a.reach + std::max(kNear, kNear * a.reach);
    const double reach = a.reach + b.reach + kNear;
    return SquaredNorm(between) > reach * reach;
  }
  /// By the balls around them.
  static bool AreFar(const Placed& a, const Placed& b) {
    if (b.piece.kind == Kind::kPlane) return false;
    const Vec3 at_a = AxesOf(a.pose) * a.piece.centre, at_b = AxesOf(b.pose) * b.piece.centre;
    const double reach = a.piece.bound + b.piece.bound + kNear;
    return SquaredNorm(b.pose.position - a.pose.position + at_b - at_a) > reach * reach;
  }

  /// Poses that are not have no contacts; their run has a verdict for it.
  static bool IsFinite(const Point& point) {
    const auto& [x, y, z] = point.on_b;
    return std::isfinite(x + y + z + point.gap + point.normal.x + point.normal.y + point.normal.z);
  }
  /// Bullet's solver takes one point after the other. It brakes a box by up to 1.4 times the
  /// friction if their order changes from cycle to cycle, as that of their depths does. A fixed
  /// order around the face is right unless the box is about to tip over.
  static void SortAroundNormal(std::span<Point> points) {
    if (points.size() < 2) return;
    const Vec3 normal = points[0].normal;
    const Vec3 across =
        std::abs(normal.z) > 0.7 ? Vec3{0, -normal.z, normal.y} : Vec3{-normal.y, normal.x, 0};
    const Vec3 along = Cross(normal, across);
    Vec3 centre = {};
    for (const Point& point : points) centre = centre + point.on_b;
    centre = (1.0 / static_cast<double>(points.size())) * centre;
    double angles[kMostPoints];
    for (std::size_t i = 0; i < points.size(); ++i) {
      const Vec3 arm = points[i].on_b - centre;
      angles[i] = TurnOf(Dot(arm, along), Dot(arm, across));
      const Point moved = points[i];
      const double angle = angles[i];
      std::size_t to = i;
      for (; to > 0 && angle < angles[to - 1]; --to)
        points[to] = points[to - 1], angles[to] = angles[to - 1];
      points[to] = moved;
      angles[to] = angle;
    }
  }
  /// Grows with the angle of (x, y) from -pi to pi.
  static double TurnOf(double x, double y) {
    const double turn = y / (std::abs(x) + std::abs(y) + 1e-300);
    return x >= 0 ? turn : std::copysign(2, y) - turn;
  }
  /// The deepest comes last: where points accumulate, later ones replace those nearby. Stable.
  static void SortByDepth(std::span<Contact> contacts) {
    std::ranges::stable_sort(contacts, std::greater(), &Contact::distance);
  }
  static Contact ContactOf(const Pair& pair, const Vec3& origin, const Point& point,
                           bool is_swapped) {
    const Vec3 on_second = origin + point.on_b, on_first = on_second + point.gap * point.normal;
    return {.a = pair.a,
            .b = pair.b,
            .on_a = is_swapped ? on_second : on_first,
            .on_b = is_swapped ? on_first : on_second,
            .normal = is_swapped ? -point.normal : point.normal,
            .distance = point.gap};
  }

  Pieces pieces_;
  Hints hints_;
  Hint no_hint_;
  Manifold manifold_;
};

}  // namespace

Detector* MakeBatch(const Options&) { return new Batch; }

}  // namespace cdb::narrow
