#include "library/detectors/kernels/kernels.h"

#include "library/detectors/kernels/kernels_impl.h"

namespace cdb::kernels {

const Kernels& PlainKernels() {
  static constexpr Kernels kKernels = MakeKernels("plain");
  return kKernels;
}

const Kernels& BestKernels() {
  static const Kernels* const best = Avx2Kernels();
  return best != nullptr ? *best : PlainKernels();
}

}  // namespace cdb::kernels
