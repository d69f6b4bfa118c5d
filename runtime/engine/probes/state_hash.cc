#include "runtime/engine/probes/state_hash.h"

#include <fmt/format.h>

#include <bit>
#include <cstdint>
#include <type_traits>

namespace cdb::probes {
namespace {

class Fnv1a {
 public:
  void Add(btScalar value) {
    using Bits = std::conditional_t<sizeof(btScalar) == 8, std::uint64_t, std::uint32_t>;
    Bits bits = std::bit_cast<Bits>(value);
    for (std::size_t i = 0; i < sizeof(bits); ++i, bits >>= 8)
      hash_ = (hash_ ^ (bits & 0xff)) * 0x100000001b3;
  }
  // The fourth component of Bullet's vectors is padding.
  void Add(const btVector3& v) {
    for (int i = 0; i < 3; ++i) Add(v[i]);
  }
  std::string Hex() const { return fmt::format("{:016x}", hash_); }

 private:
  std::uint64_t hash_ = 0xcbf29ce484222325;
};

void AddBody(const btRigidBody& body, Fnv1a& hash) {
  const btTransform& pose = body.getWorldTransform();
  hash.Add(pose.getOrigin());
  for (int row = 0; row < 3; ++row) hash.Add(pose.getBasis()[row]);
  hash.Add(body.getLinearVelocity());
  hash.Add(body.getAngularVelocity());
}

}  // namespace

std::string StateHash(const world::Engine& engine) {
  Fnv1a hash;
  for (const auto& body : engine.objects()) AddBody(*body, hash);
  return hash.Hex();
}

std::string StateHash(const btRigidBody* const* bodies, std::size_t count) {
  Fnv1a hash;
  for (std::size_t i = 0; i < count; ++i) AddBody(*bodies[i], hash);
  return hash.Hex();
}

}  // namespace cdb::probes
