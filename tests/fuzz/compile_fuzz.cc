// Compiles any text: it does not crash, every error has a position, and a text without errors gives
// a plan that can be read back from YAML.
#include <cstddef>
#include <cstdint>
#include <string>

#include "compiler/compile.h"
#include "compiler/yaml/plan_yaml.h"
#include "dsl/diagnostics.h"
#include "dsl/text/check.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cdb;
  const std::string text(reinterpret_cast<const char*>(data), size);
  // The text is also the content of every other file, so that `use` finds something.
  const auto read = [&](const std::string&, std::string&) -> std::optional<std::string> {
    return text;
  };
  const auto describe = [](const std::string&, const std::string&, std::string&) {
    return std::vector<cdb::schema::PluginDetector>{{"mine", "broad narrow", 100, "", ""},
                                                    {"touch", "narrow", 0, "", ""}};
  };
  const cdb::compiler::Compilation result =
      cdb::compiler::Compile("fuzz.cdb", read, {"", std::nullopt, {{}, describe}});
  for (const auto& diagnostic : result.diagnostics.all())
    CDB_CHECK(diagnostic.kind != nullptr && diagnostic.span.source != nullptr &&
              diagnostic.span.begin <= diagnostic.span.end &&
              diagnostic.span.end <= diagnostic.span.source->text().size());
  cdb::dsl::Render(result.diagnostics);
  CDB_CHECK(result.plans.empty() || !result.diagnostics.has_errors());
  for (const cdb::plan::Plan& plan : result.plans) {
    CDB_CHECK(!plan.runs.empty());
    // Large grids reveal no more than small ones, and take long.
    if (plan.runs.size() < 50)
      CDB_CHECK(cdb::yaml::FromYaml(cdb::yaml::ToYaml(plan), "plan") == plan);
  }
  return 0;
}
