// validate LIST: what `coupler --validate` says to each line of LIST, the coupler's arguments separated by tabs. One
// process for many, so that thousands take seconds; whoever crashes or hangs takes only itself along. Prints a line
// for each: exit code or name of the signal, a tab, and what was said. validate --print SCENE prints the scene with
// all its keys.
#include "coupler/options.h"
#include "scene/scene.h"

#include <algorithm>
#include <csignal>
#include <cstring>
#include <fstream>
#include <iostream>
#include <sstream>
#include <sys/resource.h>
#include <sys/wait.h>
#include <unistd.h>
#include <vector>

using namespace heartbus;

namespace {

constexpr unsigned longest = 5; // [s]
constexpr rlim_t memory = rlim_t(2) << 30;

std::string one_line(std::string text) {
  while (!text.empty() && text.back() == '\n')
    text.pop_back();
  std::replace(text.begin(), text.end(), '\n', '\v'); // so that a message of several lines shows
  return text;
}

/// What is accepted must mean the same when it is printed and read again, and be a run.
std::string doubts(const coupler::Options &options) {
  const SceneParameters scene = coupler::scene_of(options);
  const std::string text = print_scene(scene);
  if (print_scene(read_scene(text, "printed")) != text)
    return "doubt: it does not read back from its own print";
  return scene.time.n_steps() > 0 ? "" : "doubt: it has no steps";
}

std::string answer_to(const std::string &line) {
  std::vector<std::string> words{"coupler"};
  std::stringstream stream(line);
  for (std::string word; std::getline(stream, word, '\t');)
    words.push_back(word);
  words.push_back("--validate");
  std::vector<char *> arguments;
  for (auto &word : words)
    arguments.push_back(word.data());
  arguments.push_back(nullptr);

  std::ostringstream said;
  std::streambuf *const out = std::cout.rdbuf(said.rdbuf()), *const err = std::cerr.rdbuf(said.rdbuf());
  coupler::Options options;
  const auto early = coupler::parse(words.size(), arguments.data(), options);
  const int code = early ? *early : coupler::answer(options);
  if (code == 0)
    said << doubts(options);
  std::cout.rdbuf(out);
  std::cerr.rdbuf(err);
  return std::to_string(code) + "\t" + one_line(said.str());
}

/// The answers to all lines from `first` on, until something happens.
[[noreturn]] void answer_all(const std::vector<std::string> &lines, std::size_t first, int to) {
  const rlimit limit{memory, memory};
  setrlimit(RLIMIT_AS, &limit);
  for (std::size_t i = first; i < lines.size(); ++i) {
    alarm(longest);
    const std::string answer = answer_to(lines[i]) + "\n";
    if (write(to, answer.data(), answer.size()) != static_cast<ssize_t>(answer.size()))
      _exit(1);
  }
  _exit(0);
}

} // namespace

int main(int argc, char **argv) {
  if (argc == 3 && argv[1] == std::string("--print")) {
    std::cout << print_scene(load_scene(argv[2], {}));
    return 0;
  }
  std::ifstream file(argc == 2 ? argv[1] : "");
  std::vector<std::string> lines;
  for (std::string line; std::getline(file, line);)
    lines.push_back(line);
  std::size_t n_answered = 0;
  while (n_answered < lines.size()) {
    int ends[2];
    if (pipe(ends) != 0)
      return 1;
    const pid_t child = fork();
    if (child == 0)
      answer_all(lines, n_answered, ends[1]);
    close(ends[1]);
    char block[65536];
    for (ssize_t n; (n = read(ends[0], block, sizeof block)) > 0;) {
      n_answered += std::count(block, block + n, '\n');
      std::cout.write(block, n);
    }
    close(ends[0]);
    int status = 0;
    waitpid(child, &status, 0);
    if (n_answered < lines.size()) {
      ++n_answered;
      std::cout << (WIFSIGNALED(status) ? strsignal(WTERMSIG(status)) : "an exit") << "\t\n";
    }
  }
}
