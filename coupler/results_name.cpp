#include "coupler/results_name.h"

#include "common/io/checksum.h"

#include <algorithm>
#include <array>
#include <cctype>

namespace heartbus::coupler {

namespace {

constexpr std::size_t most = 100, of_checksum = 8; // characters

bool is_length(const std::string &path) {
  const std::array<const char *, 4> paths{"scene", "time.end", "time.beats", "time.until_periodic"};
  return std::find(paths.begin(), paths.end(), path) != paths.end(); // the scene's name stands there already
}

/// "0.4ms" of "0.4 ms", "5000kg_m2s" of "5000 kg/(m^2 s)": a unit follows its number, anything else that is no letter
/// or digit becomes one line.
std::string plain(const std::string &value) {
  std::string text;
  for (const unsigned char c : value) {
    const bool is_after_digit = !text.empty() && std::isdigit(static_cast<unsigned char>(text.back()));
    if (std::isalnum(c) || c == '.' || c == '+' || c == '-' || c > 0x7f)
      text += static_cast<char>(c);
    else if (c != '^' && !(c == ' ' && is_after_digit) && !text.empty() && text.back() != '_')
      text += '_';
  }
  while (!text.empty() && text.back() == '_')
    text.pop_back();
  return text.empty() ? "none" : text;
}

} // namespace

std::string results_name(const std::string &scene, const std::vector<Change> &changes) {
  std::string all, shortened;
  io::Checksum sum;
  for (const Change &change : changes) {
    if (is_length(change.path))
      continue;
    const std::string word = "-" + plain(change.key) + "=" + plain(change.value),
                      exact = change.path + "=" + change.value;
    if (all == shortened && all.size() + word.size() + 1 + of_checksum <= most)
      shortened += word;
    all += word;
    sum.add(exact.c_str(), exact.size() + 1);
  }
  return scene + (all.size() <= most ? all : shortened + "-" + sum.text().substr(0, of_checksum));
}

} // namespace heartbus::coupler
