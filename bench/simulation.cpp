// How many requests a second do the simulator and the miss curve take? One core, the trace in
// memory; the best of several runs, since nothing but other work makes one slower.
//
//   simulation_bench TRACE [ROUNDS]
//
// Prints a table in Markdown, ratios to LRU's own simulation beside the rates.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <limits>

#include "engine/stopwatch.h"
#include "pagestore/curve.h"
#include "pagestore/policy.h"
#include "pagestore/simulate.h"
#include "pagestore/trace_file.h"

namespace atrium {
namespace {

constexpr int kRounds = 20;
constexpr std::uint64_t kArena = std::uint64_t{128} << 20;

double best_seconds(int rounds, const std::function<void()>& run) {
  double best = std::numeric_limits<double>::infinity();
  for (int i = 0; i < rounds; ++i) {
    const Stopwatch watch;
    run();
    best = std::min(best, watch.seconds());
  }
  return best;
}

int measure(const char* path, int rounds) {
  const Result<TraceFile> file = read_trace(path, "");
  if (!file.ok()) {
    std::fprintf(stderr, "simulation_bench: %s\n", file.status().message().c_str());
    return static_cast<int>(file.status().code());
  }
  const Trace& trace = file->trace;
  const double requests = static_cast<double>(request_count(trace));
  double lru = 0;
  std::printf("| of %.0f requests | million a second | as fast as LRU |\n|---|---|---|\n", requests);
  const auto row = [&](const std::string& name, double seconds) {
    if (lru == 0) lru = seconds;
    std::printf("| %s | %.1f | %.2f |\n", name.c_str(), requests / seconds / 1e6, lru / seconds);
  };
  for (std::string policy : policy_names()) {
    if (policy.ends_with(":W")) policy = policy.substr(0, policy.size() - 1) + "1000";
    row("simulate " + policy, best_seconds(rounds, [&] {
          if (!simulate(trace, policy, kArena).ok()) std::abort();
        }));
  }
  row("LRU curve, all arenas", best_seconds(rounds, [&] {
        if (lru_curve(trace).points.empty()) std::abort();
      }));
  return 0;
}

}  // namespace
}  // namespace atrium

int main(int argc, char** argv) {
  if (argc < 2) {
    std::fprintf(stderr, "simulation_bench TRACE [ROUNDS]\n");
    return 2;
  }
  return atrium::measure(argv[1], argc > 2 ? std::max(1, std::atoi(argv[2])) : atrium::kRounds);
}
