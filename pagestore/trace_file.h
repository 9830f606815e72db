// Trace files: a Trace from and to disk, and from one kind to the other (TRACE.md).
//
//   .atr    ours: pins, sizes, marks; written live by pagestore/trace_writer.h
//   oracle  libCacheSim's oracleGeneral, 24 bytes a request
//   csv     time,id,size,op, or columns named by the caller
//
// A file may hold anything: what is read is checked before it is believed, and an error names the
// file and the byte, chunk or line in it. A Trace that was read obeys these:
//  1. Record numbers are below ids.size(), and given out in the order in which records are first
//     heard of.
//  2. Of a trace with pins: only what is pinned is dirtied or released; a record is created before
//     anything else of it, or not at all.
//  3. No record is longer than kLargestTraceRecord.
// Pure functions but for the disk; safe from any thread.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "engine/status.h"
#include "pagestore/trace.h"

namespace atrium {

enum class TraceFormat { kAtr, kOracle, kCsv };

inline constexpr std::uint64_t kLargestTraceRecord = std::uint64_t{1} << 40;  // bytes

std::vector<std::string> trace_format_names();  // atr, oracle, csv
std::string to_string(TraceFormat format);
std::optional<TraceFormat> trace_format_named(const std::string& name);

// By what the file begins with, else by the ending .csv, else oracle if its size will do. kUsage
// else.
Result<TraceFormat> format_of(const std::string& path);

// For a file to be made: .atr; .csv; .bin, .oracle, .oracleGeneral. None for other endings.
std::optional<TraceFormat> format_by_ending(const std::string& path);

struct TraceFile {
  Trace trace;
  TraceFormat format = TraceFormat::kAtr;
  // An .atr file that was cut short, by a crash for one: `trace` is what its whole chunks hold.
  bool complete = true;
  std::uint64_t left_over = 0;  // bytes behind the last whole chunk
};

// columns: of a csv, "time=1,id=2,size=3,op=4": numbers from 1, or names in the first line; time
// and op may be missing. Empty: as the first line names them; given: the file is a csv. kUsage: no
// such file, or none of these formats; kStore: an .atr file that is damaged.
Result<TraceFile> read_trace(const std::string& path, const std::string& columns = "");

// In the place of what has that name. What the format has no room for is left out: what_is_lost
// says it. kUsage: a size beyond oracle's 32 bits.
Status write_trace(const Trace& trace, const std::string& path, TraceFormat format);
std::vector<std::string> what_is_lost(const Trace& trace, TraceFormat format);

// The requests alone: a read that its record is dirtied after, before the record's next read, is a
// kPut of the size it has then, any other a kGet. Times are numbers of gathers. Records are
// numbered anew.
Trace requests_only(const Trace& trace);

// Each request read and released at once, a kPut dirtied between. A record keeps the size it is
// first asked for with until a kPut changes it.
Trace with_pins(const Trace& trace);

}  // namespace atrium
