#include "coupler/sequence/notation.h"

#include "common/units/units.h"
#include "coupler/sequence/vocabulary.h"

#include <regex>
#include <stdexcept>

namespace heartbus::coupler {

namespace {

/// Of a node with a body what precedes that.
std::string head_of(const Node &node) {
  switch (node.kind) {
  case Node::Kind::prepare:
    return "prepare " + node.participant;
  case Node::Kind::solve:
    return "solve " + node.participant;
  case Node::Kind::commit:
    return "commit " + node.participant;
  case Node::Kind::task:
    return node.task + " " + node.participant;
  case Node::Kind::transfer:
    return node.field + " " + node.participant + "->" + node.receiver +
           (node.optional    ? " if known"
            : node.if_wanted ? " if wanted"
                             : "");
  case Node::Kind::repeat:
    return std::to_string(node.times) + " times";
  case Node::Kind::until:
    return "at most " + std::to_string(node.times) + " times until " + node.field + " of " + node.participant + " < " +
           config::shortest(node.limit) + (node.required ? " or fail" : "");
  case Node::Kind::every:
    return "every " + std::to_string(node.times) + " steps";
  case Node::Kind::turn:
    return "then " + node.receiver + (node.times > 0 ? " goes on with the next step" : " goes on");
  }
  return "";
}

std::string in_brackets(const Nodes &nodes) {
  std::string text;
  for (const Node &node : nodes)
    text += (text.empty() ? "" : ", ") + head_of(node) + (node.body.empty() ? "" : ": " + in_brackets(node.body));
  return "[" + text + "]";
}

std::string to_text(const Nodes &nodes) {
  std::string text;
  for (const Node &node : nodes)
    text += (text.empty() ? "" : "; ") + head_of(node) + (node.body.empty() ? "" : " (" + to_text(node.body) + ")");
  return text;
}

[[noreturn]] void refuse(const config::Outline &line, const std::string &message) {
  throw Failure(ExitCode::scene, line.where + ": '" + line.text + "' " + message);
}

int number_of(const config::Outline &line, const std::string &digits) {
  const int number = digits.size() > 4 ? 0 : std::stoi(digits);
  if (number < 1 || number > 1000)
    refuse(line, "repeats from 1 to 1000 times");
  return number;
}

double limit_of(const config::Outline &line, const std::string &text) {
  try {
    return config::parse_number(text);
  } catch (const std::invalid_argument &) {
    refuse(line, "ends with a limit, a plain number in SI units, not '" + text + "'");
  }
}

/// A line without those below it.
Node to_node(const config::Outline &line) {
  static const std::regex act("(\\S+) ([^\\s>]+)"), sent("(\\S+) ([^\\s>]+)->([^\\s>]+)( if known| if wanted)?"),
      repeated("(\\d+) times"), limited("at most (\\d+) times until (\\S+) of (\\S+) < (\\S+)( or fail)?");
  std::smatch words;
  const auto word = [&words](int i) { return words[i].str(); };
  if (std::regex_match(line.text, words, repeated))
    return repeat(number_of(line, word(1)), {});
  if (std::regex_match(line.text, words, limited)) {
    Node node = until(word(3), word(2), limit_of(line, word(4)), number_of(line, word(1)), {});
    return words[5].matched ? required(node) : node;
  }
  if (std::regex_match(line.text, words, sent)) {
    const Node node = transfer(word(1), word(2), word(3));
    return word(4) == " if known" ? optional(node) : word(4) == " if wanted" ? if_wanted(node) : node;
  }
  if (std::regex_match(line.text, words, act)) {
    const std::string what = word(1), who = word(2);
    return what == "solve"     ? solve(who)
           : what == "prepare" ? prepare(who)
           : what == "commit"  ? commit(who)
                               : order(who, what);
  }
  refuse(line, "is no line of a sequence; those are 'solve P', 'prepare P', 'commit P', 'TASK P', 'FIELD P->Q', "
               "'FIELD P->Q if known' or 'if wanted', and with a list of lines below '3 times:' and "
               "'at most 9 times until SCALAR of P < LIMIT:', perhaps with 'or fail'");
}

/// `may_wait`: whether the coupler may wait for a scalar here.
Nodes parse(const std::vector<config::Outline> &lines, bool may_wait) {
  Nodes nodes;
  for (const config::Outline &line : lines) {
    Node node = to_node(line);
    node.where = line.where;
    const bool repeats = node.kind == Node::Kind::repeat || node.kind == Node::Kind::until;
    if (repeats && line.lines.empty())
      refuse(line, "repeats nothing; it needs a list of lines below: '- " + line.text + ": [solve P]'");
    if (!repeats && !line.lines.empty())
      refuse(line, "repeats nothing, so no lines can be below it");
    if (node.kind == Node::Kind::until && !may_wait)
      refuse(line, "depends on a scalar, which is for 'step' alone, and not within another repetition");
    node.body = parse(line.lines, false);
    nodes.push_back(node);
  }
  return nodes;
}

} // namespace

std::string to_lines(const Nodes &nodes, const std::string &indent) {
  std::string text;
  for (const Node &node : nodes)
    text +=
        "\n" + indent + "- " + head_of(node) + (node.body.empty() ? "" : ":" + to_lines(node.body, indent + "    "));
  return text;
}

std::string to_yaml(const Sequence &sequence) {
  const std::string once = sequence.constants.empty() ? "" : "\n  once: " + in_brackets(sequence.constants);
  const std::string start = sequence.start.empty() ? "" : "\n  start: " + in_brackets(sequence.start);
  return once + start + "\n  step:" + to_lines(sequence.step, "    ");
}

std::string to_text(const Sequence &sequence) {
  const std::string constants = sequence.constants.empty() ? "" : "\n  once:  " + to_text(sequence.constants);
  const std::string start = sequence.start.empty() ? "" : "\n  start: " + to_text(sequence.start);
  return sequence.name + constants + start + "\n  step:  " + to_text(sequence.step);
}

Sequence parse(const WrittenScheme &written) {
  return {"custom", parse(written.start, false), parse(written.step, true), parse(written.once, false)};
}

} // namespace heartbus::coupler
