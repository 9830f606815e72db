#include "apps/report/run_data.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "scheduler/run_files.h"

namespace atrium {
namespace {

using Json = nlohmann::json;

constexpr double kAnything = -std::numeric_limits<double>::infinity();

constexpr Field<HistoryEntry> kHistoryFields[] = {
    {"seconds", &HistoryEntry::seconds},
    {"cpu_seconds", &HistoryEntry::cpu_seconds},
    {"iteration", &HistoryEntry::iteration},
    {"clusters_gathered", &HistoryEntry::clusters_gathered},
    {"residual", &HistoryEntry::residual},
    {"error_estimate", &HistoryEntry::error_estimate},
    {"error_estimate_low", &HistoryEntry::error_estimate_low, kAnything},
    {"error_estimate_high", &HistoryEntry::error_estimate_high},
    {"error_true", &HistoryEntry::error_true},
    {"energy_closure", &HistoryEntry::energy_closure, kAnything},
    {"elements", &HistoryEntry::elements},
    {"links", &HistoryEntry::links},
    {"rays", &HistoryEntry::rays},
    {"reads", &HistoryEntry::reads},
    {"writes", &HistoryEntry::writes},
    {"bytes_read", &HistoryEntry::bytes_read},
    {"bytes_written", &HistoryEntry::bytes_written},
    {"hit_ratio", &HistoryEntry::hit_ratio},
    {"solver_seconds", &HistoryEntry::solver_seconds},
    {"io_seconds", &HistoryEntry::io_seconds},
    {"stall_seconds", &HistoryEntry::stall_seconds},
    {"max_working_set_bytes", &HistoryEntry::max_working_set_bytes},
    {"peak_rss_bytes", &HistoryEntry::peak_rss_bytes}};

constexpr Field<RunSummary> kSummaryFields[] = {
    {"patches", &RunSummary::patches},
    {"clusters", &RunSummary::clusters},
    {"cells", &RunSummary::cells},
    {"portals", &RunSummary::portals},
    {"lights", &RunSummary::lights},
    {"iterations", &RunSummary::iterations},
    {"elements", &RunSummary::elements},
    {"links", &RunSummary::links},
    {"max_working_set_bytes", &RunSummary::max_working_set_bytes},
    {"max_working_set_links", &RunSummary::max_working_set_links},
    {"max_working_set_elements", &RunSummary::max_working_set_elements},
    {"links_processed", &RunSummary::links_processed},
    {"total_data_bytes", &RunSummary::total_data_bytes},
    {"store_bytes", &RunSummary::store_bytes},
    {"flux_emitted", &RunSummary::flux_emitted},
    {"flux_absorbed", &RunSummary::flux_absorbed, kAnything},
    {"flux_escaped", &RunSummary::flux_escaped, kAnything},
    {"hit_ratio", &RunSummary::hit_ratio},
    {"reads", &RunSummary::reads},
    {"writes", &RunSummary::writes},
    {"evictions", &RunSummary::evictions},
    {"bytes_read", &RunSummary::bytes_read},
    {"bytes_written", &RunSummary::bytes_written},
    {"solver_seconds", &RunSummary::solver_seconds},
    {"io_seconds", &RunSummary::io_seconds},
    {"stall_seconds", &RunSummary::stall_seconds},
    {"total_seconds", &RunSummary::total_seconds},
    {"residual", &RunSummary::residual},
    {"error_estimate", &RunSummary::error_estimate},
    {"error_estimate_low", &RunSummary::error_estimate_low, kAnything},
    {"error_estimate_high", &RunSummary::error_estimate_high},
    {"error_true", &RunSummary::error_true},
    {"energy_closure", &RunSummary::energy_closure, kAnything},
    {"exit_code", &RunSummary::exit_code},
    {"peak_rss_bytes", &RunSummary::peak_rss_bytes}};

Status broken(const std::string& path, const std::string& place, const std::string& cause) {
  return Status(Code::kStore, path, place, cause, "restore it from a copy, or solve again");
}

Status wrong_kind(const std::string& path, const std::string& place, const std::string& key,
                  const char* kind) {
  return broken(path, place, "'" + key + "' is not " + kind);
}

std::string line_of(const std::string& text, std::size_t byte) {
  const auto end = text.begin() + static_cast<std::ptrdiff_t>(std::min(byte, text.size()));
  return "line " + std::to_string(1 + std::count(text.begin(), end, '\n'));
}

// Where in the file, and which file: what errors tell.
struct Place {
  const std::string& path;
  std::string line;
};

template <class Record>
Status take_number(const Json& object, const Field<Record>& field, const Place& at,
                   Record& record) {
  const auto found = object.find(field.name);
  if (found == object.end() || found->is_null()) return {};
  if (!found->is_number()) return wrong_kind(at.path, at.line, field.name, "a number");
  const double value = found->template get<double>();
  if (value < field.least)
    return broken(at.path, at.line, std::string(field.name) + " is negative");
  record.*field.value = value;
  return {};
}

Status take_text(const Json& object, const char* key, const Place& at, std::string& text) {
  const auto found = object.find(key);
  if (found == object.end()) return {};
  if (!found->is_string()) return wrong_kind(at.path, at.line, key, "a text");
  text = found->get<std::string>();
  return {};
}

Status take_left_out(const Json& object, const Place& at, std::vector<LeftOut>& left_out) {
  constexpr const char* kKey = "left_out";
  const auto found = object.find(kKey);
  if (found == object.end()) return {};
  if (!found->is_array()) return wrong_kind(at.path, at.line, kKey, "a list");
  for (const Json& item : *found) {
    if (!item.is_object()) return wrong_kind(at.path, at.line, kKey, "a list of objects");
    LeftOut l;
    ATRIUM_RETURN_IF_ERROR(take_text(item, "feature", at, l.feature));
    ATRIUM_RETURN_IF_ERROR(take_text(item, "why", at, l.why));
    left_out.push_back(std::move(l));
  }
  return {};
}

Status take_numbers(const Json& object, const char* key, const Place& at,
                    std::vector<double>& numbers) {
  const auto found = object.find(key);
  if (found == object.end()) return {};
  if (!found->is_array()) return wrong_kind(at.path, at.line, key, "a list");
  for (const Json& item : *found) {
    if (!item.is_number()) return wrong_kind(at.path, at.line, key, "a list of numbers");
    numbers.push_back(item.get<double>());
  }
  return {};
}

Status take_working_sets(const Json& object, const Place& at, HistoryEntry& entry) {
  constexpr const char* kKey = "working_sets";
  const auto found = object.find(kKey);
  if (found == object.end()) return {};
  if (!found->is_object()) return wrong_kind(at.path, at.line, kKey, "an object");
  ATRIUM_RETURN_IF_ERROR(take_numbers(*found, "largest", at, entry.largest_working_sets));
  return take_numbers(*found, "mean", at, entry.mean_working_sets);
}

Result<HistoryEntry> parse_entry(const std::string& line, const Place& at) {
  const Json object = Json::parse(line, nullptr, false);
  if (!object.is_object()) return broken(at.path, at.line, "not a JSON object");
  HistoryEntry entry;
  for (const Field<HistoryEntry>& field : kHistoryFields)
    ATRIUM_RETURN_IF_ERROR(take_number(object, field, at, entry));
  ATRIUM_RETURN_IF_ERROR(take_working_sets(object, at, entry));
  for (const Field<HistoryEntry>& field : kHistoryFields) {
    const bool needed =
        field.value == &HistoryEntry::seconds || field.value == &HistoryEntry::iteration;
    if (needed && !(entry.*field.value))
      return broken(at.path, at.line, "'" + std::string(field.name) + "' is missing");
  }
  return entry;
}

// Of a line without the field, the iteration is whole.
double gathered(const HistoryEntry& entry) {
  return entry.clusters_gathered.value_or(std::numeric_limits<double>::infinity());
}

bool comes_before(const HistoryEntry& a, const HistoryEntry& b) {
  const bool less_done =
      a.iteration < b.iteration || (a.iteration == b.iteration && gathered(a) < gathered(b));
  return less_done && a.seconds < b.seconds;
}

// Invariant 2.
void append(std::vector<HistoryEntry>& history, const HistoryEntry& entry) {
  while (!history.empty() && !comes_before(history.back(), entry)) history.pop_back();
  history.push_back(entry);
}

// A broken run.toml is a broken run, not a wrong configuration.
Status read_options(const RunFiles& files, RunData& run) {
  const std::string path = files.path(RunFile::kToml);
  const Result<std::string> text = files.read(RunFile::kToml);
  if (!text.ok()) return text.status();
  Result<SettingsFile> settings = parse_settings(*text, path);
  if (!settings.ok()) return broken(path, settings.status().place(), settings.status().cause());
  run.options = std::move(settings->settings);
  return {};
}

Status read_history(const RunFiles& files, RunData& run) {
  if (!files.exists(RunFile::kHistory)) return {};
  const Result<std::string> text = files.read(RunFile::kHistory);
  if (!text.ok()) return text.status();
  Result<std::vector<HistoryEntry>> history = parse_history(*text, files.path(RunFile::kHistory));
  if (!history.ok()) return history.status();
  run.history = std::move(*history);
  return {};
}

Status read_summary(const RunFiles& files, RunData& run) {
  if (run.life == RunLife::kSolving || !files.exists(RunFile::kSummary)) return {};
  const Result<std::string> text = files.read(RunFile::kSummary);
  if (!text.ok()) return text.status();
  Result<RunSummary> summary = parse_summary(*text, files.path(RunFile::kSummary));
  if (!summary.ok()) return summary.status();
  run.summary = std::move(*summary);
  return {};
}

// Invariant 3: the run was resumed after it had told of an end, and did not come to another.
void drop_outgrown_summary(RunData& run) {
  const std::vector<HistoryEntry> iterations = complete_iterations(run);
  if (!run.summary || !run.summary->iterations || iterations.empty()) return;
  if (iterations.back().iteration > run.summary->iterations) run.summary.reset();
}

}  // namespace

std::span<const Field<HistoryEntry>> history_fields() { return kHistoryFields; }

Result<std::vector<HistoryEntry>> parse_history(const std::string& text, const std::string& path) {
  std::vector<HistoryEntry> history;
  std::size_t number = 0, begin = 0;
  for (std::size_t end; (end = text.find('\n', begin)) != std::string::npos; begin = end + 1) {
    const Place at{path, "line " + std::to_string(++number)};
    const Result<HistoryEntry> entry = parse_entry(text.substr(begin, end - begin), at);
    if (!entry.ok()) return entry.status();
    append(history, *entry);
  }
  return history;
}

Result<RunSummary> parse_summary(const std::string& text, const std::string& path) {
  const Place at{path, ""};
  Json object;
  try {
    object = Json::parse(text);
  } catch (const Json::parse_error& e) {
    return broken(path, line_of(text, e.byte), "not JSON");
  }
  if (!object.is_object()) return broken(path, "", "not a JSON object");
  RunSummary summary;
  for (const Field<RunSummary>& field : kSummaryFields)
    ATRIUM_RETURN_IF_ERROR(take_number(object, field, at, summary));
  ATRIUM_RETURN_IF_ERROR(take_text(object, "stop_reason", at, summary.stop_reason));
  ATRIUM_RETURN_IF_ERROR(take_text(object, "version", at, summary.version));
  ATRIUM_RETURN_IF_ERROR(take_left_out(object, at, summary.left_out));
  return summary;
}

Result<RunData> read_run(const std::string& directory) {
  const RunFiles files(machine_disk(Io::kMmap), directory);
  if (!files.exists(RunFile::kToml))
    return Status(Code::kUsage, directory, "", "not a run directory",
                  "give the directory that atrium solve wrote with -o");
  RunData run;
  run.directory = directory;
  if (lock_holder(lock_path(directory))) run.life = RunLife::kSolving;
  ATRIUM_RETURN_IF_ERROR(read_options(files, run));
  ATRIUM_RETURN_IF_ERROR(read_history(files, run));
  ATRIUM_RETURN_IF_ERROR(read_summary(files, run));
  drop_outgrown_summary(run);
  if (run.summary) run.life = RunLife::kEnded;
  return run;
}

std::vector<HistoryEntry> complete_iterations(const RunData& run) {
  double clusters = run.summary ? run.summary->clusters.value_or(0) : 0;
  for (const HistoryEntry& e : run.history)
    clusters = std::max(clusters, e.clusters_gathered.value_or(0));
  std::vector<HistoryEntry> complete;
  for (const HistoryEntry& e : run.history)
    if (gathered(e) >= clusters) complete.push_back(e);
  return complete;
}

}  // namespace atrium
