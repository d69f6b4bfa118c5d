// Invariants of every text, valid or not.
#pragma once

#include <string>

namespace cdb::tests {

/// Parses and renders the text, and formats it where it parses. Gives what was broken: a span
/// outside the text, an error without words or told twice, a tree that is too high, a layout that
/// is not stable or changes the tree. Empty where all is well.
std::string BrokenInvariant(const std::string& text);

}  // namespace cdb::tests
