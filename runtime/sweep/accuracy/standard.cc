#include "runtime/sweep/accuracy/standard.h"

#include <algorithm>

namespace cdb::accuracy {
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
