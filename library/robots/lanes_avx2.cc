// Compiled with -mavx2 if the compiler supports it. Whether the CPU does is checked here, at run
// time.
#include "library/robots/lanes.h"

#ifdef __AVX2__
#include "library/robots/lanes_impl.h"
#endif

namespace cdb::robots {

const LaneKernel* Avx2LaneKernel() {
#ifdef __AVX2__
  static constexpr LaneKernel kKernel = {kFloats, CheckLanes};
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("popcnt") ? &kKernel : nullptr;
#else
  return nullptr;
#endif
}

}  // namespace cdb::robots
