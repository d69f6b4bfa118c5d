// Random numbers that are the same on every platform.
#pragma once

#include <Eigen/Core>
#include <random>

namespace cdb::tests {

struct Random {
  explicit Random(unsigned seed) : engine(seed) {}
  double operator()(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine);
  }
  bool Chance(double p) { return (*this)(0, 1) < p; }
  Eigen::Vector3d Vector(double size) {
    return {(*this)(-size, size), (*this)(-size, size), (*this)(-size, size)};
  }
  Eigen::Vector3d Direction() {
    std::normal_distribution<double> normal;
    const Eigen::Vector3d v{normal(engine), normal(engine), normal(engine)};  // in this order
    return v.normalized();
  }
  std::mt19937 engine;
};

}  // namespace cdb::tests
