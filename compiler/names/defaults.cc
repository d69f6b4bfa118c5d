#include "compiler/names/defaults.h"

#include <map>
#include <memory>

#include "compiler/schema/schema.h"
#include "dsl/parser.h"
#include "dsl/text/check.h"

namespace cdb::names {
namespace {

struct Defaults {
  dsl::File file;
  std::map<const schema::Parameter*, const dsl::Setting*> settings;
};

Defaults ParseDefaults() {
  std::string text = "benchmark defaults {\n";
  for (const schema::Parameter& parameter : schema::Schema())
    text += "  " + parameter.FullName() + " " + std::string(parameter.DefaultText()) + "\n";
  text += "}\n";
  dsl::Diagnostics diagnostics;
  Defaults defaults;
  defaults.file = dsl::Parse(std::make_shared<const text::Source>("defaults", text), diagnostics);
  CDB_CHECK(!diagnostics.has_errors());
  const auto& statements = std::get<dsl::Benchmark>(defaults.file.items[0]).block.statements;
  CDB_CHECK(statements.size() == schema::Schema().size());
  for (std::size_t i = 0; i < statements.size(); ++i)
    defaults.settings[&schema::Schema()[i]] = &std::get<dsl::Setting>(statements[i].what);
  return defaults;
}

}  // namespace

const dsl::Setting& DefaultSetting(const schema::Parameter& parameter) {
  static const Defaults defaults = ParseDefaults();
  return *defaults.settings.at(&parameter);
}

}  // namespace cdb::names
