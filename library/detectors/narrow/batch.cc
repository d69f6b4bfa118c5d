#include "library/detectors/narrow/batch.h"

#include <algorithm>
#include <tuple>
#include <vector>

#include "library/detectors/narrow/kernels.h"

namespace cdb::narrow {

Kernel* KernelOf(Kind a, Kind b) {
  // In the order of Kind; the second kind is at least the first.
  static constexpr Kernel* kTable[kKinds][kKinds] = {
      {BallBall, BallCapsule, BallBox, Polytopes, AnyPlane},
      {nullptr, CapsuleCapsule, Polytopes, Polytopes, AnyPlane},
      {nullptr, nullptr, BoxBox, Polytopes, AnyPlane},
      {nullptr, nullptr, nullptr, Polytopes, AnyPlane},
      {nullptr, nullptr, nullptr, nullptr, nullptr},
  };
  if (a == Kind::kOther || b == Kind::kOther) return nullptr;
  return kTable[static_cast<int>(a)][static_cast<int>(b)];
}

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

class Batch final : public Detector {
 public:
  void Prepare(const Scene& scene) override {
    pieces_.Prepare(scene);
    hints_ = {};
  }

  bool Handles(const Scene& scene, Id a, Id b) const override {
    if (scene.shapes.empty()) return false;
    const auto [first, second] = std::minmax(pieces_.KindOf(a), pieces_.KindOf(b));
    return KernelOf(first, second) != nullptr;
  }

  void FindContacts(const Scene& scene, std::span<const Pair> pairs,
                    std::vector<Contact>& contacts) override {
    hints_.BeginCycle();
    for (const Pair& pair : pairs) {
      const bool is_swapped = pieces_.KindOf(pair.b) < pieces_.KindOf(pair.a);
      const Id a = is_swapped ? pair.b : pair.a, b = is_swapped ? pair.a : pair.b;
      Kernel* const kernel = KernelOf(pieces_.KindOf(a), pieces_.KindOf(b));
      const std::span<const Piece> of_a = pieces_.Of(a), of_b = pieces_.Of(b);
      const Pose &pose_a = scene.poses[a], &pose_b = scene.poses[b];
      for (std::uint32_t i = 0; i < of_a.size(); ++i) {
        for (std::uint32_t j = 0; j < of_b.size(); ++j) {
          const Placed one = {of_a[i], pose_a}, other = {of_b[j], pose_b};
          if (of_a.size() * of_b.size() > 1 && AreFar(one, other)) continue;
          manifold_.Clear();
          kernel(one, other, hints_.Of(pair, i, j), manifold_);
          for (const Point& point : manifold_.points())
            contacts.push_back(ContactOf(pair, pose_a.position, point, is_swapped));
        }
      }
    }
  }

 private:
  /// By the balls around them.
  static bool AreFar(const Placed& a, const Placed& b) {
    if (b.piece.kind == Kind::kPlane) return false;
    const Vec3 at_a = AxesOf(a.pose) * a.piece.centre, at_b = AxesOf(b.pose) * b.piece.centre;
    const double reach = a.piece.bound + b.piece.bound + kNear;
    return SquaredNorm(b.pose.position - a.pose.position + at_b - at_a) > reach * reach;
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
  Manifold manifold_;
};

}  // namespace

Detector* MakeBatch(const Options&) { return new Batch; }

}  // namespace cdb::narrow
