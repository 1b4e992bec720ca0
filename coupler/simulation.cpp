#include "coupler/simulation.h"

#include "common/io/field_writer.h"
#include "common/log/log.h"
#include "common/units/units.h"
#include "coupler/indicators.h"
#include "coupler/launch.h"
#include "coupler/provenance.h"
#include "coupler/sequence/notation.h"
#include "coupler/sequence/passes.h"
#include "coupler/step_log.h"
#include "coupler/trace_file.h"

#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <spdlog/fmt/fmt.h>
#include <sys/resource.h>

namespace heartbus::coupler {

namespace fs = std::filesystem;

namespace {

std::string make_folder(const std::string &name) {
  std::error_code error;
  for (const char *part : {"logs", "fields"})
    if (fs::create_directories(fs::path(name) / part, error); error)
      throw Failure(ExitCode::file, name + ": this folder cannot be made: " + error.message());
  return fs::canonical(name);
}

/// Pictures of another run, which are not those of the steps before this one, go out of the way.
void set_fields_aside(const fs::path &folder) {
  std::error_code error;
  fs::path old = folder / "fields.old";
  for (int n = 2; fs::exists(old, error); ++n)
    old = folder / ("fields.old." + std::to_string(n));
  if (!fs::is_empty(folder / "fields", error) && !error)
    fs::rename(folder / "fields", old, error);
  fs::create_directories(folder / "fields", error);
}

void write_file(const std::string &name, const std::string &text) {
  std::ofstream file(name);
  file << text;
  if (!file.flush())
    throw Failure(ExitCode::file, name + ": cannot be written (disk full?)");
}

rusage own_usage() {
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  return usage;
}

constexpr double MiB = 1024 * 1024;

double seconds(const timeval &time) { return time.tv_sec + 1e-6 * time.tv_usec; }

double busy(const bus::Times &times) {
  const auto waiting = times.parts.find("waiting");
  return bus::total(times.parts) - (waiting == times.parts.end() ? 0 : waiting->second);
}

} // namespace

Simulation::Simulation(bus::Coordinator &coordinator, const Options &options)
    : coordinator_(coordinator), options_(options), scene_(scene_of(options)),
      folder_(make_folder(folder_of(options, scene_))), lock_(lock_results(folder_)) {
  records_of(options); // says what is wrong before anything is done
  if (!options.restart.empty())
    restart_ = find_checkpoint(options.restart, folder_, scene_);
  log_ = log::open_log(folder_, "coupler", 0, true);
}

Simulation::~Simulation() {
  for (const auto &recording : recordings_)
    if (recording && !ended_well_)
      recording->stay_aside();
}

void Simulation::run() {
  const Sequence sequence = meet_participants();
  SequenceRunner runner(coordinator_, sequence);
  record(runner);
  make_columns();
  const TimeControl time(scene_.time);
  Checkpoints checkpoints(folder_, scene_, restart_ ? &*restart_ : nullptr);
  const bus::Step first = begin(runner, time);
  for (const char *of_an_earlier_run : {"indicators.json", "history.csv"})
    std::remove((folder_ + "/" + of_an_earlier_run).c_str());
  HistoryFile csv(folder_ + "/history.csv", history_);

  if (scene_.output.trace)
    begin_trace();
  times_.clear(); // all costs are those of the steps
  first_reports_ = last_reports_;
  const std::size_t rows_before = history_.rows.size();
  const auto start = std::chrono::steady_clock::now();
  steps(runner, time, first.number, checkpoints, csv);
  add_times(runner.report(time.step(time.n_steps())));
  write_indicators(history_.rows.size() - rows_before,
                   std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
  if (trace_)
    end_trace();
  ended_well_ = true;
}

void Simulation::steps(SequenceRunner &runner, const TimeControl &time, int number, Checkpoints &checkpoints,
                       HistoryFile &csv) {
  StepLog step_log(log_, time, number);
  bool stop = false, periodic = false;
  for (++number; number <= time.n_steps() && !stop && !periodic; ++number) {
    const bool goes_on = number < time.n_steps(), due = checkpoints.due(number);
    const bool compares = scene_.time.until_periodic > 0 && goes_on && time.may_end_after_beat(number);
    stop = goes_on && time.refreshes_at(number) && coordinator_.stop_requested();
    advance(runner, time, number, stop || compares || due);
    csv.append(history_);
    step_log.step(history_, time.step(number));
    periodic = compares && is_periodic();
    if (stop || periodic || due)
      save(runner, checkpoints, time.step(number));
    if ((compares || due) && !stop && !periodic)
      runner.refresh(time.step(number));
  }
  if (stop)
    log_->warn("stopped on request after step {} of {}; --restart latest goes on", number - 1, time.n_steps());
  else
    tell_changes();
}

bool Simulation::is_periodic() const {
  return are_below(last_changes(history_, scene_.time.period), scene_.time.until_periodic);
}

void Simulation::tell_changes() const {
  if (scene_.time.until_periodic == 0)
    return;
  std::string text;
  const auto changes = last_changes(history_, scene_.time.period);
  for (const auto &[name, percent] : changes.items())
    text += (text.empty() ? "" : ", ") + name + " " + fmt::format("{:.3g} %", percent.get<double>());
  text = "the last complete beat differs from the one before by " + (text.empty() ? "nothing known" : text);
  const double wanted = 100 * scene_.time.until_periodic;
  if (is_periodic())
    log_->info("periodic: {}; less than {:g} % was wanted", text, wanted);
  else
    log_->warn("not periodic within 'time.beats: {}': {}; less than {:g} % was wanted", scene_.time.beats, text,
               wanted);
}

void Simulation::begin_trace() {
  coordinator_.trace();
  trace_.emplace();
}

void Simulation::advance(SequenceRunner &runner, const TimeControl &time, int number, bool pauses) {
  const auto begin = std::chrono::steady_clock::now();
  collect(runner.step(time, number, pauses), time.step(number));
  if (trace_)
    trace_->add("step", begin, std::chrono::steady_clock::now(), time.step(number));
}

void Simulation::end_trace() {
  auto traces = coordinator_.finish();
  traces.push_back({"coupler", 0, std::move(*trace_)});
  write_trace(folder_ + "/trace.json", traces);
}

/// The state before the first step, which is the last of the history then.
bus::Step Simulation::begin(SequenceRunner &runner, const TimeControl &time) {
  if (restart_)
    return restart(runner, time);
  collect(runner.start(time.step(0)), time.step(0));
  return time.step(0);
}

/// Steps of another size count from zero as if they had always been of that size.
bus::Step Simulation::restart(SequenceRunner &runner, const TimeControl &time) {
  for (const auto &reason : restart_->passed_over)
    log_->warn("passed over: {}", reason);
  const double size = time.step(1).size;
  const bus::Step step = time.step(static_cast<int>(std::lround(restart_->manifest.time / size)));
  if (std::abs(step.time - restart_->manifest.time) > 1e-6 * size || step.number > time.n_steps())
    throw Failure(ExitCode::scene, "checkpoint " + restart_->folder +
                                       " is of t = " + config::shortest(restart_->manifest.time) +
                                       " s; that must be a multiple of 'time.step' (" + config::shortest(size) +
                                       " s) and not beyond 'time.end' (" + config::shortest(scene_.time.end) + " s)");
  last_reports_ = runner.states(bus::Command::Kind::load, restart_->folder, step);
  read_history(restart_->folder + "/history.csv", history_);
  log_->info("goes on from t = {:.1f} ms, {}", 1e3 * step.time, restart_->folder);
  return step;
}

void Simulation::save(SequenceRunner &runner, Checkpoints &checkpoints, const bus::Step &step) {
  add_times(runner.states(bus::Command::Kind::save, checkpoints.open(step), step));
  checkpoints.close(step);
  io::remove_old_parts(folder_ + "/fields");
  for (const auto &recording : recordings_)
    recording->show();
  log_->info("checkpoint of t = {:.1f} ms", 1e3 * step.time);
}

Sequence Simulation::meet_participants() {
  const std::string text = print_scene(scene_);
  std::error_code error;
  if (restart_ && !fs::equivalent(fs::path(restart_->folder).parent_path(), folder_ + "/checkpoints", error))
    set_fields_aside(folder_);
  std::map<std::string, bus::Coordinator::Expected> expected;
  for (const auto &[name, participant] : scene_.participants)
    expected[name] = {program_name(participant.program), participant.ranks, participant.settings};
  for (const auto &[name, texts] : interface_settings(scene_))
    if (const auto who = expected.find(name); who != expected.end())
      who->second.coupling = texts;
  coordinator_.handshake(expected, text, folder_, scene_.coupling.deadline);

  const auto &participants = coordinator_.participants();
  Sequence sequence = drop_absent(make_sequence(scene_.coupling, scene_.time.step), participants);
  if (scene_.coupling.lookahead > 0)
    sequence = ordered_ahead(sequence, scene_.coupling.lookahead);
  check(sequence, participants);
  write_file(folder_ + "/scene.resolved.yaml", text);
  write_file(folder_ + "/provenance.json", provenance(folder_));
  log_->info("{}: the scheme {} is{}", scene_.name, sequence.name,
             to_yaml(drop_absent(scheme(scene_.coupling), participants)));
  log_->info("as it is done: {}", to_text(sequence));
  return sequence;
}

void Simulation::record(const SequenceRunner &runner) {
  for (const auto &[field, file] : records_of(options_)) {
    const std::size_t i = recordings_.size();
    recordings_.push_back(nullptr);
    const auto on_values = [this, i](const bus::Step &step, const std::vector<double> &values) {
      recordings_[i]->append(step.number, step.time, values);
    };
    const auto target = coordinator_.record(runner.route_of(field), on_values);
    recordings_[i] = open_recording(file, {field, target.unit, target.components, target.coordinates});
  }
}

/// Of a run that goes on: with what was recorded before.
std::unique_ptr<io::RecordingWriter> Simulation::open_recording(const std::string &file,
                                                                const io::RecordedField &field) const {
  auto recording = std::make_unique<io::RecordingWriter>(file, field);
  if (restart_ && fs::exists(file))
    recording->keep(io::RecordingReader(file), field, restart_->manifest.time);
  else if (restart_)
    log_->warn("{} begins at t = {:.1f} ms, where this run goes on: nothing was recorded there before", file,
               1e3 * restart_->manifest.time);
  return recording;
}

// A scalar keeps its own name while only one participant has it.
void Simulation::make_columns() {
  std::map<std::string, int> count;
  for (const auto &participant : coordinator_.participants())
    for (const auto &scalar : participant.scalars)
      ++count[scalar.name];
  history_.columns = {{"step", "", {}}, {"time", "s", {}}};
  for (const auto &participant : coordinator_.participants())
    for (const auto &scalar : participant.scalars)
      history_.columns.push_back(
          {count[scalar.name] > 1 ? participant.name + "." + scalar.name : scalar.name, scalar.unit, scalar.states});
}

void Simulation::collect(const SequenceRunner::Reports &reports, const bus::Step &step) {
  std::vector<double> row{static_cast<double>(step.number), step.time};
  for (const auto &participant : coordinator_.participants()) {
    const bus::Report &report = reports.at(participant.name);
    row.insert(row.end(), report.scalars.begin(), report.scalars.end());
  }
  history_.rows.push_back(row);
  add_times(reports);
}

void Simulation::add_times(const SequenceRunner::Reports &reports) {
  for (const auto &[participant, report] : reports)
    times_[participant] += report.times;
  last_reports_ = reports;
}

void Simulation::add_costs(nlohmann::ordered_json &result) const {
  for (const auto &participant : coordinator_.participants()) {
    const std::string &name = participant.name;
    const bus::Report &report = last_reports_.at(name);
    const bus::Times &times = times_.at(name);
    result["wall_s_by_part"][name] = busy(times);
    result["wall_s_by_work"][name] = times.parts;
    result["wall_s_by_command"][name] = times.commands;
    result["cpu_s_by_part"][name] = report.cpu_seconds - first_reports_.at(name).cpu_seconds;
    result["start_cpu_s_by_part"][name] = first_reports_.at(name).cpu_seconds;
    result["peak_memory_MiB_by_part"][name] = report.peak_memory / MiB;
    result["overslept_by_part"][name] = report.n_overslept - first_reports_.at(name).n_overslept;
    for (const auto &set : participant.point_sets)
      result["points"][name][set.name] = set.n_points();
  }
}

void Simulation::write_indicators(std::size_t n_steps, double wall_seconds) const {
  nlohmann::ordered_json result = indicators(history_, scene_.time.period);
  if (n_steps > 0)
    add_costs(result);
  const rusage own = own_usage();
  double cpu = seconds(own.ru_utime) + seconds(own.ru_stime), memory = own.ru_maxrss * 1024.0;
  for (const auto &[name, report] : last_reports_) {
    cpu += report.cpu_seconds;
    memory += report.peak_memory;
  }
  result["steps"] = history_.rows.size() - 1;
  result["steps_timed"] = n_steps; // fewer after a restart
  result["wall_s"] = wall_seconds;
  result["cpu_s"] = cpu;
  result["peak_memory_MiB"] = memory / MiB;
  if (result.contains("phases") && !result["beats"][0]["complete"])
    log_->info("no beat of {:g} ms is complete: the indicators are of what there is", 1e3 * scene_.time.period);
  print_numbers(result);
  write_file(folder_ + "/indicators.json", result.dump(2) + "\n");
}

/// A launcher has a table of them.
void Simulation::print_numbers(const nlohmann::ordered_json &result) const {
  const auto log = std::getenv("HEARTBUS_PULSE") ? for_the_file(*log_) : log_;
  const auto &beats = result["beats"];
  for (std::size_t i = 0; beats.size() > 1 && i < beats.size(); ++i) {
    std::string line;
    for (const auto &[key, value] : beats[i].items())
      if (value.is_number_float() && key != "start" && key != "end")
        line += fmt::format("  {} {:.4g}", key, value.get<double>());
    log->info("beat {}{}{}", beats[i]["beat"].get<int>(), beats[i]["complete"] ? "" : " (incomplete)", line);
  }
  for (const auto &[key, value] : result.items())
    if (value.is_number())
      log->info("{:20} {:g}", key, value.get<double>());
}

} // namespace heartbus::coupler
