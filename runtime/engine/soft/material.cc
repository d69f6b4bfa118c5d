#include "runtime/engine/soft/material.h"

#include <BulletSoftBody/btDeformableCorotatedForce.h>
#include <BulletSoftBody/btDeformableLinearElasticityForce.h>
#include <BulletSoftBody/btDeformableNeoHookeanForce.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <cmath>
#include <limits>

namespace cdb::soft {
namespace {

using Eigen::Matrix3d;

/// Bullet's law has the constants mu and lambda of small deformations with these parameters.
analysis::LameConstants NeoHookeanParameters(const analysis::LameConstants& small) {
  return {4.0 / 3 * small.mu, small.lambda + 5.0 / 6 * small.mu};
}

/// Its columns are the cross products of those of `m`: the derivative of the determinant.
Matrix3d Cofactors(const Matrix3d& m) {
  Matrix3d cofactors;
  for (int i = 0; i < 3; ++i) cofactors.col(i) = m.col((i + 1) % 3).cross(m.col((i + 2) % 3));
  return cofactors;
}

/// Bullet's corotated law takes no rotation from a tetrahedron that is flat or inside out.
constexpr double kLeastGrowth = 1024 * std::numeric_limits<btScalar>::epsilon();

/// The rotation of the polar decomposition.
Matrix3d RotationOf(const Matrix3d& gradient) {
  const Eigen::JacobiSVD<Matrix3d> svd(gradient, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Matrix3d u = svd.matrixU();
  if ((u * svd.matrixV().transpose()).determinant() < 0) u.col(2) *= -1;
  return u * svd.matrixV().transpose();
}

Strained NeoHookean(const Material& material, const Matrix3d& gradient) {
  const auto [mu, lambda] = NeoHookeanParameters(material.lame);
  const double square = gradient.squaredNorm(), growth = gradient.determinant() - 1;
  return {
      mu / 2 * (square - 3 - std::log((square + 1) / 4)) + lambda / 2 * growth * growth -
          0.75 * mu * growth,
      mu * (1 - 1 / (square + 1)) * gradient + (lambda * growth - 0.75 * mu) * Cofactors(gradient)};
}

Strained Corotated(const Material& material, const Matrix3d& gradient) {
  const auto [mu, lambda] = material.lame;
  const double growth = gradient.determinant() - 1;
  const Matrix3d off = growth + 1 < kLeastGrowth ? Matrix3d(gradient - Matrix3d::Identity())
                                                 : Matrix3d(gradient - RotationOf(gradient));
  return {mu * off.squaredNorm() + lambda / 2 * growth * growth,
          2 * mu * off + lambda * growth * Cofactors(gradient)};
}

Strained Linear(const Material& material, const Matrix3d& gradient) {
  const auto [mu, lambda] = material.lame;
  const Matrix3d rotation = RotationOf(gradient), own = rotation.transpose() * gradient;
  const Matrix3d strain = (own + own.transpose()) / 2 - Matrix3d::Identity();
  const double trace = strain.trace();
  return {mu * strain.squaredNorm() + lambda / 2 * trace * trace,
          rotation * (2 * mu * strain + lambda * trace * Matrix3d::Identity())};
}

}  // namespace

Material MaterialOf(const plan::Group& group) {
  const plan::GroupSettings& settings = group.settings;
  const std::string_view word = settings.WordOr("soft.material");
  return {word == "linear"      ? Law::kLinear
          : word == "corotated" ? Law::kCorotated
                                : Law::kNeoHookean,
          analysis::LameConstantsOf(settings.Real("soft.young_modulus"),
                                    settings.Real("soft.poisson_ratio")),
          settings.Real("soft.stiffness_damping")};
}

std::unique_ptr<btDeformableLagrangianForce> MakeForce(const Material& material) {
  const auto mu = static_cast<btScalar>(material.lame.mu),
             lambda = static_cast<btScalar>(material.lame.lambda),
             damping = static_cast<btScalar>(material.damping);
  switch (material.law) {
    case Law::kLinear:
      return std::make_unique<btDeformableLinearElasticityForce>(mu, lambda, btScalar(0), damping);
    case Law::kCorotated:
      return std::make_unique<btDeformableCorotatedForce>(mu, lambda);
    case Law::kNeoHookean:
      break;
  }
  const analysis::LameConstants parameters = NeoHookeanParameters(material.lame);
  auto force = std::make_unique<btDeformableNeoHookeanForce>(
      static_cast<btScalar>(parameters.mu), static_cast<btScalar>(parameters.lambda));
  force->m_mu_damp = damping * mu;
  force->m_lambda_damp = damping * lambda;
  return force;
}

Strained StrainedBy(const Material& material, const Matrix3d& gradient) {
  switch (material.law) {
    case Law::kLinear:
      return Linear(material, gradient);
    case Law::kCorotated:
      return Corotated(material, gradient);
    case Law::kNeoHookean:
      break;
  }
  return NeoHookean(material, gradient);
}

}  // namespace cdb::soft
