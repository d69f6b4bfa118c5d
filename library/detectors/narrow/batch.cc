#include "library/detectors/narrow/batch.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <iterator>
#include <memory>
#include <utility>
#include <vector>

#include "library/detectors/kernels/pair_buffer.h"
#include "library/detectors/narrow/kernels.h"

namespace cdb::narrow {
namespace {

/// The hint of a pair of pieces.
struct PairHint {
  Pair pair;
  std::uint32_t piece_a, piece_b;
  Hint hint;

  bool IsOf(const PairHint& other) const {
    return pair == other.pair && piece_a == other.piece_a && piece_b == other.piece_b;
  }
};
/// Those of a cycle in the order of its pairs, a list for each part of them.
using HintLists = std::vector<std::vector<PairHint>>;

/// Reads the hints of the last cycle and writes those of this one, for a part of the pairs. They
/// mostly come in the order of the last cycle, so that the hint of one is soon after that of the
/// one before.
class Hints {
 public:
  /// `place`: of the first pair among all, from 0 to 1. `memory`: for the hints of this cycle.
  void Begin(HintLists& last, double place, std::vector<PairHint> memory) {
    last_ = &last;
    current_ = std::move(memory);
    place_ = place;
    is_first_ = true;
    misses_ = 0;
    list_ = index_ = 0;
  }
  /// That of the last cycle, to be changed for the next. Valid until the next call.
  Hint& Of(const Pair& pair, std::uint32_t piece_a, std::uint32_t piece_b) {
    current_.push_back({pair, piece_a, piece_b, {}});
    PairHint& entry = current_.back();
    if (std::exchange(is_first_, false)) Seek(entry);
    // Where many pairs came or went, the next ones are farther on.
    constexpr int kSoon = 16, kFar = 512;
    if (TakeFrom(entry, kSoon)) {
      misses_ = 0;
    } else if (++misses_ % kSoon == 0 && TakeFrom(entry, kFar)) {
      misses_ = 0;
    }
    return entry.hint;
  }
  /// Those of this cycle.
  std::vector<PairHint> Take() { return std::move(current_); }

 private:
  /// Looks at so many of the last cycle. False if that of the pair is not among them.
  bool TakeFrom(PairHint& entry, int most) {
    std::size_t list = list_, index = index_;
    for (int i = 0; i < most && SkipEnds(list, index); ++i, ++index) {
      PairHint& old = (*last_)[list][index];
      if (!old.IsOf(entry)) continue;
      entry.hint = std::move(old.hint);
      list_ = list;
      index_ = index + 1;
      return true;
    }
    return false;
  }
  /// From the end of a list to the next one that is not empty. False at the end of the last.
  bool SkipEnds(std::size_t& list, std::size_t& index) const {
    while (list < last_->size() && index >= (*last_)[list].size()) ++list, index = 0;
    return list < last_->size();
  }
  /// Where parts meet, pairs may have come or gone before.
  void Seek(const PairHint& first) {
    constexpr std::ptrdiff_t kFar = 512;
    std::ptrdiff_t count = 0;
    for (const auto& list : *last_) count += std::ssize(list);
    const auto expected = static_cast<std::ptrdiff_t>(place_ * static_cast<double>(count));
    for (std::ptrdiff_t way = 0; way < kFar; ++way)
      for (const std::ptrdiff_t at : {expected - way, expected + way})
        if (at >= 0 && at < count && (GoTo(at), (*last_)[list_][index_].IsOf(first))) return;
    GoTo(std::min(expected, count));
  }
  void GoTo(std::ptrdiff_t at) {
    list_ = 0;
    index_ = static_cast<std::size_t>(at);
    while (list_ < last_->size() && index_ >= (*last_)[list_].size())
      index_ -= (*last_)[list_++].size();
  }

  HintLists* last_ = nullptr;
  std::vector<PairHint> current_;
  double place_ = 0;
  bool is_first_ = true;
  int misses_ = 0;                    ///< one after the other
  std::size_t list_ = 0, index_ = 0;  ///< in those of the last cycle
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

/// Finds the contacts of consecutive pairs. Nothing of it is in a cache line of another thread's.
class alignas(64) Finder {
 public:
  explicit Finder(const Pieces& pieces) : pieces_(pieces) {}
  Hints hints;
  std::vector<Contact> contacts;  ///< of a part that is not the first

  void Find(const Scene& scene, std::span<const Pair> pairs, std::vector<Contact>& found) {
    for (const Pair& pair : pairs) {
      const Row& row = kTable.Of(pieces_.Of(pair.a).kind, pieces_.Of(pair.b).kind);
      const Id a = row.is_swapped ? pair.b : pair.a, b = row.is_swapped ? pair.a : pair.b;
      const BodyPieces &of_a = pieces_.Of(a), &of_b = pieces_.Of(b);
      const Pose &pose_a = scene.poses[a], &pose_b = scene.poses[b];
      if (of_a.count == 1 && of_b.count == 1) {
        FindPoints(pair, row, {*of_a.first, pose_a}, {*of_b.first, pose_b}, 0, 0, found);
        continue;
      }
      if (AreFar(of_a, pose_a, of_b, pose_b)) continue;
      const std::size_t before = found.size();
      for (std::uint32_t i = 0; i < of_a.count; ++i)
        for (std::uint32_t j = 0; j < of_b.count; ++j)
          if (const Placed one = {of_a.first[i], pose_a}, other = {of_b.first[j], pose_b};
              !AreFar(one, other))
            FindPoints(pair, row, one, other, i, j, found);
      if (found.size() - before > kMostPoints) SortByDepth(std::span(found).subspan(before));
    }
  }

 private:
  /// Of pieces i and j, which come in the order of the row.
  void FindPoints(const Pair& pair, const Row& row, const Placed& one, const Placed& other,
                  std::uint32_t i, std::uint32_t j, std::vector<Contact>& found) {
    manifold_.Clear();
    row.kernel(one, other, row.has_hint ? hints.Of(pair, i, j) : no_hint_, manifold_);
    const std::span<Point> points = manifold_.points();
    if (points.empty()) return;
    SortAroundNormal(points);
    for (const Point& point : points)
      if (IsFinite(point))
        found.push_back(ContactOf(pair, one.pose.position, point, row.is_swapped));
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

  const Pieces& pieces_;
  Hint no_hint_;
  Manifold manifold_;
};

/// Each thread takes parts of the pairs, whose contacts follow each other in the order of the
/// pairs.
class Batch final : public Detector {
 public:
  explicit Batch(unsigned threads) : parts_(threads), last_(parts_.most()), current_(last_.size()) {
    for (std::size_t part = 0; part < last_.size(); ++part)
      finders_.push_back(std::make_unique<Finder>(pieces_));
  }

  void Prepare(const Scene& scene) override {
    pieces_.Prepare(scene);
    for (auto* lists : {&last_, &current_})
      for (auto& list : *lists) list.clear();
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
    std::swap(last_, current_);
    for (auto& list : current_) list.clear();
    const auto count = static_cast<double>(pairs.size());
    const double work = kWorkOfPair * count;
    const kernels::ThreadPool::Session session = parts_.Begin(work);
    const unsigned parts = parts_.ForEach(
        work, 0, pairs.size(), 1, [&](unsigned part, std::size_t from, std::size_t to) {
          Finder& finder = *finders_[part];
          finder.contacts.clear();
          finder.hints.Begin(last_, static_cast<double>(from) / count, std::move(current_[part]));
          finder.Find(scene, pairs.subspan(from, to - from),
                      part == 0 ? contacts : finder.contacts);
          current_[part] = finder.hints.Take();
        });
    for (unsigned part = 1; part < parts; ++part) {
      const std::vector<Contact>& found = finders_[part]->contacts;
      contacts.insert(contacts.end(), found.begin(), found.end());
    }
  }

 private:
  static constexpr double kWorkOfPair = 60;  // ns; some pairs take ten times as long

  Pieces pieces_;
  kernels::PairParts parts_;
  HintLists last_, current_;
  std::vector<std::unique_ptr<Finder>> finders_;
};

}  // namespace

Detector* MakeBatch(const Options& options) { return new Batch(options.threads); }

}  // namespace cdb::narrow
