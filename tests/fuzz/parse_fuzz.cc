// Parses and renders any bytes, and formats them if they parse.
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>

#include "tests/dsl/invariants.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::string text(reinterpret_cast<const char*>(data), size);
  const std::string problem = cdb::tests::BrokenInvariant(text);
  if (problem.empty()) return 0;
  std::fprintf(stderr, "%s, in:\n%s\n", problem.c_str(), text.c_str());
  std::abort();
}
