#include "compiler/schema/metrics.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <string>
#include <vector>

#include "compiler/schema/parametrised_words.h"
#include "compiler/schema/schema.h"

namespace cdb::tests {
namespace {

/// The default names of axes for the group `objects`.
std::vector<std::string> DefaultAxisNames() {
  std::vector<std::string> names;
  for (const schema::Parameter& parameter : schema::Schema()) {
    const std::string full = parameter.FullName();
    std::string name = full.substr(full.find('.') + 1);
    std::ranges::replace(name, '.', '_');
    names.push_back(name);
    for (const char* component : {"_x", "_y", "_z"}) names.push_back(name + component);
    for (const std::string_view call : parameter.AllCalls())
      for (const schema::Parameter& argument : schema::FindParametrisedWord(call)->arguments)
        names.push_back(name + "_" + std::string(argument.name));
  }
  return names;
}

TEST(ResultNames, LeaveEveryParameterItsAxis) {
  std::vector<const schema::ErrorInfo*> errors;
  for (const schema::ErrorInfo& error : schema::Errors()) errors.push_back(&error);
  const std::vector<std::string> names = DefaultAxisNames();
  EXPECT_GT(names.size(), 100u);
  for (const std::string& name : names)
    EXPECT_EQ(schema::FindNameClash(name, errors).value_or("free"), "free") << name;
}

}  // namespace
}  // namespace cdb::tests
