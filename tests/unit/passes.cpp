// Passes change the order in which the lines of a step are done, and no result: participants that keep no numbers but
// what these were made of do the steps as a scheme says them and as a pass has them, in any order in which commands can
// be executed at the same time.
#include "coupler/sequence/passes.h"
#include "coupler/sequence/notation.h"
#include "coupler/sequence/sequence_runner.h"
#include "tests/unit/all_schemes.h"

#include <deque>
#include <functional>
#include <gtest/gtest.h>
#include <map>
#include <random>

using namespace heartbus;
using namespace heartbus::coupler;

namespace {

using Kind = bus::Command::Kind;

/// What a value was made of, as one number.
using Value = std::size_t;
Value made_of(const std::string &what, const std::vector<Value> &parts) {
  Value value = std::hash<std::string>()(what);
  for (const Value part : parts)
    value = (value ^ (part + 0x9e3779b97f4a7c15 + (value << 6) + (value >> 2))) * 0x100000001b3;
  return value;
}

/// One participant: what it has received and computed, by name; "_n" and "_nm1" are of the steps before.
class Participant {
 public:
  explicit Participant(const std::string &name) : name_(name) {}
  Value &operator[](const std::string &value) { return values_[value]; }

  void execute(const bus::Command &command) {
    if (command.kind == Kind::commit) {
      commit();
      return;
    }
    const bool is_prepared = prepared_ == command.step.number;
    if (command.kind == Kind::prepare || (command.kind == Kind::solve && !is_prepared)) {
      prepared_ = command.step.number;
      act(name_ + " prepare");
    }
    if (command.kind == Kind::solve)
      act(name_ + " solve");
    if (command.kind == Kind::task)
      act(name_ + " " + command.task);
  }
  std::vector<Value> history;

 private:
  void make(const std::string &what, const std::vector<std::string> &of) {
    std::vector<Value> parts;
    for (const auto &part : of)
      parts.push_back(values_[part]);
    values_[what] = made_of(what, parts);
  }
  /// Who depends on what.
  void act(const std::string &what) {
    if (what == "ep solve")
      make("v", {"v_n"}), make("calcium", {"v"});
    if (what == "mech prepare" || what == "fsi prepare")
      make("tension", {"tension_n", "calcium", "d_n"});
    if (what == "mech prepare")
      make("wall_velocity", {"d_n", "d_nm1"}), make("wall_force", {"L_n", "tension", "tension_n", "d_n"});
    if (what == "mech solve")
      make("d", {"d_n", "d_nm1", "tension", "blood_force"}), show_motion();
    if (what == "fluid accelerate")
      make("accelerated", {"matrix", "wall_velocity", "wall_force"});
    if (what == "mech begin_probe" || what == "mech probe")
      make("probe_force", {"d_n", "probe_velocity"});
    if (what == "mech end_probe")
      make("alpha_limit", {"d_n", "probe_velocity"});
    if (what == "mech correct")
      make("pressure_correction", {"d", "blood_velocity", "unit_pressure_force"}),
          make("d", {"d", "pressure_correction"}), show_motion();
    if (what == "ale solve")
      make("mesh_motion", {"displacement", "mesh_motion_n"});
    if (what == "fluid prepare" || what == "fsi prepare")
      make("matrix", {"mesh_motion", "motion_n", "x_n"});
    if (what == "fluid probe")
      make("probe_velocity", {"mesh_motion", "x_n", "probe_force"});
    if (what == "fluid solve")
      make("x", {"matrix", "wall_velocity", "wall_force"}), make("blood_force", {"x", "wall_force"}),
          make("blood_velocity", {"x"}), make("unit_pressure_force", {"matrix"});
    if (what == "fluid correct")
      make("x", {"x", "pressure_correction"});
    if (what == "fluid budget")
      make("budget", {"x", "wall_velocity"});
    if (what == "fsi solve")
      make("x", {"matrix", "tension", "d_n"}), make("d", {"x", "d_n"}), make("displacement", {"d"});
  }
  void show_motion() {
    make("displacement", {"d"});
    make("wall_velocity", {"d", "d_n"});
    values_["wall_force"] = values_["blood_force"];
  }
  void commit() {
    values_["d_nm1"] = values_["d_n"];
    const std::map<std::string, std::string> states{{"v", "v_n"}, {"tension", "tension_n"},    {"blood_force", "L_n"},
                                                    {"x", "x_n"}, {"mesh_motion", "motion_n"}, {"d", "d_n"}};
    for (const auto &[now, old] : states)
      history.push_back(values_[old] = values_[now]);
    values_["mesh_motion_n"] = values_["mesh_motion"];
    history.push_back(values_["budget"]);
  }

  std::string name_;
  std::map<std::string, Value> values_;
  int prepared_ = 0;
};

/// Several participants, each with its stream of commands, at the same time. A route holds one value at a time.
class Machine {
 public:
  Machine(const Sequence &sequence, int n_steps) : sequence_(sequence), n_steps_(n_steps) {
    for (const auto &[node, iteration] : flatten(sequence.step)) {
      participants_.emplace(node.participant, node.participant);
      if (node.kind == Node::Kind::transfer)
        routes_.insert({{node.participant, node.receiver, node.field}, int(routes_.size())});
    }
    for (const auto &[ends, route] : routes_)
      fields_[route] = std::get<2>(ends);
  }

  /// What everybody had at the end of each step. `seed`: of the order in which commands are executed.
  std::map<std::string, std::vector<Value>> run(unsigned seed) {
    std::mt19937 random(seed);
    for (int step = 1; step <= n_steps_; ++step) {
      order(step);
      while (auto who = somebody(random))
        execute(*who);
      for (const auto &[who, stream] : streams_)
        EXPECT_TRUE(stream.empty() || stream.front().step.number > step) << who << " waits for ever, step " << step;
    }
    std::map<std::string, std::vector<Value>> histories;
    for (const auto &[who, participant] : participants_)
      histories[who] = participant.history;
    return histories;
  }
  int most_steps_ahead() const { return most_steps_ahead_; }

 private:
  /// A step, and more of those who lead.
  void order(int step) {
    for (int number = step; number <= std::min(n_steps_, step + sequence_.ahead); ++number)
      for (const auto &[who, command] : commands(sequence_.step, routes_, {number, 0, number * 1e-3, 1e-3}))
        if (sequence_.source_participants.count(who) ? ordered_[who] < number : number == step)
          streams_[who].push_back(command);
    for (const auto &who : sequence_.source_participants)
      ordered_[who] = std::min(n_steps_, step + sequence_.ahead);
    now_ = step;
  }
  bool can_go_on(const std::string &who, const bus::Command &next) const {
    if (next.kind == Kind::send)
      return values_.count(next.route) == 0;
    if (next.kind == Kind::receive)
      return values_.count(next.route) > 0;
    if (next.kind != Kind::wait)
      return true;
    const auto passed = turns_.find({next.task, who});
    return passed != turns_.end() && passed->second > 0;
  }
  std::optional<std::string> somebody(std::mt19937 &random) const {
    std::vector<std::string> able;
    for (const auto &[who, stream] : streams_)
      if (!stream.empty() && can_go_on(who, stream.front()))
        able.push_back(who);
    if (able.empty())
      return {};
    return able[random() % able.size()];
  }
  void execute(const std::string &who) {
    const bus::Command command = streams_[who].front();
    streams_[who].pop_front();
    most_steps_ahead_ = std::max(most_steps_ahead_, command.step.number - now_);
    Participant &participant = participants_.at(who);
    if (command.kind == Kind::send)
      values_[command.route] = participant[fields_.at(command.route)];
    else if (command.kind == Kind::receive) {
      participant[fields_.at(command.route)] = values_.at(command.route);
      values_.erase(command.route);
    } else if (command.kind == Kind::notify)
      ++turns_[{who, command.task}];
    else if (command.kind == Kind::wait)
      --turns_[{command.task, who}];
    else
      participant.execute(command);
  }

  const Sequence sequence_;
  const int n_steps_;
  Routes routes_;
  std::map<int, std::string> fields_;
  std::map<std::string, Participant> participants_;
  std::map<std::string, std::deque<bus::Command>> streams_;
  std::map<int, Value> values_; ///< on their way
  std::map<std::pair<std::string, std::string>, int> turns_;
  std::map<std::string, int> ordered_;
  int now_ = 0, most_steps_ahead_ = 0;
};

constexpr int n_steps = 4;

/// The pass leaves what comes out, whoever is faster. Returns how many schemes it changes.
int expect_the_same_results(const std::function<Nodes(const Nodes &)> &pass) {
  int n_changed = 0;
  for (const auto &coupling : all_schemes()) {
    const Sequence as_defined = scheme(coupling);
    Sequence passed = as_defined;
    passed.step = pass(passed.step);
    n_changed += to_text(passed) != to_text(as_defined);
    const auto expected = Machine(as_defined, n_steps).run(0);
    for (unsigned seed = 1; seed < 20; ++seed)
      EXPECT_EQ(Machine(passed, n_steps).run(seed), expected) << to_text(passed);
  }
  return n_changed;
}

std::string step_text(const Nodes &step) { return to_text(Sequence{"", {}, step}); }

} // namespace

TEST(Passes, TheMachineSeesAnOrderThatChangesResults) {
  Sequence wrong = scheme({});
  const auto at = [&](const std::string &field) {
    return std::find_if(wrong.step.begin(), wrong.step.end(), [&](const Node &node) { return node.field == field; });
  };
  const auto right = Machine(wrong, n_steps).run(0);
  std::iter_swap(at("displacement"), at("mesh_motion")); // the fluid gets the motion of the step before
  std::iter_swap(at("displacement"), at("displacement") - 1);
  EXPECT_NE(Machine(wrong, n_steps).run(0), right);
}

TEST(Passes, LiftingEarlyChangesNoResult) {
  EXPECT_EQ(expect_the_same_results(lifted_early), 5) << "not where lifting follows the wall, or the fluid is the wall";
  const std::string text = step_text(lifted_early(scheme({}).step));
  EXPECT_EQ(
      text.find("\n  step:  displacement mech->ale; solve ale; mesh_motion ale->fluid; prepare fluid; solve ep; "), 0u)
      << text;
}

TEST(Passes, AnEstimateOfTheLimitChangesNoResultOfAFixedAlpha) {
  const auto probe = [](const Nodes &step) { return with_limit_of_alpha(step, false, 0.2e-3); };
  EXPECT_EQ(expect_the_same_results(probe), 5) << "where there is a Robin condition";
  EXPECT_EQ(expect_the_same_results([&](const Nodes &step) { return probe(lifted_early(step)); }), 5);
}

TEST(Passes, AnAlphaThatFollowsIsTakenOnceTheLimitIsKnownAndBeforeTheFluidIsPrepared) {
  const std::string text = step_text(with_limit_of_alpha(lifted_early(scheme({}).step), true, 0.2e-3));
  EXPECT_NE(text.find("mesh_motion ale->fluid; every 100 steps (begin_probe mech; "), std::string::npos) << text;
  const std::string of_large_steps = step_text(with_limit_of_alpha(lifted_early(scheme({}).step), true, 0.8e-3));
  EXPECT_NE(of_large_steps.find("every 25 steps"), std::string::npos) << "the limit changes in time, not in steps";
  EXPECT_NE(text.find("end_probe mech); alpha_limit mech->fluid; follow_limit fluid; prepare fluid; "),
            std::string::npos)
      << text;
}

TEST(Passes, TheFirstEstimateBelongsToTheStart) {
  Sequence sequence = scheme({});
  sequence.step = with_limit_of_alpha(sequence.step, false, 0.2e-3);
  sequence.start = with_first_limit(sequence.start, sequence.step);
  EXPECT_NE(to_text(sequence).find("start fluid; every 1000 steps (begin_probe mech; "), std::string::npos)
      << to_text(sequence);
  sequence.start.clear();
  EXPECT_TRUE(with_first_limit(sequence.start, sequence.step).empty()) << "where nothing starts the fluid";
}

TEST(Passes, AccelerationPrecedesEachSolveOfTheFluidThatIsRepeated) {
  for (const auto &coupling : all_schemes()) {
    const std::string text = step_text(accelerated(scheme(coupling).step));
    EXPECT_EQ(text.find("accelerate fluid; solve fluid; blood_force") != std::string::npos, coupling.iterates())
        << text;
  }
}

TEST(Passes, TurnsChangeNoResultAndNobodyWaitsForEver) {
  EXPECT_EQ(expect_the_same_results(in_turns), 8);
  EXPECT_EQ(expect_the_same_results([](const Nodes &step) { return in_turns(lifted_early(step)); }), 8);
}

TEST(Passes, InTurnsElectrophysiologyGoesOnOnceTheFluidIsPrepared) {
  const std::string early = step_text(in_turns(lifted_early(scheme({}).step)));
  EXPECT_NE(early.find("prepare fluid; then ep goes on; solve ep; "), std::string::npos) << early;
  const std::string plain = step_text(in_turns(scheme({}).step));
  EXPECT_NE(plain.find("commit fluid; then ep goes on with the next step"), std::string::npos) << plain;
}

TEST(Passes, OrderingAheadChangesNoResult) {
  for (CouplingParameters coupling : all_schemes())
    for (const int ahead : {1, 3, 100}) {
      const auto expected = Machine(scheme(coupling), n_steps).run(0);
      coupling.lookahead = ahead;
      const Sequence sequence = ordered_ahead(make_sequence(coupling, 0.2e-3), ahead);
      EXPECT_EQ(sequence.source_participants, std::set<std::string>{"ep"});
      int most = 0;
      for (unsigned seed = 1; seed < 20; ++seed) {
        Machine machine(sequence, n_steps);
        EXPECT_EQ(machine.run(seed), expected) << to_text(sequence);
        most = std::max(most, machine.most_steps_ahead());
      }
      EXPECT_GE(most, 1) << "nobody has run ahead";
    }
}

TEST(Passes, AllOfThemTogetherChangeNoResult) {
  for (const auto &coupling : all_schemes()) {
    const auto expected = Machine(scheme(coupling), n_steps).run(0);
    for (unsigned seed = 1; seed < 20; ++seed)
      EXPECT_EQ(Machine(make_sequence(coupling, 0.2e-3), n_steps).run(seed), expected) << coupling.scheme;
  }
}
