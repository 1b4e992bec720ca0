#pragma once

#include <string>
#include <vector>

namespace heartbus::config {

/// The candidate with the smallest edit distance to `word`, or "" when none looks like a slip of the keyboard.
std::string nearest(const std::string &word, const std::vector<std::string> &candidates);

/// "; did you mean 'x'?", or "." when nothing is near: the end of a sentence that says that `word` is unknown.
std::string did_you_mean(const std::string &word, const std::vector<std::string> &candidates);

/// The text as one line that a terminal shows and does not obey: control characters as \\x1b; the middle of a very long
/// one is left out.
std::string printable(const std::string &text);

/// "a, b, c".
std::string joined(const std::vector<std::string> &words);

} // namespace heartbus::config
