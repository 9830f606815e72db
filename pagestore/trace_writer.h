// TraceWriter: what is asked of a live store, into an .atr file as it happens (TRACE.md).
//
// Invariants:
//  1. Records are numbered from 0 in the order in which they are first heard of; their size then is
//     what they have when the trace begins, or come into being with.
//  2. A failed write never disturbs the caller: the error is kept, what follows is dropped, and
//     status() and close() return it.
//  3. What was told before a checkpoint is in the file after it; a file cut short later is read up
//     to its last whole chunk.
// Begin it while nothing is pinned. Sizes are payload bytes, and change by `dirty` alone.
// Not thread safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <unordered_map>
#include <vector>

#include "engine/status.h"
#include "pagestore/append_file.h"
#include "pagestore/disk.h"
#include "pagestore/policy.h"
#include "pagestore/record.h"
#include "pagestore/trace_format.h"

namespace atrium {

class TraceWriter {
 public:
  // In the place of what has that name.
  static Result<std::unique_ptr<TraceWriter>> create(const std::string& path,
                                                     Disk& disk = machine_disk(Io::kMmap));

  void read(RecordId id, std::uint64_t payload_bytes);   // pinned once more
  void dirty(RecordId id, std::uint64_t payload_bytes);  // so long from here on; it is pinned
  void release(RecordId id);                             // one pin less
  void create_record(RecordId id, std::uint64_t payload_bytes);
  void gather(RecordId id, std::uint64_t payload_bytes);  // the gather to it begins
  void iteration(std::uint64_t number);
  void checkpoint();

  const Status& status() const { return file_.status(); }
  std::uint64_t file_bytes() const { return file_.size(); }
  // Marks the file as whole; durable on return. Nothing may be told after it.
  Status close();

 private:
  using Kind = trace_format::Kind;
  struct Known {
    RecordNumber number;
    std::uint64_t size;
  };

  explicit TraceWriter(AppendFile file);
  Known& known(RecordId id);
  void put_varint(std::uint64_t value);
  void begin(Kind kind, std::uint64_t operand);
  void begin_record(Kind kind, RecordNumber number);
  // The record's event; its id and size behind it if it was not heard of before.
  void put_record(Kind kind, RecordId id, std::uint64_t payload_bytes);
  void put_pending_read();
  void flush();
  void write_chunk();

  AppendFile file_;
  std::vector<std::byte> chunk_;  // a header's room, then the payload so far
  std::uint32_t events_ = 0;      // of the chunk
  std::uint64_t last_hash_ = 0;   // of the last chunk's header
  std::unordered_map<RecordId, Known> known_;
  RecordNumber last_number_ = 0;
  std::uint64_t last_new_id_ = 0;
  // A read of a known record waits for the next event, to be one with its release.
  std::optional<RecordNumber> pending_read_;
};

}  // namespace atrium
