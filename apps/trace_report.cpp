#include "apps/trace_report.h"

#include <algorithm>
#include <cstdio>
#include <iomanip>
#include <sstream>

#include "engine/quantity.h"

namespace atrium {
namespace {

constexpr int kName = 16, kColumn = 15;

// Sizes of a record as a trace goes on.
struct Sizes {
  std::uint64_t first = 0, now = 0, largest = 0;
  bool known = false;
  void become(std::uint64_t bytes) {
    if (!known) first = bytes;
    known = true;
    now = bytes;
    largest = std::max(largest, bytes);
  }
};

// What an event says of its record's size; a mark says nothing.
void follow(std::vector<Sizes>& sizes, const Trace& trace, const TraceEvent& event) {
  switch (event.op) {
    case TraceOp::kGet:
    case TraceOp::kPut:
    case TraceOp::kDirty:
    case TraceOp::kCreate:
      return sizes[event.record].become(event.bytes);
    case TraceOp::kRead:
    case TraceOp::kGather:
      if (!sizes[event.record].known) sizes[event.record].become(trace.sizes[event.record]);
      return;
    case TraceOp::kRelease:
    case TraceOp::kIteration:
    case TraceOp::kCheckpoint:
      return;
  }
}

void count(TraceInfo& info, const TraceEvent& event) {
  const TraceOp op = event.op;
  if (op == TraceOp::kDirty || op == TraceOp::kPut) ++info.dirties;
  if (op == TraceOp::kCreate) ++info.creates;
  if (op == TraceOp::kGather) ++info.gathers;
  if (op == TraceOp::kIteration && event.bytes != kBetweenIterations) ++info.iterations;
  if (op == TraceOp::kCheckpoint) ++info.checkpoints;
}

std::string arena_text(std::uint64_t arena, bool unit_size) {
  return unit_size ? std::to_string(arena) : format_size(arena);
}

std::string above_bound(const Simulation& row, const std::optional<double>& bound) {
  if (!bound) return "-";
  if (*bound <= 0) return row.misses == 0 ? "0%" : "-";
  return format_share(static_cast<double>(row.misses) / *bound - 1);
}

void add_row(std::ostream& out, const Simulation& row, const std::string& arena,
             const std::optional<double>& bound) {
  out << std::left << std::setw(kName) << row.policy << std::right << std::setw(kColumn) << arena;
  if (!row.feasible) {
    out << "  too small: " << format_size(row.min_feasible_arena) << " will do\n";
    return;
  }
  out << std::setw(kColumn) << row.misses << std::setw(kColumn)
      << format_share(miss_ratio(row.misses, row.requests)) << std::setw(kColumn)
      << above_bound(row, bound) << std::setw(kColumn) << row.evictions << std::setw(kColumn)
      << row.writebacks << std::setw(kColumn) << row.final_flush << std::setw(kColumn)
      << format_time(row.seconds) << '\n';
}

}  // namespace

double miss_ratio(std::uint64_t misses, std::uint64_t requests) {
  return requests == 0 ? 0 : static_cast<double>(misses) / static_cast<double>(requests);
}

TraceInfo trace_info(const TraceFile& file, const std::string& name) {
  const Trace& trace = file.trace;
  TraceInfo info{.file = name,
                 .format = to_string(file.format),
                 .pins = trace.pins,
                 .complete = file.complete,
                 .left_over = file.left_over,
                 .requests = request_count(trace),
                 .records = trace.ids.size()};
  info.smallest_arena = smallest_feasible_arena(trace, false);
  std::vector<Sizes> sizes(trace.ids.size());
  for (const TraceEvent& event : trace.events) {
    count(info, event);
    follow(sizes, trace, event);
    if (is_request(event.op)) info.bytes += sizes[event.record].now;
  }
  for (const Sizes& record : sizes) {
    info.unique_bytes += record.largest;
    if (record.now <= record.first) continue;
    ++info.grown_records;
    info.growth += record.now - record.first;
  }
  return info;
}

std::string simulation_text(const SimulationTable& table) {
  std::ostringstream out;
  out << std::left << std::setw(kName) << "policy" << std::right << std::setw(kColumn) << "arena"
      << std::setw(kColumn) << "misses" << std::setw(kColumn) << "miss ratio" << std::setw(kColumn)
      << "over the best" << std::setw(kColumn) << "evictions" << std::setw(kColumn) << "write-backs"
      << std::setw(kColumn) << "final flush" << std::setw(kColumn) << "disk time" << '\n';
  for (std::size_t i = 0; i < table.rows.size(); ++i) {
    const std::size_t arena = i % table.arenas.size();
    add_row(out, table.rows[i], arena_text(table.arenas[arena], table.unit_size),
            table.bounds[arena]);
  }
  for (std::size_t a = 0; a < table.arenas.size(); ++a)
    if (table.bounds[a])
      out << "no policy has fewer misses than " << std::fixed << std::setprecision(1)
          << *table.bounds[a] << " in " << arena_text(table.arenas[a], table.unit_size) << '\n';
  for (std::size_t a = 0; a < table.arenas.size(); ++a)
    if (table.bytes[a])
      out << "no policy reads fewer bytes than " << std::fixed << std::setprecision(0)
          << table.bytes[a]->in_this_order << " in " << arena_text(table.arenas[a], false)
          << ", in any order of the gathers " << table.bytes[a]->in_any_order << '\n';
  return out.str();
}

std::string curve_csv(const MissCurve& curve) {
  std::ostringstream out;
  out.precision(10);
  out << "arena,misses,miss_ratio,miss_bytes,writebacks,writeback_bytes,final_flush\n";
  for (const CurvePoint& p : curve.points)
    out << p.arena << ',' << p.misses << ',' << miss_ratio(p.misses, curve.requests) << ','
        << p.miss_bytes << ',' << p.writebacks << ',' << p.writeback_bytes << ',' << p.final_flush
        << '\n';
  return out.str();
}

std::vector<std::string> differing_counts(const Simulation& a, const Simulation& b) {
  std::vector<std::string> names;
  for (const NamedCount& c : kSimulationCounts)
    if (a.*c.count != b.*c.count) names.push_back(c.name);
  return names;
}

std::string replay_text(const Simulation& simulated, const Replay& replayed) {
  constexpr int kCount = 20;
  std::ostringstream out;
  const auto row = [&](const std::string& name, const std::string& a, const std::string& b) {
    out << std::left << std::setw(kCount) << name << std::right << std::setw(kName) << a
        << std::setw(kName) << b << '\n';
  };
  row("", "simulated", "replayed");
  for (const NamedCount& c : kSimulationCounts)
    row(c.name, std::to_string(simulated.*c.count), std::to_string(replayed.counts.*c.count));
  row("fragmentation", "", std::to_string(replayed.fragmentation_evictions));
  row("time", format_time(simulated.seconds), format_time(replayed.counts.seconds));
  row("of it on disk", "", format_time(replayed.io_seconds));
  return out.str();
}

}  // namespace atrium
