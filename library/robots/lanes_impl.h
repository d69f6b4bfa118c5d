// The kernel of LaneChecker, for lanes.cc and lanes_avx2.cc only.
#pragma once

#include <cstddef>
#include <cstdint>

#include "library/detectors/kernels/simd.h"
#include "library/robots/lanes.h"

namespace cdb::robots {
namespace {  // compiled for several CPUs: everything needs internal linkage

using kernels::Floats;
using kernels::kFloats;
using kernels::Load;
using kernels::Store;
using FloatMask = kernels::Mask<Floats>;

/// A vector in each lane.
struct Vec {
  Floats x, y, z;
  friend Vec operator+(const Vec& a, const Vec& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Vec operator-(const Vec& a, const Vec& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
};

inline Floats Square(const Vec& v) { return v.x * v.x + v.y * v.y + v.z * v.z; }

/// A rotation in each lane, rows first.
struct Turn {
  Floats at[9];
};

/// Where a link is.
struct Frame {
  Turn turn;
  Vec place;
};

[[gnu::always_inline]] inline Vec Rotate(const Turn& turn, const Vec& v) {
  return {turn.at[0] * v.x + turn.at[1] * v.y + turn.at[2] * v.z,
          turn.at[3] * v.x + turn.at[4] * v.y + turn.at[5] * v.z,
          turn.at[6] * v.x + turn.at[7] * v.y + turn.at[8] * v.z};
}
[[gnu::always_inline]] inline Vec Rotate(const Turn& turn, const float* v) {
  return {turn.at[0] * v[0] + turn.at[1] * v[1] + turn.at[2] * v[2],
          turn.at[3] * v[0] + turn.at[4] * v[1] + turn.at[5] * v[2],
          turn.at[6] * v[0] + turn.at[7] * v[1] + turn.at[8] * v[2]};
}

/// Rounds to a whole number; |x| < 2^51.
inline double Rounded(double x) {
  constexpr double kShift = 0x1.8p52;
  return (x + kShift) - kShift;
}

/// The sine and the cosine of an angle in each lane, within 2^-22. The angle is reduced to an
/// eighth of a turn in double; polynomials of Cephes (S. Moshier, sinf.c).
[[gnu::always_inline]] inline void SineCosine(const double* angles, Floats& sine, Floats& cosine) {
  constexpr double kQuarters = 0x1.45f306dc9c883p-1, kQuarter = 0x1.921fb54442d18p0;
  float rests[kFloats];
  std::int32_t quarters[kFloats];
  for (std::size_t i = 0; i < kFloats; ++i) {
    const double quarter = Rounded(angles[i] * kQuarters);
    rests[i] = static_cast<float>(angles[i] - quarter * kQuarter);
    // The quarter turns modulo 4, as a small number.
    quarters[i] = static_cast<std::int32_t>(quarter - 4 * Rounded(quarter / 4));
  }
  const Floats x = Load<Floats>(rests), square = x * x;
  const FloatMask quarter = Load<FloatMask>(quarters);
  const Floats odd =
      x +
      x * square * (-1.6666654611e-1f + square * (8.3321608736e-3f + square * -1.9515295891e-4f));
  const Floats even = 1.0f - 0.5f * square +
                      square * square *
                          (4.166664568298827e-2f +
                           square * (-1.388731625493765e-3f + square * 2.443315711809948e-5f));
  const FloatMask is_swapped = (quarter & 1) != 0;
  sine = is_swapped ? even : odd;
  cosine = is_swapped ? odd : even;
  sine = (quarter & 2) != 0 ? -sine : sine;
  cosine = ((quarter + 1) & 2) != 0 ? -cosine : cosine;
}

/// The frame of a link in that of the one which holds it.
[[gnu::always_inline]] inline Frame Moved(const LaneModel::Hold& hold, const double* positions,
                                          std::size_t freedoms) {
  Frame frame;
  const Floats zero = {};
  if (hold.freedom < 0) {
    for (int i = 0; i < 9; ++i) frame.turn.at[i] = zero + hold.turn[0][i];
    frame.place = {zero + hold.way[0][0], zero + hold.way[0][1], zero + hold.way[0][2]};
    return frame;
  }
  double by[kFloats];
  for (std::size_t i = 0; i < kFloats; ++i)
    by[i] = positions[i * freedoms + static_cast<std::size_t>(hold.freedom)] - hold.start;
  if (hold.is_slider) {
    float steps[kFloats];
    for (std::size_t i = 0; i < kFloats; ++i) steps[i] = static_cast<float>(by[i]);
    const Floats step = Load<Floats>(steps);
    for (int i = 0; i < 9; ++i) frame.turn.at[i] = zero + hold.turn[0][i];
    frame.place = {hold.way[0][0] + step * hold.way[1][0], hold.way[0][1] + step * hold.way[1][1],
                   hold.way[0][2] + step * hold.way[1][2]};
    return frame;
  }
  Floats sine, cosine;
  SineCosine(by, sine, cosine);
  const auto at = [&](float constant, float of_cosine, float of_sine) {
    return constant + cosine * of_cosine + sine * of_sine;
  };
  for (int i = 0; i < 9; ++i)
    frame.turn.at[i] = at(hold.turn[0][i], hold.turn[1][i], hold.turn[2][i]);
  frame.place = {at(hold.way[0][0], hold.way[1][0], hold.way[2][0]),
                 at(hold.way[0][1], hold.way[1][1], hold.way[2][1]),
                 at(hold.way[0][2], hold.way[1][2], hold.way[2][2])};
  return frame;
}

[[gnu::always_inline]] inline Frame Times(const Frame& outer, const Frame& inner) {
  Frame frame;
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column)
      frame.turn.at[3 * row + column] = outer.turn.at[3 * row] * inner.turn.at[column] +
                                        outer.turn.at[3 * row + 1] * inner.turn.at[3 + column] +
                                        outer.turn.at[3 * row + 2] * inner.turn.at[6 + column];
  frame.place = outer.place + Rotate(outer.turn, inner.place);
  return frame;
}

/// Rounded correctly.
[[gnu::always_inline]] inline Floats Root(Floats square) {
  float roots[kFloats];
  Store(square, roots);
  for (float& root : roots) root = __builtin_sqrtf(root);
  return Load<Floats>(roots);
}

/// The squared distance of points from an obstacle without its edges.
[[gnu::always_inline]] inline Floats SquareFrom(const LaneModel::FloatObstacle& obstacle,
                                                const Vec& point) {
  Vec local = {point.x - obstacle.centre[0], point.y - obstacle.centre[1],
               point.z - obstacle.centre[2]};
  if (!obstacle.is_aligned) {
    const float* a = obstacle.axes;
    local = {a[0] * local.x + a[1] * local.y + a[2] * local.z,
             a[3] * local.x + a[4] * local.y + a[5] * local.z,
             a[6] * local.x + a[7] * local.y + a[8] * local.z};
  }
  const auto beyond = [](Floats x, float half) {
    const Floats over = (x < Floats{} ? -x : x) - half;
    return over > Floats{} ? over : Floats{};
  };
  if (obstacle.disc > 0) {
    const Floats out = beyond(Root(local.x * local.x + local.z * local.z), obstacle.disc),
                 over = beyond(local.y, obstacle.half[1]);
    return out * out + over * over;
  }
  return Square({beyond(local.x, obstacle.half[0]), beyond(local.y, obstacle.half[1]),
                 beyond(local.z, obstacle.half[2])});
}

/// The lanes in which a squared distance is at most this distance.
[[gnu::always_inline]] inline unsigned Within(Floats square, float distance) {
  if (!(distance > 0)) return 0;
  return static_cast<unsigned>(
      kernels::BitsOf(kernels::AtMost(square, kernels::Repeat<Floats>(distance * distance))));
}

constexpr unsigned kAllLanes = (1u << kFloats) - 1;

/// The check of one configuration in each lane.
class Lanes {
 public:
  Lanes(const LaneModel& model, float* room)
      : model_(model), frames_(room), centres_(room + 12 * kFloats * model.holds.size()) {}

  LaneKernel::Answer Check(const double* positions) {
    for (std::size_t i = 0; i < model_.holds.size(); ++i) {
      const LaneModel::Hold& hold = model_.holds[i];
      const Frame moved = Moved(hold, positions, model_.freedoms);
      Keep(i,
           hold.parent < 0 ? moved : Times(FrameOf(static_cast<std::size_t>(hold.parent)), moved));
    }
    for (std::size_t i = 0; i < model_.links.size() && hits_ != kAllLanes; ++i) {
      const LaneModel::Link& link = model_.links[i];
      float* at = CentresOf(link);
      PlaceBalls(link, at);
      for (const std::uint32_t obstacle : link.obstacles)
        AddObstacle(link, at, model_.obstacles[obstacle]);
      for (const std::uint32_t other : link.links) AddLink(link, at, model_.links[other]);
    }
    return {hits_, doubts_ & ~hits_};
  }

 private:
  static void Keep(float* at, const Vec& v) {
    Store(v.x, at);
    Store(v.y, at + kFloats);
    Store(v.z, at + 2 * kFloats);
  }
  static Vec VecAt(const float* at) {
    return {Load<Floats>(at), Load<Floats>(at + kFloats), Load<Floats>(at + 2 * kFloats)};
  }
  void Keep(std::size_t hold, const Frame& frame) {
    float* at = frames_ + 12 * kFloats * hold;
    for (int i = 0; i < 9; ++i) Store(frame.turn.at[i], at + static_cast<std::size_t>(i) * kFloats);
    Keep(at + 9 * kFloats, frame.place);
  }
  Frame FrameOf(std::size_t hold) const {
    const float* at = frames_ + 12 * kFloats * hold;
    Frame frame;
    for (int i = 0; i < 9; ++i)
      frame.turn.at[i] = Load<Floats>(at + static_cast<std::size_t>(i) * kFloats);
    frame.place = VecAt(at + 9 * kFloats);
    return frame;
  }

  float* CentresOf(const LaneModel::Link& link) const {
    return centres_ + 3 * kFloats * link.offset;
  }

  /// Centres in the world: of the bound, then of the balls.
  void PlaceBalls(const LaneModel::Link& link, float* at) {
    const Frame frame = FrameOf(link.hold);
    Keep(at, frame.place + Rotate(frame.turn, link.bound.centre));
    for (const LaneModel::FloatBall& ball : link.balls)
      Keep(at += 3 * kFloats, frame.place + Rotate(frame.turn, ball.centre));
  }

  void Add(Floats square, float reach) {
    const unsigned may_hit = Within(square, reach + model_.error);
    if (may_hit == 0) return;
    doubts_ |= may_hit;
    hits_ |= Within(square, reach - model_.error);
  }

  void AddObstacle(const LaneModel::Link& link, const float* at,
                   const LaneModel::FloatObstacle& obstacle) {
    const unsigned near =
        Within(SquareFrom(obstacle, VecAt(at)), link.bound.radius + obstacle.radius + model_.error);
    if ((near & ~hits_) == 0) return;
    for (const LaneModel::FloatBall& ball : link.balls)
      Add(SquareFrom(obstacle, VecAt(at += 3 * kFloats)), ball.radius + obstacle.radius);
  }

  void AddLink(const LaneModel::Link& link, const float* at, const LaneModel::Link& other) {
    const float* at_other = CentresOf(other);
    const unsigned near = Within(Square(VecAt(at) - VecAt(at_other)),
                                 link.bound.radius + other.bound.radius + model_.error);
    if ((near & ~hits_) == 0) return;
    for (const LaneModel::FloatBall& ball : link.balls) {
      const Vec centre = VecAt(at += 3 * kFloats);
      const float* at_ball = at_other;
      for (const LaneModel::FloatBall& second : other.balls)
        Add(Square(centre - VecAt(at_ball += 3 * kFloats)), ball.radius + second.radius);
    }
  }

  const LaneModel& model_;
  float *const frames_, *const centres_;
  unsigned hits_ = 0, doubts_ = 0;
};

LaneKernel::Answer CheckLanes(const LaneModel& model, const double* positions, float* room) {
  return Lanes(model, room).Check(positions);
}

}  // namespace
}  // namespace cdb::robots
