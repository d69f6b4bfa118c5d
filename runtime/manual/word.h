// Manual entries of parameters, and of words with their arguments (`cdb doc`).
#pragma once

#include <string>

#include "compiler/schema/parametrised_words.h"
#include "compiler/schema/schema.h"

namespace cdb::manual {

/// A parameter, and the words with arguments that it takes.
std::string ParameterReference(const schema::Parameter& parameter);
std::string WordReference(const schema::ParametrisedWord& word);

// The words of a kind, then the arguments of those that have any.
std::string ObjectReference();
std::string LayoutReference();
std::string ScheduleReference();

}  // namespace cdb::manual
