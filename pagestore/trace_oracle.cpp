// oracleGeneral of libCacheSim: 24 bytes a request, little endian, packed.
#include <cstring>
#include <limits>

#include "pagestore/trace_codecs.h"

namespace atrium {
namespace {

#pragma pack(push, 1)
struct OracleRequest {
  std::uint32_t time = 0;
  std::uint64_t id = 0;
  std::uint32_t size = 0;
  std::int64_t next = 0;  // the number, from 1, of the id's next request; kNever
};
#pragma pack(pop)
static_assert(sizeof(OracleRequest) == 24);

constexpr std::int64_t kNever = -1;
constexpr std::uint64_t kLargestSize = std::numeric_limits<std::uint32_t>::max();
constexpr std::size_t kBatch = 4096;  // requests written at once

Status check_sizes(const Trace& trace, const std::string& path) {
  for (std::size_t i = 0; i < trace.events.size(); ++i)
    if (const std::uint64_t bytes = trace.events[i].bytes; bytes > kLargestSize)
      return Status(
          Code::kUsage, path, "request " + std::to_string(i + 1),
          "its record is " + std::to_string(bytes) + " bytes long; oracle has 32 bits for it",
          "write csv or .atr");
  return {};
}

}  // namespace

// `next` is not looked at: it may be anything.
Result<Trace> decode_oracle(std::span<const std::byte> bytes, const std::string& file) {
  if (bytes.empty() || bytes.size() % sizeof(OracleRequest) != 0)
    return Status(Code::kUsage, file, "byte " + std::to_string(bytes.size()),
                  bytes.empty() ? "it is empty" : "it ends within a request",
                  "an oracle trace has 24 bytes a request");
  Trace trace;
  RecordNumbers numbers(trace);
  for (; !bytes.empty(); bytes = bytes.subspan(sizeof(OracleRequest))) {
    OracleRequest request;
    std::memcpy(&request, bytes.data(), sizeof request);
    trace.events.push_back({TraceOp::kGet, numbers.of(request.id), request.size});
    trace.times.push_back(request.time);
  }
  return trace;
}

Status write_oracle(const Trace& trace, const std::string& path) {
  ATRIUM_RETURN_IF_ERROR(check_sizes(trace, path));
  auto file = AppendFile::create(path);
  if (!file.ok()) return file.status();
  const std::vector<std::uint64_t> next = next_requests(trace);
  std::vector<OracleRequest> batch;
  for (std::size_t i = 0; i < trace.events.size(); ++i) {
    const TraceEvent& event = trace.events[i];
    batch.push_back({.time = trace.times.empty() ? 0 : trace.times[i],
                     .id = trace.ids[event.record],
                     .size = static_cast<std::uint32_t>(event.bytes),
                     .next = next[i] == kNeverAgain ? kNever : std::int64_t(next[i] + 1)});
    if (batch.size() < kBatch) continue;
    ATRIUM_RETURN_IF_ERROR(file->append(std::as_bytes(std::span(batch))));
    batch.clear();
  }
  ATRIUM_RETURN_IF_ERROR(file->append(std::as_bytes(std::span(batch))));
  return file->close();
}

}  // namespace atrium
