// Traces at random, sound ones, for tests that compare two ways to the same counts.
#pragma once

#include <random>
#include <vector>

#include "pagestore/trace.h"

namespace atrium {

// Without pins: gets and puts; a record's size changes now and then.
inline Trace random_requests(std::uint64_t seed, std::size_t events) {
  constexpr RecordNumber kRecords = 12;
  std::mt19937_64 draw(seed);
  Trace trace;
  std::vector<std::uint64_t> sizes;
  for (RecordNumber r = 0; r < kRecords; ++r) {
    trace.ids.push_back(1000 + r);
    trace.sizes.push_back(0);
    sizes.push_back(1 + draw() % 20);
  }
  for (std::size_t i = 0; i < events; ++i) {
    const auto r = static_cast<RecordNumber>(draw() % kRecords);
    if (draw() % 10 == 0) sizes[r] = 1 + draw() % 20;
    trace.events.push_back({draw() % 3 == 0 ? TraceOp::kPut : TraceOp::kGet, r, sizes[r]});
    trace.times.push_back(static_cast<std::uint32_t>(i));
  }
  return trace;
}

// With pins: gathers that read a few records, hold some of them, dirty their receiver with another
// size, release everything; records made between them; iterations and checkpoints.
inline Trace random_gathers(std::uint64_t seed, std::size_t gathers) {
  constexpr RecordNumber kRecords = 14, kAtFirst = 10;
  constexpr std::uint64_t kMostBytes = 5 * 4096;
  std::mt19937_64 draw(seed);
  Trace trace;
  trace.pins = true;
  std::vector<std::uint64_t> sizes;
  for (RecordNumber r = 0; r < kRecords; ++r) {
    trace.ids.push_back(500 - r);
    sizes.push_back(r < kAtFirst ? 1 + draw() % kMostBytes : 0);
  }
  trace.sizes = sizes;
  RecordNumber known = kAtFirst;
  const auto add = [&](TraceOp op, RecordNumber r) { trace.events.push_back({op, r, sizes[r]}); };
  const auto gather = [&](RecordNumber receiver) {
    add(TraceOp::kGather, receiver);
    add(TraceOp::kRead, receiver);
    for (std::uint64_t n = draw() % 4; n > 0; --n) {
      const auto source = static_cast<RecordNumber>(draw() % known);
      add(TraceOp::kRead, source);
      if (draw() % 3 == 0) {
        sizes[receiver] = 1 + draw() % kMostBytes;
        add(TraceOp::kDirty, receiver);
      }
      add(TraceOp::kRelease, source);
    }
    add(TraceOp::kRelease, receiver);
  };
  for (std::size_t i = 0; i < gathers; ++i) {
    if (i % 5 == 0) trace.events.push_back({TraceOp::kIteration, 0, i / 5});
    if (known < kRecords && draw() % 4 == 0) {
      sizes[known] = 1 + draw() % kMostBytes;
      add(TraceOp::kCreate, known++);
    }
    gather(static_cast<RecordNumber>(draw() % known));
    if (draw() % 6 == 0) trace.events.push_back({TraceOp::kCheckpoint});
  }
  return trace;
}

}  // namespace atrium
