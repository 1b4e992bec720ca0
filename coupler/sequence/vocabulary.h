#pragma once

#include "coupler/sequence/sequence.h"

namespace heartbus::coupler {

// The words of which schemes and passes are made.
inline Node solve(const std::string &who) { return {Node::Kind::solve, who, "", "", "", 1, {}}; }
inline Node prepare(const std::string &who) { return {Node::Kind::prepare, who, "", "", "", 1, {}}; }
inline Node commit(const std::string &who) { return {Node::Kind::commit, who, "", "", "", 1, {}}; }
inline Node order(const std::string &who, const std::string &task) {
  return {Node::Kind::task, who, task, "", "", 1, {}};
}
inline Node transfer(const std::string &field, const std::string &from, const std::string &to) {
  return {Node::Kind::transfer, from, "", to, field, 1, {}};
}
inline Node turn(const std::string &from, const std::string &to, int steps_later = 0) {
  return {Node::Kind::turn, from, "", to, "", steps_later, {}};
}
inline Node repeat(int times, const Nodes &body) { return {Node::Kind::repeat, "", "", "", "", times, body}; }
inline Node until(const std::string &who, const std::string &scalar, double limit, int at_most, const Nodes &body) {
  return {Node::Kind::until, who, "", "", scalar, at_most, body, limit};
}
inline Node every(int steps, const std::string &who, const std::string &scalar, const Nodes &body) {
  return {Node::Kind::every, who, "", "", scalar, steps, body};
}
inline Node required(Node node) {
  node.required = true;
  return node;
}
inline Node optional(Node node) {
  node.optional = true;
  return node;
}
inline Node if_wanted(Node node) {
  node.if_wanted = true;
  return node;
}

inline Nodes operator+(Nodes first, const Nodes &second) {
  first.insert(first.end(), second.begin(), second.end());
  return first;
}

inline bool is_transfer(const Node &node, const std::string &field) {
  return node.kind == Node::Kind::transfer && node.field == field;
}
inline bool is(const Node &node, Node::Kind kind, const std::string &who) {
  return node.kind == kind && node.participant == who;
}
/// With more lines after the first that is this one; without any, as it is.
inline Nodes after(const Nodes &step, const Node &line, const Nodes &more) {
  Nodes result;
  bool is_done = false;
  for (const Node &node : step) {
    result.push_back(node);
    if (!is_done && node.kind == line.kind && node.participant == line.participant && node.field == line.field) {
      result.insert(result.end(), more.begin(), more.end());
      is_done = true;
    }
  }
  return result;
}

} // namespace heartbus::coupler
