#include "runtime/figures/effects/effects.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>

namespace cdb::effects {
namespace {

/// In the range of a parameter, from -1 to 1.
double PlaceOf(const plan::Coordinates& parameter, std::size_t point) {
  const auto scaled = [&](double value) { return parameter.is_log ? std::log(value) : value; };
  const double first = scaled(parameter.first), last = scaled(parameter.last);
  return first == last ? 0 : 2 * (scaled(parameter.values[point]) - first) / (last - first) - 1;
}

/// The terms of the fit: a constant, then those of each degree and product.
struct Terms {
  std::size_t parameters;
  bool has_squares = true, has_products = true;

  std::size_t count() const {
    return 1 + parameters * (has_squares ? 2 : 1) +
           (has_products ? parameters * (parameters - 1) / 2 : 0);
  }
  std::size_t Linear(std::size_t i) const { return 1 + i; }
  std::size_t Square(std::size_t i) const { return 1 + parameters + i; }
  /// The first of those of products, in the order of pairs i < j.
  std::size_t Products() const { return 1 + 2 * parameters; }
};

Eigen::RowVectorXd RowOf(const Terms& terms, std::span<const plan::Coordinates> parameters,
                         std::size_t point) {
  Eigen::RowVectorXd row(static_cast<Eigen::Index>(terms.count()));
  Eigen::Index at = 0;
  row[at++] = 1;
  std::vector<double> linear;
  for (const plan::Coordinates& parameter : parameters) {
    linear.push_back(std::sqrt(3) * PlaceOf(parameter, point));
    row[at++] = linear.back();
  }
  if (terms.has_squares)
    for (const double x : linear) row[at++] = std::sqrt(5) / 2 * (x * x - 1);
  if (terms.has_products)
    for (std::size_t i = 0; i < linear.size(); ++i)
      for (std::size_t j = i + 1; j < linear.size(); ++j) row[at++] = linear[i] * linear[j];
  return row;
}

}  // namespace

std::optional<SampledEffects> FitEffects(std::span<const plan::Coordinates> parameters,
                                         std::span<const double> figures) {
  std::vector<std::size_t> points;
  for (std::size_t i = 0; i < figures.size(); ++i)
    if (figures[i] > 0 && std::isfinite(figures[i])) points.push_back(i);
  Terms terms{parameters.size()};
  if (points.size() < 2 * terms.count()) terms.has_products = false;
  if (points.size() < 2 * terms.count()) terms.has_squares = false;
  if (points.size() < 2 * terms.count()) return std::nullopt;
  const auto rows = static_cast<Eigen::Index>(points.size()),
             columns = static_cast<Eigen::Index>(terms.count());
  Eigen::MatrixXd design(rows, columns);
  Eigen::VectorXd logs(rows);
  for (Eigen::Index i = 0; i < rows; ++i) {
    const std::size_t point = points[static_cast<std::size_t>(i)];
    design.row(i) = RowOf(terms, parameters, point);
    logs[i] = std::log(figures[point]);
  }
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> solver(design);
  if (solver.rank() < columns) return std::nullopt;
  const Eigen::VectorXd fit = solver.solve(logs);
  const double freedom = static_cast<double>(rows - columns);
  const double residual = (logs - design * fit).squaredNorm() / freedom;
  const Eigen::MatrixXd covariance = (design.transpose() * design).inverse() * residual;
  const double variance = fit.tail(columns - 1).squaredNorm() + residual;
  // Rounding errors are no effects.
  if (!(variance > 1e-24)) return std::nullopt;
  const auto square = [&](std::size_t term) {
    const double value = fit[static_cast<Eigen::Index>(term)];
    return value * value / variance;
  };
  SampledEffects effects;
  effects.points = points.size();
  effects.freedom = freedom;
  effects.has_interactions = terms.has_products;
  effects.unexplained = residual / variance;
  for (std::size_t i = 0; i < parameters.size(); ++i) {
    const auto term = static_cast<Eigen::Index>(terms.Linear(i));
    // From one end to the other; squares are the same at both.
    const double between = 2 * std::sqrt(3);
    const double share =
        square(terms.Linear(i)) + (terms.has_squares ? square(terms.Square(i)) : 0);
    effects.mains.push_back(
        {i, between * fit[term], between * std::sqrt(covariance(term, term)), share});
  }
  std::size_t term = terms.Products();
  for (std::size_t i = 0; terms.has_products && i < parameters.size(); ++i)
    for (std::size_t j = i + 1; j < parameters.size(); ++j)
      effects.interactions.push_back({i, j, square(term++)});
  std::ranges::stable_sort(effects.mains, std::greater(), &MainEffect::share);
  std::ranges::stable_sort(effects.interactions, std::greater(), &Interaction::share);
  return effects;
}

}  // namespace cdb::effects
