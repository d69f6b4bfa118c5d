// Parameters, and words with their arguments, as `cdb doc` prints them.
#pragma once

#include <string>

#include "compiler/schema/parametrised_words.h"
#include "compiler/schema/schema.h"

namespace cdb::manual {

/// A parameter, and the words with arguments that it takes.
std::string ParameterReference(const schema::Parameter& parameter);
std::string WordReference(const schema::ParametrisedWord& word);

// The words of a kind, then the arguments of those that have some.
std::string ObjectReference();
std::string LayoutReference();
std::string ScheduleReference();

}  // namespace cdb::manual
