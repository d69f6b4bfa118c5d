// Polynomials in time with exact coefficients, their roots from 0 to 1, and the signs of other
// polynomials at these: all without rounding, also at roots that are no fractions. Threads: any.
#pragma once

#include <vector>

#include "library/exact/dyadic.h"

namespace cdb::exact {

/// Coefficients from the constant one on; the last is not 0. Empty: the polynomial is 0.
class Polynomial {
 public:
  Polynomial() = default;
  explicit Polynomial(std::vector<Dyadic> coefficients);
  /// `from` at 0, `to` at 1.
  static Polynomial Linear(const Dyadic& from, const Dyadic& to);

  bool IsZero() const { return coefficients_.empty(); }
  /// -1 if it is 0.
  int Degree() const { return static_cast<int>(coefficients_.size()) - 1; }
  const Dyadic& operator[](std::size_t power) const { return coefficients_[power]; }
  Dyadic At(const Dyadic& time) const;
  Polynomial Derivative() const;

  friend Polynomial operator+(const Polynomial& a, const Polynomial& b);
  friend Polynomial operator-(const Polynomial& a, const Polynomial& b);
  friend Polynomial operator*(const Polynomial& a, const Polynomial& b);

 private:
  std::vector<Dyadic> coefficients_;
};

/// A time from 0 to 1: a dyadic number, or the only root of a polynomial in an interval.
class Time {
 public:
  static Time Start() { return Time{{}, {}, {}}; }  ///< 0

  /// The sign of a polynomial, of degree 3 at most, at this time. Narrows the interval.
  int SignOf(const Polynomial& polynomial);

 private:
  friend std::vector<Time> RootsOf(const Polynomial& polynomial);
  Time(Polynomial root_of, Dyadic lower, Dyadic upper);
  void Halve();

  Polynomial root_of_;    ///< without multiple roots, and not 0 at the ends; 0: the time is lower_
  Dyadic lower_, upper_;  ///< the root is between them, and the signs at them differ
  int sign_at_lower_;     ///< of root_of_
};

/// The roots above 0 and up to 1 of a polynomial that is not 0, of degree 3 at most, each once, in
/// order. Source: Sturm's theorem.
std::vector<Time> RootsOf(const Polynomial& polynomial);

}  // namespace cdb::exact
