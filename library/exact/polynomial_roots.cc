#include "library/exact/polynomial_roots.h"

#include <algorithm>
#include <array>
#include <cstddef>
#include <utility>

namespace cdb::exact {
namespace {

Dyadic Middle(const Dyadic& a, const Dyadic& b) { return (a + b) * Dyadic(0.5); }

struct Division {
  Polynomial quotient, remainder;
};

/// Divides a positive multiple of `a` by `b`, which is not 0, so that no coefficient is a fraction.
Division Divide(const Polynomial& a, const Polynomial& b) {
  Division division = {{}, a};
  const Dyadic& lead = b[static_cast<std::size_t>(b.Degree())];
  const Polynomial scale({lead.Sign() < 0 ? -lead : lead});
  while (division.remainder.Degree() >= b.Degree()) {
    const Dyadic& first = division.remainder[static_cast<std::size_t>(division.remainder.Degree())];
    std::vector<Dyadic> term(static_cast<std::size_t>(division.remainder.Degree() - b.Degree()) +
                             1);
    term.back() = lead.Sign() < 0 ? -first : first;
    const Polynomial step(std::move(term));
    division.quotient = division.quotient * scale + step;
    division.remainder = division.remainder * scale - step * b;
  }
  return division;
}

Polynomial Negative(const Polynomial& polynomial) { return Polynomial() - polynomial; }

/// Up to a factor. Neither is 0.
Polynomial CommonDivisor(Polynomial a, Polynomial b) {
  while (!b.IsZero()) {
    Polynomial rest = Divide(a, b).remainder;
    a = std::move(b);
    b = std::move(rest);
  }
  return a;
}

/// Sturm's chain of a polynomial without multiple roots.
class Chain {
 public:
  explicit Chain(const Polynomial& polynomial) {
    members_ = {polynomial, polynomial.Derivative()};
    while (!members_.back().IsZero())
      members_.push_back(
          Negative(Divide(members_[members_.size() - 2], members_.back()).remainder));
    members_.pop_back();
  }

  /// The number of roots above `lower` and up to `upper`.
  int Count(const Dyadic& lower, const Dyadic& upper) const {
    return Changes(lower) - Changes(upper);
  }

 private:
  int Changes(const Dyadic& time) const {
    int changes = 0, last = 0;
    for (const Polynomial& member : members_) {
      const int sign = member.At(time).Sign();
      if (sign == 0) continue;
      if (sign == -last) ++changes;
      last = sign;
    }
    return changes;
  }

  std::vector<Polynomial> members_;
};

/// The sign of a polynomial in the whole interval; 0 if its Bernstein coefficients do not agree.
int SignBetween(const Polynomial& polynomial, const Dyadic& lower, const Dyadic& upper) {
  // Powers of the part of the interval, by Horner's scheme.
  const Polynomial part = Polynomial::Linear(lower, upper);
  Polynomial moved;
  for (int power = polynomial.Degree(); power >= 0; --power)
    moved = moved * part + Polynomial({polynomial[static_cast<std::size_t>(power)]});
  // Rows: degrees. Coefficient j is the sum of C(j, i) / C(degree, i) times that of power i, here
  // times the least number that leaves no fraction.
  constexpr int kBinomials[4][4] = {{1, 0, 0, 0}, {1, 1, 0, 0}, {1, 2, 1, 0}, {1, 3, 3, 1}};
  constexpr int kWhole[4] = {1, 1, 2, 3};
  const auto degree = static_cast<std::size_t>(polynomial.Degree());
  int sign = 0;
  for (std::size_t j = 0; j <= degree; ++j) {
    Dyadic sum;
    for (std::size_t i = 0; i <= j && static_cast<int>(i) <= moved.Degree(); ++i)
      sum = sum + moved[i] * Dyadic(static_cast<double>(kBinomials[j][i] * kWhole[degree] /
                                                        kBinomials[degree][i]));
    if (sum.Sign() == 0 || sum.Sign() == -sign) return 0;
    sign = sum.Sign();
  }
  return sign;
}

}  // namespace

Polynomial::Polynomial(std::vector<Dyadic> coefficients) : coefficients_(std::move(coefficients)) {
  while (!coefficients_.empty() && coefficients_.back().Sign() == 0) coefficients_.pop_back();
}

Polynomial Polynomial::Linear(const Dyadic& from, const Dyadic& to) {
  return Polynomial({from, to - from});
}

Dyadic Polynomial::At(const Dyadic& time) const {
  Dyadic value;
  for (auto coefficient = coefficients_.rbegin(); coefficient != coefficients_.rend();
       ++coefficient)
    value = value * time + *coefficient;
  return value;
}

Polynomial Polynomial::Derivative() const {
  std::vector<Dyadic> coefficients;
  for (std::size_t i = 1; i < coefficients_.size(); ++i)
    coefficients.push_back(coefficients_[i] * Dyadic(static_cast<double>(i)));
  return Polynomial(std::move(coefficients));
}

Polynomial operator+(const Polynomial& a, const Polynomial& b) {
  std::vector<Dyadic> sum(std::max(a.coefficients_.size(), b.coefficients_.size()));
  std::ranges::copy(a.coefficients_, sum.begin());
  for (std::size_t i = 0; i < b.coefficients_.size(); ++i) sum[i] = sum[i] + b.coefficients_[i];
  return Polynomial(std::move(sum));
}

Polynomial operator-(const Polynomial& a, const Polynomial& b) {
  std::vector<Dyadic> difference(std::max(a.coefficients_.size(), b.coefficients_.size()));
  std::ranges::copy(a.coefficients_, difference.begin());
  for (std::size_t i = 0; i < b.coefficients_.size(); ++i)
    difference[i] = difference[i] - b.coefficients_[i];
  return Polynomial(std::move(difference));
}

Polynomial operator*(const Polynomial& a, const Polynomial& b) {
  if (a.IsZero() || b.IsZero()) return {};
  std::vector<Dyadic> product(a.coefficients_.size() + b.coefficients_.size() - 1);
  for (std::size_t i = 0; i < a.coefficients_.size(); ++i)
    for (std::size_t j = 0; j < b.coefficients_.size(); ++j)
      product[i + j] = product[i + j] + a.coefficients_[i] * b.coefficients_[j];
  return Polynomial(std::move(product));
}

Time::Time(Polynomial root_of, Dyadic lower, Dyadic upper)
    : root_of_(std::move(root_of)),
      lower_(std::move(lower)),
      upper_(std::move(upper)),
      sign_at_lower_(root_of_.At(lower_).Sign()) {}

void Time::Halve() {
  Dyadic middle = Middle(lower_, upper_);
  const int sign = root_of_.At(middle).Sign();
  if (sign == 0) {
    lower_ = std::move(middle);
    root_of_ = {};
  } else if (sign == sign_at_lower_) {
    lower_ = std::move(middle);
  } else {
    upper_ = std::move(middle);
  }
}

int Time::SignOf(const Polynomial& polynomial) {
  if (polynomial.Degree() <= 0) return polynomial.IsZero() ? 0 : polynomial[0].Sign();
  if (!root_of_.IsZero()) {
    // A common root in the interval is this one.
    const Polynomial common = CommonDivisor(root_of_, polynomial);
    if (common.Degree() > 0 && common.At(lower_).Sign() != common.At(upper_).Sign()) return 0;
  }
  // Testing an interval takes as long as many halvings.
  for (int halvings = 1; !root_of_.IsZero(); halvings *= 2) {
    if (const int sign = SignBetween(polynomial, lower_, upper_); sign != 0) return sign;
    for (int i = 0; i < halvings && !root_of_.IsZero(); ++i) Halve();
  }
  return polynomial.At(lower_).Sign();
}

std::vector<Time> RootsOf(const Polynomial& polynomial) {
  std::vector<Time> roots;
  if (polynomial.Degree() <= 0) return roots;
  const Polynomial simple =
      Divide(polynomial, CommonDivisor(polynomial, polynomial.Derivative())).quotient;
  const Chain chain(simple);
  const auto isolate = [&](const auto& self, const Dyadic& lower, const Dyadic& upper) -> void {
    const int count = chain.Count(lower, upper);
    if (count == 0) return;
    if (count == 1 && simple.At(upper).Sign() == 0) {
      roots.push_back(Time({}, upper, upper));
    } else if (count == 1 && simple.At(lower).Sign() != 0) {
      roots.push_back(Time(simple, lower, upper));
    } else {
      const Dyadic middle = Middle(lower, upper);
      self(self, lower, middle);
      self(self, middle, upper);
    }
  };
  isolate(isolate, Dyadic(), Dyadic(1));
  return roots;
}

}  // namespace cdb::exact
