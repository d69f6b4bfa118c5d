#include "runtime/figures/history/change_points.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "runtime/figures/bootstrap.h"

namespace cdb::history {
namespace {

using Values = std::span<const double>;

/// The longest segment that is compared with all others.
constexpr std::size_t kLongestWindow = 30;
/// The most knots between which ramps are tried.
constexpr std::size_t kMostKnots = 40;
/// The shares of the significance for splits, for short segments and for slopes.
constexpr double kOfSplits = 0.5, kOfWindows = 0.25, kOfSlopes = 0.25;
/// By how much Schwarz's criterion must prefer a ramp: positive evidence by Kass and Raftery 1995,
/// Bayes Factors, Journal of the American Statistical Association 90.
constexpr double kLeastGain = 2;
/// What a step must keep between its neighbours, once all are found.
constexpr double kKept = 0.01;

double MeanOf(Values values) {
  double sum = 0;
  for (const double value : values) sum += value;
  return sum / static_cast<double>(values.size());
}

double SquaresAbout(Values values, double mean) {
  double sum = 0;
  for (const double value : values) sum += (value - mean) * (value - mean);
  return sum;
}

double TwoSided(double difference, double error, double freedom) {
  if (error <= 0) return difference == 0 ? 1 : 0;
  return 2 * figures::StudentTail(std::fabs(difference) / error, freedom);
}

/// The t test of two samples by their sizes, means and sums of squares about them.
SplitTest TestMoments(double n1, double mean1, double squares1, double n2, double mean2,
                      double squares2) {
  const double of1 = squares1 / (n1 - 1) / n1, of2 = squares2 / (n2 - 1) / n2;
  const double pooled = (squares1 + squares2) / (n1 + n2 - 2) * (1 / n1 + 1 / n2);
  SplitTest test = {mean2 - mean1, 1, std::sqrt(of1 + of2), n1 + n2 - 2};
  if (test.error > 0)
    test.freedom = (of1 + of2) * (of1 + of2) / (of1 * of1 / (n1 - 1) + of2 * of2 / (n2 - 1));
  test.p = TwoSided(test.difference, std::fmax(test.error, std::sqrt(pooled)), n1 + n2 - 2);
  return test;
}

/// Sums over ranges of values.
class Sums {
 public:
  explicit Sums(Values values) : sums_{0}, squares_{0} {
    for (const double value : values) {
      sums_.push_back(sums_.back() + value);
      squares_.push_back(squares_.back() + value * value);
    }
  }
  double Of(std::size_t from, std::size_t to) const { return sums_[to] - sums_[from]; }
  double SquaresOf(std::size_t from, std::size_t to) const { return squares_[to] - squares_[from]; }

 private:
  std::vector<double> sums_, squares_;
};

struct Window {
  std::size_t from = 0, to = 0;
};

/// The short segment that differs most from the rest, by the t of the pooled variance; and its
/// test, corrected for the number of segments. Nullopt if there is none.
std::optional<std::pair<Window, double>> MostUnlikeWindow(Values values) {
  const std::size_t n = values.size();
  if (n < 3 * kLeastSegment) return std::nullopt;
  // About the mean, so that the sums of squares lose no digits.
  std::vector<double> centred(values.begin(), values.end());
  const double mean = MeanOf(values);
  for (double& value : centred) value -= mean;
  const Sums sums(centred);
  const double all = sums.SquaresOf(0, n);
  Window best;
  double largest = -1;
  std::size_t tried = 0;
  for (std::size_t from = kLeastSegment; from + 2 * kLeastSegment <= n; ++from)
    for (std::size_t to = from + kLeastSegment;
         to + kLeastSegment <= n && to - from <= kLongestWindow; ++to) {
      ++tried;
      const double inside = static_cast<double>(to - from),
                   outside = static_cast<double>(n) - inside;
      const double sum = sums.Of(from, to);
      const double between = sum * sum * (1 / inside + 1 / outside);
      const double t = between / std::fmax(all - between, 1e-300);
      if (t > largest) {
        largest = t;
        best = {from, to};
      }
    }
  std::vector<double> rest(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(best.from));
  rest.insert(rest.end(), values.begin() + static_cast<std::ptrdiff_t>(best.to), values.end());
  const SplitTest test = TestSplit(rest, values.subspan(best.from, best.to - best.from));
  return std::pair(best, test.p * static_cast<double>(tried));
}

/// A ramp between two levels: the first up to the index `from`, the second from `to` on.
struct RampFit {
  std::size_t from, to;
  double rise, error;  ///< standard error
  double loss;
};

RampFit FitRamp(Values values, std::size_t from, std::size_t to) {
  const auto n = static_cast<double>(values.size());
  const auto place = [&](std::size_t i) {
    return std::clamp(
        (static_cast<double>(i) - static_cast<double>(from)) / static_cast<double>(to - from), 0.0,
        1.0);
  };
  double mean_place = 0;
  const double mean = MeanOf(values);
  for (std::size_t i = 0; i < values.size(); ++i) mean_place += place(i) / n;
  double of_place = 0, products = 0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    of_place += (place(i) - mean_place) * (place(i) - mean_place);
    products += (place(i) - mean_place) * (values[i] - mean);
  }
  RampFit fit = {from, to, products / of_place, 0, 0};
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double residual = values[i] - mean - fit.rise * (place(i) - mean_place);
    fit.loss += residual * residual;
  }
  fit.error = std::sqrt(fit.loss / (n - 4) / of_place);
  return fit;
}

/// Schwarz's criterion; less is better.
double Criterion(double loss, std::size_t n, std::size_t parameters) {
  const auto count = static_cast<double>(n);
  // Values that a model explains to the last digit have no logarithm.
  return count * std::log(loss / count + 1e-14) + static_cast<double>(parameters) * std::log(count);
}

/// A ramp by Schwarz's criterion. A knot at an end of the values is no parameter.
double CriterionOf(const RampFit& fit, std::size_t n) {
  return Criterion(fit.loss, n, 2 + (fit.from > 0 ? 1 : 0) + (fit.to + 1 < n ? 1 : 0));
}

/// The best ramp, with knots at some of the indices.
RampFit BestRamp(Values values) {
  const std::size_t n = values.size(), last = n - 1;
  const std::size_t stride = std::max<std::size_t>(1, (last + kMostKnots - 1) / kMostKnots);
  RampFit best = FitRamp(values, 0, last);
  const auto attempt = [&](std::size_t from, std::size_t to) {
    const RampFit fit = FitRamp(values, from, to);
    if (CriterionOf(fit, n) < CriterionOf(best, n)) best = fit;
  };
  for (std::size_t from = 0; from < last; from += stride) {
    for (std::size_t to = from + kLeastDrift; to < last; to += stride) attempt(from, to);
    if (from + kLeastDrift <= last) attempt(from, last);
  }
  return best;
}

/// The least loss of two levels, also if one has a single value.
double BestSplitLoss(Values values) {
  double best = SquaresAbout(values, MeanOf(values));
  for (std::size_t at = 1; at < values.size(); ++at) {
    const Values before = values.first(at), after = values.subspan(at);
    best =
        std::fmin(best, SquaresAbout(before, MeanOf(before)) + SquaresAbout(after, MeanOf(after)));
  }
  return best;
}

class Search {
 public:
  Search(Values values, const SearchLimits& limits)
      : values_(values),
        limits_(limits),
        accepted_(limits.significance /
                  static_cast<double>(std::max<std::size_t>(1, limits.series))) {}

  std::vector<Change> Find() {
    Split(0, values_.size());
    std::ranges::sort(splits_);
    Place();
    Prune();
    for (std::size_t i = 0; i < splits_.size(); ++i) changes_.push_back(StepAt(i));
    JoinIntoDrifts();
    AddSlopes();
    std::ranges::sort(changes_, {}, &Change::to);
    MeasureBesideDrifts();
    return std::move(changes_);
  }

 private:
  Values Part(std::size_t from, std::size_t to) const { return values_.subspan(from, to - from); }

  /// Adds the splits of the part to `splits_`.
  void Split(std::size_t from, std::size_t to) {
    const std::size_t n = to - from;
    const std::size_t at = EnergySplit(Part(from, to));
    if (at == 0) return;
    const double p = TestSplit(Part(from, from + at), Part(from + at, to)).p;
    if (p * static_cast<double>(n - 2 * kLeastSegment + 1) <= kOfSplits * accepted_) {
      splits_.push_back(from + at);
      Split(from, from + at);
      Split(from + at, to);
      return;
    }
    const auto window = MostUnlikeWindow(Part(from, to));
    if (!window || window->second > kOfWindows * accepted_) return;
    for (const std::size_t edge : {window->first.from, window->first.to})
      splits_.push_back(from + edge);
    Split(from, from + window->first.from);
    Split(from + window->first.from, from + window->first.to);
    Split(from + window->first.to, to);
  }

  std::size_t Before(std::size_t i) const { return i == 0 ? 0 : splits_[i - 1]; }
  std::size_t After(std::size_t i) const {
    return i + 1 == splits_.size() ? values_.size() : splits_[i + 1];
  }

  /// Moves each split to the best place between its neighbours, because it was chosen while they
  /// were unknown.
  void Place() {
    for (std::size_t i = 0; i < splits_.size(); ++i)
      if (const std::size_t at = EnergySplit(Part(Before(i), After(i))); at != 0)
        splits_[i] = Before(i) + at;
  }

  SplitTest TestAt(std::size_t i) const {
    return TestSplit(Part(Before(i), splits_[i]), Part(splits_[i], After(i)));
  }

  /// Removes the weakest split as long as one is not significant, or too small.
  void Prune() {
    while (!splits_.empty()) {
      std::size_t worst = 0;
      double largest = -1;
      for (std::size_t i = 0; i < splits_.size(); ++i) {
        const SplitTest test = TestAt(i);
        const bool is_small = std::fabs(test.difference) < std::log1p(limits_.least_effect);
        if (const double badness = is_small ? 1 + test.p : test.p; badness > largest) {
          largest = badness;
          worst = i;
        }
      }
      if (largest <= kKept) return;
      splits_.erase(splits_.begin() + static_cast<std::ptrdiff_t>(worst));
    }
  }

  static double ReachOf(const SplitTest& test) {
    return test.error > 0 ? figures::StudentExceeded(0.025, test.freedom) * test.error : 0;
  }

  Change StepAt(std::size_t i) const {
    const SplitTest test = TestAt(i);
    const double reach = ReachOf(test);
    const auto positions = static_cast<double>(After(i) - Before(i) + 1 - 2 * kLeastSegment);
    return {false,
            splits_[i] - 1,
            splits_[i],
            test.difference,
            test.difference - reach,
            test.difference + reach,
            Adjusted(test.p * positions, kOfSplits)};
  }

  /// The sizes of steps whose level before or after had values of what turned out to be a drift.
  void MeasureBesideDrifts() {
    for (std::size_t i = 0; i < changes_.size(); ++i) {
      Change& step = changes_[i];
      const bool is_after = i > 0 && changes_[i - 1].is_drift,
                 is_before = i + 1 < changes_.size() && changes_[i + 1].is_drift;
      if (step.is_drift || (!is_after && !is_before)) continue;
      const std::size_t from = i == 0 ? 0 : changes_[i - 1].to,
                        to = i + 1 == changes_.size() ? values_.size() : EndBefore(i + 1);
      if (step.to < from + kLeastSegment || to < step.to + kLeastSegment) continue;
      const SplitTest test = TestSplit(Part(from, step.to), Part(step.to, to));
      // A step that is not one without the drift stays as it was found.
      if (test.difference * step.log_ratio <= 0 ||
          std::abs(test.difference) < std::log1p(limits_.least_effect))
        continue;
      step.log_ratio = test.difference;
      step.low = test.difference - ReachOf(test);
      step.high = test.difference + ReachOf(test);
    }
  }

  double Adjusted(double p, double share) const {
    return std::fmin(1, p * static_cast<double>(std::max<std::size_t>(1, limits_.series)) / share);
  }

  Change DriftOf(const RampFit& fit, std::size_t offset, std::size_t n) const {
    const double freedom = static_cast<double>(n) - 4;
    const double reach = figures::StudentExceeded(0.025, freedom) * fit.error;
    return {true,
            offset + fit.from,
            offset + fit.to,
            fit.rise,
            fit.rise - reach,
            fit.rise + reach,
            Adjusted(TwoSided(fit.rise, fit.error, freedom), kOfSlopes)};
  }

  /// Replaces the steps of one direction that a ramp explains better, those that gain most first.
  void JoinIntoDrifts() {
    for (;;) {
      double most = kLeastGain;
      std::size_t best_first = 0, best_last = 0;
      std::optional<Change> best;
      for (std::size_t first = 0; first < changes_.size(); ++first)
        for (std::size_t last = first; last < changes_.size() && IsAlike(first, last); ++last) {
          const std::size_t from = first == 0 ? 0 : changes_[first - 1].to,
                            to = last + 1 == changes_.size() ? values_.size() : EndBefore(last + 1);
          if (to < from + kLeastDrift + 1) continue;
          const RampFit ramp = BestRamp(Part(from, to));
          const double gain =
              Criterion(StepsLoss(first, last, from, to), to - from, 2 * (last - first + 1) + 1) -
              CriterionOf(ramp, to - from);
          if (gain <= most || ramp.rise * changes_[first].log_ratio <= 0) continue;
          most = gain;
          best_first = first;
          best_last = last;
          best = DriftOf(ramp, from, to - from);
        }
      if (!best) return;
      changes_.erase(changes_.begin() + static_cast<std::ptrdiff_t>(best_first),
                     changes_.begin() + static_cast<std::ptrdiff_t>(best_last) + 1);
      changes_.insert(changes_.begin() + static_cast<std::ptrdiff_t>(best_first), *best);
    }
  }

  /// The end of the values that do not belong to a change or to what follows it.
  std::size_t EndBefore(std::size_t change) const {
    return changes_[change].is_drift ? changes_[change].from + 1 : changes_[change].to;
  }

  bool IsAlike(std::size_t first, std::size_t last) const {
    return !changes_[last].is_drift && changes_[first].log_ratio * changes_[last].log_ratio > 0;
  }

  double StepsLoss(std::size_t first, std::size_t last, std::size_t from, std::size_t to) const {
    double loss = 0;
    std::size_t start = from;
    for (std::size_t i = first; i <= last + 1; ++i) {
      const std::size_t end = i > last ? to : changes_[i].to;
      loss += SquaresAbout(Part(start, end), MeanOf(Part(start, end)));
      start = end;
    }
    return loss;
  }

  /// Adds the drifts of parts without a change.
  void AddSlopes() {
    std::vector<Change> drifts;
    std::size_t from = 0;
    for (std::size_t i = 0; i <= changes_.size(); ++i) {
      const std::size_t to = i == changes_.size() ? values_.size() : EndBefore(i);
      if (to > from)
        if (const auto drift = SlopeOf(from, to)) drifts.push_back(*drift);
      if (i < changes_.size()) from = changes_[i].to;
    }
    changes_.insert(changes_.end(), drifts.begin(), drifts.end());
  }

  std::optional<Change> SlopeOf(std::size_t from, std::size_t to) const {
    const std::size_t n = to - from;
    if (n <= kLeastDrift) return std::nullopt;
    const Values part = Part(from, to);
    const LineFit line = FitLine(part);
    const double freedom = static_cast<double>(n) - 2, length = static_cast<double>(n - 1);
    const double p = TwoSided(line.slope, line.error, freedom);
    if (p > kOfSlopes * accepted_ ||
        std::fabs(line.slope * length) < std::log1p(limits_.least_effect) ||
        Criterion(BestSplitLoss(part), n, 3) <= Criterion(line.loss, n, 2))
      return std::nullopt;
    const RampFit ramp = BestRamp(part);
    if (ramp.rise * line.slope <= 0) return std::nullopt;
    return DriftOf(ramp, from, n);
  }

  const Values values_;
  const SearchLimits limits_;
  const double accepted_;
  std::vector<std::size_t> splits_;  ///< the first index after each
  std::vector<Change> changes_;
};

}  // namespace

std::vector<Change> FindChanges(Values logs, const SearchLimits& limits) {
  const std::vector<double> values = WithoutOutliers(logs);
  return Search(values, limits).Find();
}

std::vector<double> WithoutOutliers(Values values) {
  constexpr double kMostDeviations = 3, kOfNormal = 1.4826;
  const std::size_t n = values.size();
  if (n < kLeastForOutliers) return {values.begin(), values.end()};
  std::vector<double> medians, distances;
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t from = i < 2 ? 0 : i - 2, to = std::min(n, i + 3);
    medians.push_back(figures::Median({values.begin() + static_cast<std::ptrdiff_t>(from),
                                       values.begin() + static_cast<std::ptrdiff_t>(to)}));
    distances.push_back(std::fabs(values[i] - medians.back()));
  }
  const double reach = kMostDeviations * kOfNormal * figures::Median(distances);
  std::vector<double> limited;
  for (std::size_t i = 0; i < n; ++i)
    limited.push_back(std::clamp(values[i], medians[i] - reach, medians[i] + reach));
  return limited;
}

SplitTest TestSplit(Values before, Values after) {
  const double mean1 = MeanOf(before), mean2 = MeanOf(after);
  return TestMoments(static_cast<double>(before.size()), mean1, SquaresAbout(before, mean1),
                     static_cast<double>(after.size()), mean2, SquaresAbout(after, mean2));
}

std::size_t EnergySplit(Values values) {
  const std::size_t n = values.size();
  if (n < 2 * kLeastSegment) return 0;
  double left = 0, right = 0, across = 0;  // sums of the distances of pairs
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j) right += std::fabs(values[i] - values[j]);
  std::size_t best = kLeastSegment;
  double largest = -std::numeric_limits<double>::infinity();
  for (std::size_t at = 1; at + kLeastSegment <= n; ++at) {
    double to_left = 0, to_right = 0;  // of the value that moves to the left
    for (std::size_t i = 0; i < n; ++i)
      (i < at ? to_left : to_right) += std::fabs(values[i] - values[at - 1]);
    left += to_left;
    right -= to_right;
    across += to_right - to_left;
    if (at < kLeastSegment) continue;
    const auto a = static_cast<double>(at), b = static_cast<double>(n - at);
    const double energy =
        a * b / (a + b) *
        (2 * across / (a * b) - left / (a * (a - 1) / 2) - right / (b * (b - 1) / 2));
    if (energy > largest) {
      largest = energy;
      best = at;
    }
  }
  return best;
}

LineFit FitLine(Values values) {
  const auto n = static_cast<double>(values.size());
  const double middle = (n - 1) / 2, mean = MeanOf(values);
  double products = 0;
  for (std::size_t i = 0; i < values.size(); ++i)
    products += (static_cast<double>(i) - middle) * (values[i] - mean);
  const double of_places = n * (n * n - 1) / 12;
  LineFit fit = {products / of_places, 0, 0, 0};
  fit.level = mean - fit.slope * middle;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double residual = values[i] - fit.level - fit.slope * static_cast<double>(i);
    fit.loss += residual * residual;
  }
  fit.error = std::sqrt(fit.loss / (n - 2) / of_places);
  return fit;
}

}  // namespace cdb::history
