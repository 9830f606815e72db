// atrium trace ACTION: I/O traces and cache policies.
//   info TRACE            what is in it
//   convert IN OUT        from one format to another
//   simulate TRACE        policies against arenas, counted
//   curve TRACE           misses for every size of the arena
//   replay TRACE          against a store on disk, timed and compared with the simulation
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <functional>
#include <iostream>
#include <memory>

#include <tbb/global_control.h>
#include <tbb/info.h>
#include <tbb/parallel_for.h>

#include "apps/command.h"
#include "apps/output.h"
#include "apps/report_json.h"
#include "apps/trace_report.h"
#include "engine/quantity.h"
#include "pagestore/lower_bound.h"

namespace atrium {
namespace {

// A bound takes about a second at 114,000 requests and up to a minute at 450,000: beyond this many
// it is left out unless asked for.
constexpr std::uint64_t kBoundRequests = 200'000;

struct TraceOptions {
  std::vector<std::string> words;  // the action, then its files
  std::string columns, to;
  std::vector<std::string> policies{"lru"}, arenas;
  bool unit_size = false;
  std::string reorder;
  std::uint64_t seed = 0;
  DiskModel disk;
  std::string bound = "auto";
  std::uint64_t iteration = CountedPart::kAll;
  double sample = 1;
  std::string output, store, io = "mmap";
};

using Words = std::vector<std::string>;

Result<TraceFile> load(const std::string& path, const TraceOptions& options, Console& console) {
  Result<TraceFile> file = read_trace(path, options.columns);
  if (file.ok() && !file->complete)
    console.error(path + ": it was not closed: read up to its last whole chunk, " +
                  std::to_string(file->left_over) + " bytes left over");
  return file;
}

// A share of what the trace holds, else a size; with --unit-size a number of records.
Result<std::uint64_t> arena_of(const std::string& text, const TraceInfo& info, bool unit_size) {
  const bool looks_like_a_share = text.find_first_of("%.") != std::string::npos;
  const Result<double> share = parse_share(text);
  std::uint64_t arena = 0;
  if (looks_like_a_share && share.ok()) {
    const std::uint64_t whole = unit_size ? info.records : info.unique_bytes;
    arena = static_cast<std::uint64_t>(std::floor(*share * static_cast<double>(whole)));
  } else {
    const Result<std::uint64_t> size = parse_size(text);
    if (!size.ok()) return usage_error("--arena: " + size.status().cause(), size.status().remedy());
    if (unit_size && text.find_first_not_of("0123456789") != std::string::npos)
      return usage_error("--arena: '" + text + "' is no number of records",
                         "with --unit-size write 500, or a share: 0.1");
    arena = *size;
  }
  if (arena == 0) return usage_error("--arena: '" + text + "' is nothing", "give it more");
  return arena;
}

Result<std::vector<std::uint64_t>> arenas_of(const TraceOptions& options, const TraceInfo& info) {
  if (options.arenas.empty())
    return usage_error("no --arena given", "give sizes, 1MiB,16MiB, or shares, 0.01,0.1");
  std::vector<std::uint64_t> arenas;
  for (const std::string& text : options.arenas) {
    const Result<std::uint64_t> arena = arena_of(text, info, options.unit_size);
    if (!arena.ok()) return arena.status();
    arenas.push_back(*arena);
  }
  return arenas;
}

Result<int> run_info(const TraceOptions& options, const Global& global, Console& console) {
  const Result<TraceFile> file = load(options.words[1], options, console);
  if (!file.ok()) return file.status();
  const std::string json = trace_info_json(trace_info(*file, options.words[1]));
  std::cout << (global.json ? json : listed(json));
  return 0;
}

Result<TraceFormat> output_format(const TraceOptions& options) {
  const std::string& out = options.words[2];
  const auto format = options.to.empty() ? format_by_ending(out) : trace_format_named(options.to);
  if (format) return *format;
  return Status(Code::kUsage, out, "", "its ending tells no format",
                "end it in .atr, .csv or .bin, or say --to " + joined(trace_format_names()));
}

Result<int> run_convert(const TraceOptions& options, const Global& global, Console& console) {
  const std::string &in = options.words[1], &out = options.words[2];
  const Result<TraceFormat> format = output_format(options);
  if (!format.ok()) return format.status();
  std::error_code ignored;
  if (std::filesystem::equivalent(in, out, ignored))
    return Status(Code::kUsage, out, "", "is what is read", "write to another file");
  const Result<TraceFile> file = load(in, options, console);
  if (!file.ok()) return file.status();
  ATRIUM_RETURN_IF_ERROR(write_trace(file->trace, out, *format));
  const std::vector<std::string> lost = what_is_lost(file->trace, *format);
  if (!lost.empty()) console.say(out + " leaves out " + joined(lost));
  if (global.json)
    std::cout << conversion_json(out, to_string(*format), request_count(file->trace), lost);
  return 0;
}

bool wants_bound(const TraceOptions& options, const Trace& trace, Console& console) {
  if (options.bound != "auto") return options.bound == "on";
  if (request_count(trace) <= kBoundRequests) return true;
  console.say("no lower bound: more than " + std::to_string(kBoundRequests) +
              " requests take long; --bound on does it all the same");
  return false;
}

// Of one iteration, bytes alone: misses are bounded over the whole of a trace.
void find_bound(const Trace& trace, const TraceOptions& options, SimulationTable& table,
                std::size_t arena) {
  if (options.iteration == CountedPart::kAll)
    table.bounds[arena] = lower_bound_misses(trace, table.arenas[arena], options.unit_size);
  if (trace.pins && !options.unit_size)
    table.bytes[arena] = least_bytes(trace, table.arenas[arena], options.iteration);
}

// Every cell of the table and every bound on its own, over all threads.
SimulationTable simulate_all(const Trace& trace, const TraceOptions& options,
                             std::vector<std::uint64_t> arenas, bool bounded) {
  SimulationTable table;
  table.unit_size = options.unit_size;
  table.arenas = std::move(arenas);
  const std::size_t columns = table.arenas.size();
  table.rows.resize(options.policies.size() * columns);
  table.bounds.resize(columns);
  table.bytes.resize(columns);
  const std::size_t bounds = bounded ? columns : 0;
  const auto cell = [&](std::size_t i) {
    if (i < bounds) {  // first: they take longest
      find_bound(trace, options, table, i);
      return;
    }
    const std::size_t row = i - bounds;
    Result<Simulation> done =
        simulate(trace, options.policies[row / columns], table.arenas[row % columns],
                 options.unit_size, options.disk, options.iteration);
    table.rows[row] = std::move(done).value();  // the policies were parsed before
  };
  tbb::parallel_for(std::size_t{0}, bounds + table.rows.size(), cell, tbb::simple_partitioner());
  return table;
}

// The trace as it was recorded, or its gathers in the order asked for.
Result<Trace> in_order(Trace trace, const TraceOptions& options) {
  if (options.reorder.empty()) return trace;
  return reorder(trace, options.reorder, options.seed);
}

Status check_policies(const std::vector<std::string>& policies) {
  for (const std::string& policy : policies) {
    const Result<PolicyChoice> choice = parse_policy(policy);
    if (!choice.ok()) return choice.status();
  }
  return {};
}

Status unless_all_too_small(const SimulationTable& table, Console& console) {
  bool any = false;
  for (const Simulation& row : table.rows) any = any || row.feasible;
  const std::string least = format_size(table.rows.front().min_feasible_arena) + " (" +
                            std::to_string(table.rows.front().min_feasible_arena) + " bytes)";
  if (!any) return usage_error("what is pinned exceeds every arena", "give at least " + least);
  for (std::size_t a = 0; a < table.arenas.size(); ++a)
    if (!table.rows[a].feasible)
      console.error("an arena of " + std::to_string(table.arenas[a]) +
                    " is too small for what is pinned; give at least " + least);
  return {};
}

Result<int> run_simulate(const TraceOptions& options, const Global& global, Console& console) {
  ATRIUM_RETURN_IF_ERROR(check_policies(options.policies));
  Result<TraceFile> file = load(options.words[1], options, console);
  if (!file.ok()) return file.status();
  auto arenas = arenas_of(options, trace_info(*file, options.words[1]));
  if (!arenas.ok()) return arenas.status();
  const Result<Trace> trace = in_order(std::move(file->trace), options);
  if (!trace.ok()) return trace.status();
  const bool bounded = wants_bound(options, *trace, console);
  const SimulationTable table = simulate_all(*trace, options, std::move(*arenas), bounded);
  std::cout << (global.json ? simulation_json(table) : simulation_text(table));
  ATRIUM_RETURN_IF_ERROR(unless_all_too_small(table, console));
  return 0;
}

Result<std::string> only_policy(const TraceOptions& options) {
  if (options.policies.size() == 1) return options.policies.front();
  return usage_error("more than one --policy", "name one");
}

Result<int> run_curve(const TraceOptions& options, const Global& global, Console& console) {
  const Result<std::string> policy = only_policy(options);
  if (!policy.ok()) return policy.status();
  const Result<TraceFile> file = load(options.words[1], options, console);
  if (!file.ok()) return file.status();
  const bool exact = *policy == "lru" && options.sample == 1;
  const Result<MissCurve> curve =
      exact ? Result<MissCurve>(lru_curve(file->trace, options.unit_size))
            : sampled_curve(file->trace, *policy, options.sample, options.unit_size);
  if (!curve.ok()) return curve.status();
  ATRIUM_RETURN_IF_ERROR(
      write_output(options.output, {global.json ? curve_json(*curve) : curve_csv(*curve)}));
  return 0;
}

Result<ReplayOptions> replay_options(const TraceOptions& options, const TraceInfo& info) {
  if (options.store.empty()) return usage_error("no --store given", "name a directory to make");
  if (options.unit_size) return usage_error("--unit-size is of no store", "leave it out");
  const Result<std::string> policy = only_policy(options);
  if (!policy.ok()) return policy.status();
  const auto arenas = arenas_of(options, info);
  if (!arenas.ok()) return arenas.status();
  if (arenas->size() > 1) return usage_error("more than one --arena", "name one");
  return ReplayOptions{.directory = options.store,
                       .arena = arenas->front(),
                       .policy = *policy,
                       .io = options.io == "direct" ? Io::kDirect : Io::kMmap};
}

Result<int> run_replay(const TraceOptions& options, const Global& global, Console& console) {
  const Result<TraceFile> file = load(options.words[1], options, console);
  if (!file.ok()) return file.status();
  const auto replaying = replay_options(options, trace_info(*file, options.words[1]));
  if (!replaying.ok()) return replaying.status();
  const auto replayed = replay(file->trace, *replaying);
  if (!replayed.ok()) return replayed.status();
  const auto simulated = simulate(file->trace, replaying->policy, replaying->arena, false, options.disk);
  if (!simulated.ok()) return simulated.status();
  std::cout << (global.json ? replay_json(*simulated, *replayed)
                            : replay_text(*simulated, *replayed));
  const Words differ = differing_counts(*simulated, replayed->counts);
  if (differ.empty()) return 0;
  return Status(Code::kInternal, options.words[1], "",
                "the store and the simulation differ in " + joined(differ),
                "a larger arena has no evictions for fragmentation, of which there were " +
                    std::to_string(replayed->fragmentation_evictions));
}

struct Action {
  const char* name;
  std::size_t files;
  Result<int> (*run)(const TraceOptions&, const Global&, Console&);
};
constexpr Action kActions[] = {{"info", 1, run_info},
                               {"convert", 2, run_convert},
                               {"simulate", 1, run_simulate},
                               {"curve", 1, run_curve},
                               {"replay", 1, run_replay}};
constexpr std::size_t kMostWords = 3;

Result<int> run_action(const TraceOptions& options, const Global& global, Console& console) {
  const auto action = std::ranges::find(kActions, options.words[0], &Action::name);
  if (action == std::end(kActions))
    return usage_error("there is no 'trace " + options.words[0] + "'",
                       "it is info, convert, simulate, curve or replay");
  if (options.words.size() != action->files + 1)
    return usage_error("'trace " + options.words[0] + "' takes " +
                           (action->files == 1 ? "one file" : "two files: from and to"),
                       "see `atrium trace --help`");
  const int threads = global.threads > 0 ? global.threads : tbb::info::default_concurrency();
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                  static_cast<std::size_t>(threads));
  return action->run(options, global, console);
}

// "a,b,c" into its words; none of them empty.
OptionSet::Parser listing(Words& target) {
  return [&target](const std::string& text) -> Status {
    Words words;
    for (std::size_t at = 0; at <= text.size();) {
      const std::size_t comma = std::min(text.find(',', at), text.size());
      words.push_back(text.substr(at, comma - at));
      if (words.back().empty()) return usage_error("'" + text + "' has an empty part", "fill it");
      at = comma + 1;
    }
    target = std::move(words);
    return {};
  };
}

Status set_bandwidth(const std::string& text, double& bandwidth) {
  const Result<double> value = parse_bandwidth(text);
  if (!value.ok()) return value.status();
  if (*value <= 0) return usage_error("'" + text + "' moves nothing", "write 1GB/s");
  bandwidth = *value;
  return {};
}

Status set_sample(const std::string& text, double& sample) {
  const Result<double> value = parse_share(text);
  if (!value.ok()) return value.status();
  if (*value <= 0) return usage_error("'" + text + "' is nothing", "write 0.01, or 1 for all");
  sample = *value;
  return {};
}

void add_trace_options(OptionSet& set, TraceOptions& o) {
  set.argument("ACTION", "info TRACE, convert IN OUT, simulate TRACE, curve TRACE, replay TRACE", 2,
               kMostWords, o.words);
  set.text("columns", "of a csv: time=1,id=2,size=3,op=4, by number or by name", o.columns);
  set.choice("to", "convert: the format", trace_format_names(), o.to);
  set.custom("policy", "simulate: a list; curve, replay: one of " + joined(policy_names()),
             "NAME,...", listing(o.policies));
  set.custom("arena", "simulate, replay: sizes, or shares of the trace's bytes", "SIZE,...",
             listing(o.arenas));
  set.flag("unit-size", "simulate, curve: every record counts 1, arenas are numbers of records",
           o.unit_size);
  set.choice("reorder", "simulate: the gathers in another order", reorder_names(), o.reorder);
  set.count("seed", "simulate: of the random order", 0, UINT64_MAX,
            [&o](std::uint64_t seed) { o.seed = seed; });
  set.count("iteration", "simulate: count this one alone, after what came before it", 1,
            CountedPart::kAll - 1, [&o](std::uint64_t number) { o.iteration = number; });
  set.time("seconds-per-read", "simulate, replay: what a read or write costs before its first byte",
           o.disk.seconds_per_operation);
  set.custom("bandwidth", "simulate, replay: of the disk", "SIZE/s",
             [&o](const std::string& text) { return set_bandwidth(text, o.disk.bandwidth); });
  set.choice("bound", "simulate: the least misses of any policy; auto: unless the trace is long",
             {"auto", "on", "off"}, o.bound);
  set.custom("sample", "curve: share of the records to look at", "SHARE",
             [&o](const std::string& text) { return set_sample(text, o.sample); });
  set.output("curve: where it goes (stdout)", o.output);
  set.text("store", "replay: the directory to make", o.store);
  set.choice("io", "replay: how records come from disk", {"mmap", "direct"}, o.io);
}

}  // namespace

Command trace_command() {
  auto options = std::make_shared<TraceOptions>();
  Command command{"trace", "I/O traces and cache policies", {}, {}};
  add_trace_options(command.options, *options);
  command.run = [options](const Global& global, Console& console) {
    return run_action(*options, global, console);
  };
  return command;
}

}  // namespace atrium
