// Reads any text as a plan: the result is an error, or a plan that is written as it was read.
#include <cstddef>
#include <cstdint>
#include <string>

#include "compiler/yaml/plan_yaml.h"
#include "dsl/text/check.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cdb;
  const std::string text(reinterpret_cast<const char*>(data), size);
  try {
    const plan::Plan plan = yaml::FromYaml(text, "fuzz.yaml");
    CDB_CHECK(yaml::FromYaml(yaml::ToYaml(plan), "again") == plan);
  } catch (const yaml::PlanError& error) {
    CDB_CHECK(std::string(error.what()).starts_with("fuzz.yaml"));
  }
  return 0;
}
