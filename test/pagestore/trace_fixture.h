// Traces for tests: small random ones of both kinds, and the cloudphysics trace of ../shared.
#pragma once

#include <cstdint>
#include <cstring>
#include <fstream>
#include <iterator>
#include <optional>
#include <random>
#include <string>
#include <unordered_map>
#include <vector>

#include "pagestore/record.h"
#include "pagestore/trace.h"

namespace atrium {

using Random = std::mt19937_64;

// requests for a few records that keep their sizes, 1 to 9 bytes; one in three puts.
inline Trace random_plain_trace(Random& random, std::size_t records, std::size_t requests) {
  Trace trace;
  std::vector<std::uint64_t> bytes;
  for (std::size_t i = 0; i < records; ++i) {
    trace.ids.push_back(100 + i);
    trace.sizes.push_back(0);
    bytes.push_back(1 + random() % 9);
  }
  for (std::size_t i = 0; i < requests; ++i) {
    const auto record = static_cast<RecordNumber>(random() % records);
    const TraceOp op = random() % 3 == 0 ? TraceOp::kPut : TraceOp::kGet;
    trace.events.push_back({op, record, bytes[record]});
  }
  return trace;
}

// Reads, nested ones too, growth, releases, creations, checkpoints and marks in any order that a
// store allows; some records may still be pinned at the end. Records are of 1 to some 10 granules.
inline Trace random_pinned_trace(Random& random, std::size_t records, std::size_t events) {
  Trace trace;
  trace.pins = true;
  std::vector<std::uint64_t> payload(records);
  std::vector<bool> exists(records);
  std::vector<RecordNumber> pins;  // once a pin
  for (std::size_t i = 0; i < records; ++i) {
    trace.ids.push_back(100 + i);
    exists[i] = i == 0 || random() % 3 != 0;
    payload[i] = exists[i] ? random() % (3 * kGranule) : 0;
    trace.sizes.push_back(payload[i]);
  }
  for (std::size_t i = 0; i < events; ++i) {
    const auto record = static_cast<RecordNumber>(random() % records);
    const std::size_t pin = pins.empty() ? 0 : random() % pins.size();
    const std::uint64_t choice = random() % 16;
    if (choice == 0) {
      trace.events.push_back({TraceOp::kCheckpoint});
    } else if (choice == 1) {
      trace.events.push_back({TraceOp::kGather, record, 0});
    } else if (!exists[record]) {
      exists[record] = true;
      payload[record] = random() % (3 * kGranule);
      trace.events.push_back({TraceOp::kCreate, record, payload[record]});
    } else if (choice < 7 && pins.size() < 4) {
      pins.push_back(record);
      trace.events.push_back({TraceOp::kRead, record, payload[record]});
    } else if (choice < 11 && !pins.empty()) {
      const RecordNumber dirtied = pins[pin];
      if (random() % 2 == 0) payload[dirtied] += random() % (2 * kGranule);
      trace.events.push_back({TraceOp::kDirty, dirtied, payload[dirtied]});
    } else if (!pins.empty()) {
      trace.events.push_back({TraceOp::kRelease, pins[pin], payload[pins[pin]]});
      pins.erase(pins.begin() + static_cast<std::ptrdiff_t>(pin));
    }
  }
  return trace;
}

// The requests of ../shared/traces/cloudphysics.oracleGeneral.bin; none where it is missing.
// 24 bytes a request: time (4), id (8), bytes (4), next (8). [facts: cache.md]
inline std::optional<Trace> cloudphysics_trace() {
  constexpr std::size_t kEntry = 24, kIdAt = 4, kBytesAt = 12;
  std::ifstream file(ATRIUM_SHARED_DIR "/traces/cloudphysics.oracleGeneral.bin", std::ios::binary);
  if (!file) return std::nullopt;
  const std::string content{std::istreambuf_iterator<char>(file), {}};
  Trace trace;
  std::unordered_map<std::uint64_t, RecordNumber> numbers;
  for (std::size_t at = 0; at + kEntry <= content.size(); at += kEntry) {
    std::uint64_t id = 0;
    std::uint32_t bytes = 0;
    std::memcpy(&id, &content[at + kIdAt], sizeof id);
    std::memcpy(&bytes, &content[at + kBytesAt], sizeof bytes);
    const auto [entry, seen_first] =
        numbers.try_emplace(id, static_cast<RecordNumber>(numbers.size()));
    if (seen_first) {
      trace.ids.push_back(id);
      trace.sizes.push_back(0);
    }
    trace.events.push_back({TraceOp::kGet, entry->second, bytes});
  }
  return trace;
}

}  // namespace atrium
