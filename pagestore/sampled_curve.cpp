// A miss curve from a sample: the records that a hash of their id draws, with all their requests,
// in arenas smaller by the same share, behave like the whole. [Waldspurger, Park, Garthwaite,
// Ahmad, FAST 15; Waldspurger, Saemundsson, Ahmad, Park, ATC 17]
//
// Counts are divided by the share of the records that was drawn, not by the share of the requests:
// a record requested all the time, drawn or not, then shifts hits and leaves misses nearly alone.
#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <utility>

#include "pagestore/curve.h"
#include "pagestore/record.h"
#include "pagestore/simulate.h"

namespace atrium {
namespace {

constexpr RecordNumber kNotDrawn = std::numeric_limits<RecordNumber>::max();

bool drawn(std::uint64_t id, double sample) {
  const std::uint64_t hash = hash_bytes(std::as_bytes(std::span(&id, 1)));
  return std::ldexp(static_cast<double>(hash), -64) < sample;
}

Trace draw(const Trace& trace, double sample) {
  Trace part;
  std::vector<RecordNumber> numbers(trace.ids.size(), kNotDrawn);
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (!drawn(trace.ids[i], sample)) continue;
    numbers[i] = static_cast<RecordNumber>(part.ids.size());
    part.ids.push_back(trace.ids[i]);
    part.sizes.push_back(trace.sizes[i]);
  }
  for (const TraceEvent& event : trace.events) {
    const RecordNumber number = numbers[event.record];
    if (number != kNotDrawn) part.events.push_back({event.op, number, event.bytes});
  }
  return part;
}

std::uint64_t scale_up(std::uint64_t count, double share) {
  return static_cast<std::uint64_t>(std::llround(static_cast<double>(count) / share));
}

CurvePoint scale_up(const CurvePoint& point, double share) {
  return {.arena = scale_up(point.arena, share),
          .misses = scale_up(point.misses, share),
          .miss_bytes = scale_up(point.miss_bytes, share),
          .writebacks = scale_up(point.writebacks, share),
          .writeback_bytes = scale_up(point.writeback_bytes, share),
          .final_flush = scale_up(point.final_flush, share)};
}

CurvePoint point_of(const Simulation& simulation) {
  return {.arena = simulation.arena,
          .misses = simulation.misses,
          .miss_bytes = simulation.miss_bytes,
          .writebacks = simulation.writebacks,
          .writeback_bytes = simulation.writeback_bytes,
          .final_flush = simulation.final_flush};
}

// The arena that holds all records, each as large as it ever gets.
std::uint64_t whole_set(const Trace& trace, bool unit_size) {
  std::vector<std::uint64_t> largest(trace.ids.size(), 0);
  for (const TraceEvent& event : trace.events) {
    const std::uint64_t charge = arena_charge(trace, event.bytes, unit_size);
    largest[event.record] = std::max(largest[event.record], charge);
  }
  std::uint64_t sum = 0;
  for (const std::uint64_t charge : largest) sum += charge;
  return sum;
}

// From `first` to `last`, growing; fewer where they would be the same.
std::vector<std::uint64_t> spread(std::uint64_t first, std::uint64_t last, int count) {
  std::vector<std::uint64_t> sizes{first};
  const double ratio =
      static_cast<double>(last) / static_cast<double>(std::max<std::uint64_t>(first, 1));
  for (int i = 1; i < count; ++i) {
    const double size = static_cast<double>(first) * std::pow(ratio, double(i) / (count - 1));
    const auto rounded = static_cast<std::uint64_t>(std::llround(size));
    if (rounded > sizes.back()) sizes.push_back(rounded);
  }
  return sizes;
}

// The policy's name in the sample: it looks ahead over as long a time, in fewer requests.
std::string name_in_sample(const PolicyChoice& choice, double share) {
  if (choice.foresight == 0 || choice.foresight == PolicyChoice::kAll) return choice.name;
  const double ahead = static_cast<double>(choice.foresight) * share;
  return choice.algorithm + ":" + std::to_string(std::max(1LL, std::llround(ahead)));
}

Result<MissCurve> simulated_curve(const Trace& trace, const std::string& policy, bool unit_size,
                                  int arenas) {
  MissCurve curve;
  curve.smallest_arena = smallest_feasible_arena(trace, unit_size);
  const std::uint64_t whole = whole_set(trace, unit_size);
  for (const std::uint64_t arena : spread(curve.smallest_arena, whole, arenas)) {
    const Result<Simulation> simulation = simulate(trace, policy, arena, unit_size);
    if (!simulation.ok()) return simulation.status();
    curve.points.push_back(point_of(*simulation));
  }
  return curve;
}

}  // namespace

Result<MissCurve> sampled_curve(const Trace& trace, const std::string& policy, double sample,
                                bool unit_size, int arenas) {
  const Result<PolicyChoice> choice = parse_policy(policy);
  if (!choice.ok()) return choice.status();
  if (trace.pins)
    return Status(Code::kUsage, "trace", "",
                  "a sample of a trace with pins means nothing: what is "
                  "pinned together is drawn apart",
                  "simulate it, or ask for the whole lru curve");
  if (!(sample > 0 && sample <= 1))
    return Status(Code::kUsage, "sample", std::to_string(sample), "not a share of the records",
                  "above 0 and at most 1");
  const Trace part = draw(trace, sample);
  if (part.ids.empty())
    return Status(Code::kUsage, "sample", std::to_string(sample),
                  "draws none of the " + std::to_string(trace.ids.size()) + " records",
                  "draw a larger share");
  const double share = static_cast<double>(part.ids.size()) / static_cast<double>(trace.ids.size());
  Result<MissCurve> curve =
      policy == "lru" ? Result(lru_curve(part, unit_size))
                      : simulated_curve(part, name_in_sample(*choice, share), unit_size, arenas);
  if (!curve.ok()) return curve.status();
  curve->policy = policy;
  curve->requests = request_count(trace);
  curve->smallest_arena = scale_up(curve->smallest_arena, share);
  curve->sample = share;
  for (CurvePoint& point : curve->points) point = scale_up(point, share);
  return curve;
}

}  // namespace atrium
