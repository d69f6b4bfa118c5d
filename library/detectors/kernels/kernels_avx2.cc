// Compiled with -mavx2 if the compiler supports it. Whether the CPU does is checked here, at run
// time.
#include "library/detectors/kernels/kernels.h"

#ifdef __AVX2__
#include "library/detectors/kernels/kernels_impl.h"
#endif

namespace cdb::kernels {

const Kernels* Avx2Kernels() {
#ifdef __AVX2__
  static constexpr Kernels kKernels = MakeKernels("avx2");
  return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("popcnt") ? &kKernels : nullptr;
#else
  return nullptr;
#endif
}

}  // namespace cdb::kernels
