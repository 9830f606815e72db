// What `atrium trace` says: what a trace holds, and its tables for people and for programs. JSON is
// in report_json.h.
// Pure functions.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "pagestore/curve.h"
#include "pagestore/lower_bound.h"
#include "pagestore/replay.h"
#include "pagestore/simulate.h"
#include "pagestore/trace_file.h"

namespace atrium {

// Bytes are payload bytes.
struct TraceInfo {
  std::string file, format;
  bool pins = false, complete = true;
  std::uint64_t left_over = 0;
  std::uint64_t requests = 0, records = 0;
  std::uint64_t bytes = 0;         // of all requests
  std::uint64_t unique_bytes = 0;  // of all records, each at the largest it is
  std::uint64_t dirties = 0, creates = 0, gathers = 0, iterations = 0, checkpoints = 0;
  std::uint64_t grown_records = 0;
  std::uint64_t growth = 0;          // of their last sizes over their first ones
  std::uint64_t smallest_arena = 0;  // that will do
};
TraceInfo trace_info(const TraceFile& file, const std::string& name);

// Rows by policy and, within it, by arena.
struct SimulationTable {
  bool unit_size = false;  // arenas are numbers of records
  std::vector<Simulation> rows;
  std::vector<std::uint64_t> arenas;
  std::vector<std::optional<double>> bounds;  // an arena: the least misses that there can be
  std::vector<std::optional<LeastBytes>> bytes;  // likewise, that can be read
};
std::string simulation_text(const SimulationTable& table);

std::string curve_csv(const MissCurve& curve);

// The counts that replay and simulation must agree in, by their names.
struct NamedCount {
  const char* name;
  std::uint64_t Simulation::*count;
};
inline constexpr std::array<NamedCount, 11> kSimulationCounts{
    {{"requests", &Simulation::requests},
     {"hits", &Simulation::hits},
     {"misses", &Simulation::misses},
     {"miss_bytes", &Simulation::miss_bytes},
     {"evictions", &Simulation::evictions},
     {"writebacks", &Simulation::writebacks},
     {"writeback_bytes", &Simulation::writeback_bytes},
     {"checkpoint_writes", &Simulation::checkpoint_writes},
     {"checkpoint_bytes", &Simulation::checkpoint_bytes},
     {"final_flush", &Simulation::final_flush},
     {"final_flush_bytes", &Simulation::final_flush_bytes}}};

// The names of the counts that differ.
std::vector<std::string> differing_counts(const Simulation& a, const Simulation& b);
std::string replay_text(const Simulation& simulated, const Replay& replayed);

// Misses ÷ requests; 0 where there are none.
double miss_ratio(std::uint64_t misses, std::uint64_t requests);

}  // namespace atrium
