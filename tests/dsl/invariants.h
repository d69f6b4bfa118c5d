// Invariants that hold for every text, valid or not.
#pragma once

#include <string>

namespace cdb::tests {

/// Parses and renders the text, and formats it if it parses. Returns the broken invariant: a span
/// outside the text, an error without a message or reported twice, a tree that is too high, a
/// format that is not stable or changes the tree. Empty if all hold.
std::string BrokenInvariant(const std::string& text);

}  // namespace cdb::tests
