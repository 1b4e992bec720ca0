#pragma once

#include <string>
#include <vector>

namespace heartbus::config {

/// The candidate with the smallest edit distance to `word`, or "" when none looks like a slip of the keyboard.
std::string nearest(const std::string &word, const std::vector<std::string> &candidates);

/// "; did you mean 'x'?", or "." when nothing is near: the end of a sentence that says that `word` is unknown.
std::string did_you_mean(const std::string &word, const std::vector<std::string> &candidates);

/// "a, b, c".
std::string joined(const std::vector<std::string> &words);

} // namespace heartbus::config
