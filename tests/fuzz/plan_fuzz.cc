// Reads any text as a plan: an error, or a plan that is written as it was read.
#include <cstddef>
#include <cstdint>
#include <string>

#include "compiler/plan/plan_yaml.h"
#include "dsl/check.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cdb;
  const std::string text(reinterpret_cast<const char*>(data), size);
  try {
    const plan::Plan plan = plan::FromYaml(text, "fuzz.yaml");
    CDB_CHECK(plan::FromYaml(plan::ToYaml(plan), "again") == plan);
  } catch (const plan::PlanError& error) {
    CDB_CHECK(std::string(error.what()).starts_with("fuzz.yaml"));
  }
  return 0;
}
