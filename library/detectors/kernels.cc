#include "library/detectors/kernels.h"

#include "library/detectors/kernels_impl.h"

namespace cdb::library {

const Kernels& PlainKernels() {
  static constexpr Kernels kKernels = MakeKernels("plain");
  return kKernels;
}

const Kernels& BestKernels() {
  static const Kernels* const best = Avx2Kernels();
  return best != nullptr ? *best : PlainKernels();
}

}  // namespace cdb::library
