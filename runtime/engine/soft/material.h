// The materials of blocks: Bullet's forces, and the energy that belongs to each of them.
#pragma once

// The header defines a global variable `seed`, which parameters of that name would hide.
#define seed bt_soft_body_seed
#include <BulletSoftBody/btDeformableLagrangianForce.h>
#undef seed

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>

#include "compiler/analysis/soft.h"
#include "compiler/plan/plan.h"

namespace cdb::soft {

enum class Law {
  kLinear,     ///< Hooke's law in the frame of the rotation of each tetrahedron
  kCorotated,  ///< fixed corotated: Stomakhin et al., Energetically consistent invertible
               ///< elasticity, 2012
  kNeoHookean  ///< stable neo-Hookean: Smith et al., Stable neo-Hookean flesh simulation, 2018
};

struct Material {
  Law law = Law::kNeoHookean;
  analysis::LameConstants lame;  ///< of small deformations
  double damping = 0;            ///< s: viscosities over these constants
};
/// `group`: of blocks.
Material MaterialOf(const plan::Group& group);

/// Bullet's, without bodies. Bullet computes stresses from the positions before a step, and applies
/// damping by the velocities after it.
std::unique_ptr<btDeformableLagrangianForce> MakeForce(const Material& material);

/// A tetrahedron at the start.
struct Element {
  double volume = 0;        ///< m^3
  Eigen::Matrix3d inverse;  ///< 1/m: of the edges from its first corner to the others
};

/// Of a deformation, whose gradient maps the edges at the start to those now.
struct Strained {
  double energy = 0;       ///< J/m^3, 0 at rest
  Eigen::Matrix3d stress;  ///< Pa: first Piola-Kirchhoff, without damping
};
/// With the exact rotation, which Bullet approximates. Threads: any.
Strained StrainedBy(const Material& material, const Eigen::Matrix3d& gradient);

}  // namespace cdb::soft
