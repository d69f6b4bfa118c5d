// Every word of the language and of the results, with its manual entry.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "compiler/schema/parametrised_words.h"
#include "compiler/schema/schema.h"

namespace cdb::manual {

/// Everything called `name`: words of the language, parameters (also by the last part of a name, or
/// by the block that they are in), words with arguments, words that parameters take, verdicts,
/// series and diagnostics. Empty if there is nothing.
std::string TextAbout(std::string_view name);

/// The kind of a word, in one line: `detector: Bullet's two dynamic trees`. Empty if it is unknown.
std::string LineAbout(std::string_view name);

/// All names that TextAbout knows, each once.
std::vector<std::string> KnownNames();

// Manual entries of parameters, and of words with their arguments (`cdb doc`).

/// A parameter, and the words with arguments that it takes.
std::string ParameterReference(const schema::Parameter& parameter);
std::string WordReference(const schema::ParametrisedWord& word);

// The words of a kind, then the arguments of those that have any.
std::string ObjectReference();
std::string LayoutReference();
std::string ScheduleReference();

}  // namespace cdb::manual
