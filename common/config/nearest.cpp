#include "common/config/nearest.h"

#include <algorithm>

namespace heartbus::config {

namespace {

// Levenshtein distance, row by row.
std::size_t edit_distance(const std::string &a, const std::string &b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j)
    row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t replaced = diagonal + (a[i - 1] != b[j - 1]);
      diagonal = row[j];
      row[j] = std::min({row[j] + 1, row[j - 1] + 1, replaced});
    }
  }
  return row[b.size()];
}

} // namespace

std::string nearest(const std::string &word, const std::vector<std::string> &candidates) {
  std::string best;
  std::size_t smallest = std::max<std::size_t>(1, (word.size() + 1) / 3) + 1;
  for (const auto &candidate : candidates)
    if (const std::size_t distance = edit_distance(word, candidate); distance < smallest) {
      smallest = distance;
      best = candidate;
    }
  return best;
}

std::string did_you_mean(const std::string &word, const std::vector<std::string> &candidates) {
  const std::string best = nearest(word, candidates);
  return best.empty() ? "." : "; did you mean '" + best + "'?";
}

std::string joined(const std::vector<std::string> &words) {
  std::string text;
  for (const auto &word : words)
    text += (text.empty() ? "" : ", ") + word;
  return text;
}

} // namespace heartbus::config
