#include "runtime/sweep/accuracy/errors.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <string>

#include "compiler/analysis/reference.h"
#include "dsl/text/check.h"

namespace cdb::accuracy {
namespace {

using Eigen::Vector3d;
using schema::ErrorInfo;
using schema::ErrorKind;
using schema::Fold;

constexpr double kNone = std::numeric_limits<double>::quiet_NaN();

/// Root mean square of `of(object)` over the moving objects.
template <typename Of>
double RmsOverObjects(const protocol::Samples& samples, Of of) {
  double sum = 0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < samples.shape.objects; ++i) {
    if (samples.mass(i) == 0) continue;
    sum += of(i);
    ++count;
  }
  return count == 0 ? kNone : std::sqrt(sum / static_cast<double>(count));
}

double Over(double error, double scale) { return scale > 0 ? error / scale : kNone; }

/// One sample of a run, with the true values at its time.
class At {
 public:
  At(const protocol::Samples& run, const Standard* standard, std::size_t sample)
      : run_(run), standard_(standard), sample_(sample) {
    if (standard != nullptr) truth_ = standard->At(sample);
  }

  double Error(ErrorKind kind) const {
    switch (kind) {
      case ErrorKind::kPosition:
        return Position();
      case ErrorKind::kVelocity:
        return Velocity();
      case ErrorKind::kRotation:
        return Rotation();
      case ErrorKind::kEnergy:
        return Energy();
      case ErrorKind::kMomentum:
        return Momentum();
      case ErrorKind::kAngularMomentum:
        return AngularMomentum();
      case ErrorKind::kPenetration:
        return run_.observable(sample_, protocol::kDepthMean);
      case ErrorKind::kPenetrationMax:
        return run_.observable(sample_, protocol::kDepthMax);
      case ErrorKind::kHeight:
      case ErrorKind::kHeightW1:
        return Heights(kind);
      case ErrorKind::kContacts:
        return Contacts();
      case ErrorKind::kPairsMissed:
        return OfExactPairs(protocol::kPairsMissed);
      case ErrorKind::kPairsPhantom:
        return OfExactPairs(protocol::kPairsPhantom);
      case ErrorKind::kDepthError:
        return Over(run_.observable(sample_, protocol::kDepthErrorSum),
                    run_.observable(sample_, protocol::kOverlapsExact) -
                        run_.observable(sample_, protocol::kOverlapsMissed));
      case ErrorKind::kNormalError:
        return Over(run_.observable(sample_, protocol::kNormalErrorSum),
                    run_.observable(sample_, protocol::kNormalCount));
      case ErrorKind::kContactsMissed:
        return Over(run_.observable(sample_, protocol::kOverlapsMissed),
                    run_.observable(sample_, protocol::kOverlapsExact));
    }
    CDB_CHECK(false);
  }

 private:
  double Position() const {
    if (truth_.positions.empty()) return kNone;
    return RmsOverObjects(run_, [&](std::size_t i) {
      return ((run_.position(sample_, i) - truth_.positions[i]) / run_.size(i)).squaredNorm();
    });
  }

  double Velocity() const {
    if (truth_.velocities.empty()) return kNone;
    return RmsOverObjects(run_, [&](std::size_t i) {
      return (run_.velocity(sample_, i) - truth_.velocities[i]).squaredNorm();
    });
  }

  double Rotation() const {
    if (truth_.orientations.empty()) return kNone;
    return RmsOverObjects(run_, [&](std::size_t i) {
      const double angle = run_.orientation(sample_, i).angularDistance(truth_.orientations[i]);
      return angle * angle;
    });
  }

  double Energy() const {
    if (!truth_.energy) return kNone;
    return Over(std::fabs(run_.energy(sample_) - run_.energy(0) - *truth_.energy),
                standard_->energy_scale());
  }

  double Momentum() const {
    if (!truth_.momentum) return kNone;
    return Over((run_.momentum(sample_) - *truth_.momentum).norm(), standard_->momentum_scale());
  }

  double AngularMomentum() const {
    if (!truth_.angular_momentum) return kNone;
    return Over((run_.angular_momentum(sample_) - *truth_.angular_momentum).norm(),
                standard_->angular_momentum_scale());
  }

  double Contacts() const {
    const auto contacts =
        standard_ != nullptr ? standard_->Contacts(sample_) : std::optional<double>();
    if (!contacts) return kNone;
    return std::fabs(run_.observable(sample_, protocol::kContactCount) - *contacts) /
           std::max(1.0, *contacts);
  }

  double OfExactPairs(protocol::Observable which) const {
    return run_.observable(sample_, which) /
           std::max(1.0, run_.observable(sample_, protocol::kPairsExact));
  }

  double Heights(ErrorKind kind) const {
    if (truth_.positions.empty()) return kNone;
    std::vector<double> run, truth;
    double size = 0;
    const Vector3d up = run_.Up();
    for (std::size_t i = 0; i < run_.shape.objects; ++i) {
      if (run_.mass(i) == 0) continue;
      run.push_back(up.dot(run_.position(sample_, i)));
      truth.push_back(up.dot(truth_.positions[i]));
      size += run_.size(i);
    }
    const auto count = static_cast<double>(run.size());
    if (kind == ErrorKind::kHeightW1) return Over(MeanMove(run, truth), size / count);
    const auto sum = [](const std::vector<double>& values) {
      return std::accumulate(values.begin(), values.end(), 0.0);
    };
    return Over(std::fabs(sum(run) - sum(truth)), size);
  }

  const protocol::Samples& run_;
  const Standard* standard_;
  const std::size_t sample_;
  closed_forms::Truth truth_;
};

}  // namespace

std::size_t HorizonOf(const protocol::Samples& reference, const protocol::Samples& twin) {
  for (std::size_t s = 0; s < reference.shape.samples; ++s) {
    const double apart = RmsOverObjects(reference, [&](std::size_t i) {
      return ((twin.position(s, i) - reference.position(s, i)) / reference.size(i)).squaredNorm();
    });
    if (!(apart <= kHorizonDistance)) return s;
  }
  return reference.shape.samples;
}

std::vector<std::vector<double>> ErrorSeries(std::span<const ErrorInfo* const> errors,
                                             const protocol::Samples& run,
                                             const Standard* standard) {
  std::vector<std::vector<double>> series(errors.size());
  for (std::size_t s = 0; s < run.shape.samples; ++s) {
    const At at(run, standard, s);
    for (std::size_t e = 0; e < errors.size(); ++e) series[e].push_back(at.Error(errors[e]->kind));
  }
  return series;
}

double Folded(std::span<const double> series, Fold fold, std::size_t end) {
  end = std::min(end, series.size());
  if (end < 2) return kNone;
  const auto values = Eigen::Map<const Eigen::ArrayXd>(series.data(), static_cast<long>(end))
                          .tail(static_cast<long>(end) - 1);
  if (fold != Fold::kMeanOfSome && !values.isFinite().all()) return kNone;
  switch (fold) {
    case Fold::kRms:
      return std::sqrt(values.square().mean());
    case Fold::kMean:
      return values.mean();
    case Fold::kMax:
      return values.maxCoeff();
    case Fold::kMeanOfSome:
      return Over(values.isNaN().select(0.0, values).sum(),
                  static_cast<double>((!values.isNaN()).count()));
  }
  CDB_CHECK(false);
}

double MeanMove(std::vector<double> from, std::vector<double> to) {
  CDB_CHECK(from.size() == to.size());
  // NaN cannot be sorted.
  for (const auto* values : {&from, &to})
    for (const double value : *values)
      if (std::isnan(value)) return kNone;
  std::ranges::sort(from);
  std::ranges::sort(to);
  const auto as_array = [](const std::vector<double>& values) {
    return Eigen::Map<const Eigen::ArrayXd>(values.data(), static_cast<long>(values.size()));
  };
  return from.empty() ? kNone : (as_array(from) - as_array(to)).abs().mean();
}

protocol::RunErrors CollectErrors(const plan::Scene& scene, const protocol::Samples& run,
                                  const Standard* standard, const protocol::Samples* reference,
                                  const protocol::Samples* twin) {
  const auto errors = analysis::ErrorsOf(scene);
  protocol::RunErrors result;
  const bool is_sure = twin == nullptr;
  const std::size_t horizon = is_sure ? run.shape.samples : HorizonOf(*reference, *twin);
  const auto series = ErrorSeries(errors, run, standard);
  const auto floors =
      is_sure ? std::vector<std::vector<double>>() : ErrorSeries(errors, *twin, standard);
  std::string unknown;
  for (std::size_t e = 0; e < errors.size(); ++e) {
    const ErrorInfo& error = *errors[e];
    const std::string name(error.name);
    const std::size_t end = error.to_horizon ? horizon : run.shape.samples;
    result.values[name] = {Folded(series[e], error.fold, end)};
    result.values[name + "_series"] = series[e];
    if (std::isnan(result.values[name][0]))
      unknown += fmt::format("{}{}", unknown.empty() ? "" : ", ", name);
    if (error.needs_truth && standard != nullptr)
      result.values[name + "_floor"] = {is_sure ? 0 : Folded(floors[e], error.fold, end)};
  }
  result.values["timestep"] = {scene.world.Real("timestep")};
  if (standard != nullptr)
    result.values["horizon"] = {run.Time(std::min(horizon, run.shape.samples - 1))};
  if (!run.IsFinite()) {
    result.message = "a state of the run is not finite";
  } else if (!is_sure && horizon < 2) {
    result.message = fmt::format(
        "no position is known: the reference and its twin differ by a tenth of a size at "
        "the first sample already, at {} s; sample earlier (accuracy.interval), or choose metrics "
        "that need no single trajectory, such as energy and height",
        run.Time(1));
  } else if (!unknown.empty() && standard != nullptr) {
    result.message =
        fmt::format("the ground truth does not provide {}, or the scene has none", unknown);
  }
  return result;
}

namespace {

double Largest(const protocol::Samples& samples, protocol::Observable which) {
  double largest = 0;
  for (std::size_t s = 0; s < samples.shape.samples; ++s)
    largest = std::max(largest, samples.observable(s, which));
  return largest;
}

class SampledStandard : public Standard {
 public:
  explicit SampledStandard(const protocol::Samples& reference) : reference_(reference) {
    energy_scale_ = Largest(reference, protocol::kKinetic);
    const double acceleration = reference.acceleration(0).norm();
    for (std::size_t i = 0; i < reference.shape.objects; ++i)
      energy_scale_ += reference.mass(i) * acceleration * reference.size(i);
  }

  closed_forms::Truth At(std::size_t sample) const override {
    closed_forms::Truth truth;
    truth.positions.reserve(reference_.shape.objects);
    truth.velocities.reserve(reference_.shape.objects);
    truth.orientations.reserve(reference_.shape.objects);
    for (std::size_t i = 0; i < reference_.shape.objects; ++i) {
      truth.positions.emplace_back(reference_.position(sample, i));
      truth.velocities.emplace_back(reference_.velocity(sample, i));
      truth.orientations.emplace_back(reference_.orientation(sample, i));
    }
    truth.energy = reference_.energy(sample) - reference_.energy(0);
    truth.momentum = reference_.momentum(sample);
    truth.angular_momentum = reference_.angular_momentum(sample);
    return truth;
  }
  std::optional<double> Contacts(std::size_t sample) const override {
    return reference_.observable(sample, protocol::kContactCount);
  }
  double energy_scale() const override { return energy_scale_; }
  double momentum_scale() const override { return Largest(reference_, protocol::kMomentumSum); }
  double angular_momentum_scale() const override {
    return Largest(reference_, protocol::kAngularSum);
  }

 private:
  const protocol::Samples& reference_;
  double energy_scale_ = 0;
};

class FormStandard : public Standard {
 public:
  FormStandard(const closed_forms::ClosedForm& form, const protocol::Samples& run)
      : form_(form), run_(run) {}

  closed_forms::Truth At(std::size_t sample) const override { return form_.At(run_.Time(sample)); }
  std::optional<double> Contacts(std::size_t) const override { return std::nullopt; }
  double energy_scale() const override { return form_.energy_scale(); }
  double momentum_scale() const override { return Largest(run_, protocol::kMomentumSum); }
  double angular_momentum_scale() const override { return Largest(run_, protocol::kAngularSum); }

 private:
  const closed_forms::ClosedForm& form_;
  const protocol::Samples& run_;
};

}  // namespace

std::unique_ptr<Standard> StandardOf(const protocol::Samples& reference) {
  return std::make_unique<SampledStandard>(reference);
}

std::unique_ptr<Standard> StandardOf(const closed_forms::ClosedForm& form,
                                     const protocol::Samples& run) {
  return std::make_unique<FormStandard>(form, run);
}

}  // namespace cdb::accuracy
