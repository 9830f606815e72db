#include "pagestore/trace_file.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <fstream>
#include <system_error>

#include "pagestore/trace_codecs.h"
#include "pagestore/trace_format.h"

namespace atrium {
namespace {

struct FormatName {
  TraceFormat format;
  const char* name;
};
constexpr FormatName kFormats[] = {
    {TraceFormat::kAtr, "atr"}, {TraceFormat::kOracle, "oracle"}, {TraceFormat::kCsv, "csv"}};

struct Ending {
  std::string_view text;
  TraceFormat format;
};
constexpr Ending kEndings[] = {{".atr", TraceFormat::kAtr},
                               {".csv", TraceFormat::kCsv},
                               {".bin", TraceFormat::kOracle},
                               {".oracle", TraceFormat::kOracle},
                               {".oracleGeneral", TraceFormat::kOracle}};

constexpr std::uint64_t kOracleBytes = 24;  // a request

Status unreadable(const std::string& path, const std::string& why) {
  return Status(Code::kUsage, path, "", why, "name a trace: .atr, oracle or csv");
}

Result<std::uint64_t> size_of(const std::string& path) {
  std::error_code error;
  if (!std::filesystem::is_regular_file(path, error))
    return unreadable(path, error ? error.message() : "it is no plain file");
  const std::uintmax_t size = std::filesystem::file_size(path, error);
  if (error) return unreadable(path, error.message());
  return static_cast<std::uint64_t>(size);
}

// So many bytes of its beginning.
Result<std::string> beginning(const std::string& path, std::uint64_t bytes) {
  std::ifstream in(path, std::ios::binary);
  std::string text(bytes, '\0');
  in.read(text.data(), static_cast<std::streamsize>(bytes));
  if (!in) return unreadable(path, "it could not be read");
  return text;
}

bool has_pins(TraceFormat format) { return format == TraceFormat::kAtr; }

Result<TraceFile> decode(const std::string& bytes, const std::string& path, TraceFormat format,
                         const std::string& columns) {
  const auto raw = std::as_bytes(std::span(bytes));
  if (format == TraceFormat::kAtr) return decode_atr(raw, path);
  Result<Trace> trace =
      format == TraceFormat::kOracle ? decode_oracle(raw, path) : decode_csv(bytes, path, columns);
  if (!trace.ok()) return trace.status();
  return TraceFile{.trace = std::move(*trace), .format = format};
}

Status encode(const Trace& trace, const std::string& path, TraceFormat format) {
  switch (format) {
    case TraceFormat::kAtr:
      return write_atr(trace, path);
    case TraceFormat::kOracle:
      return write_oracle(trace, path);
    case TraceFormat::kCsv:
      return write_csv(trace, path);
  }
  ATRIUM_CHECK(false);
}

std::size_t count(const Trace& trace, TraceOp op) {
  return static_cast<std::size_t>(std::ranges::count(trace.events, op, &TraceEvent::op));
}

// Gets whose size is not the one that their record has by then.
std::size_t resizing_gets(const Trace& trace) {
  std::vector<std::uint64_t> sizes(trace.ids.size());
  std::vector<bool> seen(trace.ids.size());
  std::size_t gets = 0;
  for (const TraceEvent& event : trace.events) {
    const bool other = seen[event.record] && sizes[event.record] != event.bytes;
    if (event.op == TraceOp::kGet && other) ++gets;
    if (event.op == TraceOp::kPut || !seen[event.record]) sizes[event.record] = event.bytes;
    seen[event.record] = true;
  }
  return gets;
}

void add_loss(std::vector<std::string>& lost, std::size_t number, const std::string& what) {
  if (number > 0) lost.push_back(std::to_string(number) + " " + what);
}

}  // namespace

std::vector<std::string> trace_format_names() {
  std::vector<std::string> names;
  for (const FormatName& f : kFormats) names.push_back(f.name);
  return names;
}

std::string to_string(TraceFormat format) {
  return std::ranges::find(kFormats, format, &FormatName::format)->name;
}

std::optional<TraceFormat> trace_format_named(const std::string& name) {
  for (const FormatName& f : kFormats)
    if (f.name == name) return f.format;
  return std::nullopt;
}

Result<TraceFormat> format_of(const std::string& path) {
  const Result<std::uint64_t> size = size_of(path);
  if (!size.ok()) return size.status();
  const Result<std::string> head =
      beginning(path, std::min<std::uint64_t>(*size, trace_format::kMagic.size()));
  if (!head.ok()) return head.status();
  if (*head == trace_format::kMagic) return TraceFormat::kAtr;
  const auto ending = format_by_ending(path);
  if (ending == TraceFormat::kAtr)
    return Status(Code::kStore, path, "byte 0", "it does not begin with ATRTRACE",
                  "restore it from a copy, or record it again");
  if (ending == TraceFormat::kCsv || ending == TraceFormat::kOracle) return *ending;
  if (*size > 0 && *size % kOracleBytes == 0) return TraceFormat::kOracle;
  return unreadable(path,
                    "it is no trace: it does not begin with ATRTRACE, does not end in .csv, "
                    "and is not in pieces of 24 bytes");
}

std::optional<TraceFormat> format_by_ending(const std::string& path) {
  for (const Ending& e : kEndings)
    if (path.ends_with(e.text)) return e.format;
  return std::nullopt;
}

Result<TraceFile> read_trace(const std::string& path, const std::string& columns) {
  const Result<TraceFormat> format =
      columns.empty() ? format_of(path) : Result<TraceFormat>(TraceFormat::kCsv);
  if (!format.ok()) return format.status();
  const Result<std::uint64_t> size = size_of(path);
  if (!size.ok()) return size.status();
  const Result<std::string> bytes = beginning(path, *size);
  if (!bytes.ok()) return bytes.status();
  return decode(*bytes, path, *format, columns);
}

Status write_trace(const Trace& trace, const std::string& path, TraceFormat format) {
  if (trace.pins == has_pins(format)) return encode(trace, path, format);
  return encode(trace.pins ? requests_only(trace) : with_pins(trace), path, format);
}

std::vector<std::string> what_is_lost(const Trace& trace, TraceFormat format) {
  std::vector<std::string> lost;
  if (trace.pins == has_pins(format) && format != TraceFormat::kOracle) return lost;
  if (!trace.pins && format == TraceFormat::kAtr) {
    lost.push_back("the times");
    add_loss(lost, resizing_gets(trace), "gets with another size than their record's");
    return lost;
  }
  if (trace.pins) {
    lost.push_back("how long records are pinned");
    add_loss(lost, count(trace, TraceOp::kGather), "receivers of gathers");
    add_loss(lost, count(trace, TraceOp::kCreate), "records made");
    add_loss(lost, count(trace, TraceOp::kIteration), "iteration marks");
    add_loss(lost, count(trace, TraceOp::kCheckpoint), "checkpoints");
  }
  const std::size_t changes = count(trace, TraceOp::kPut) + count(trace, TraceOp::kDirty);
  if (format == TraceFormat::kOracle) add_loss(lost, changes, "changes of records");
  return lost;
}

Trace requests_only(const Trace& trace) {
  Trace requests;
  RecordNumbers numbers(requests);
  std::vector<std::uint64_t> now = trace.sizes;
  std::vector<std::size_t> last(trace.ids.size());  // the record's last request
  std::uint32_t gathers = 0;
  for (const TraceEvent& event : trace.events) {
    const RecordNumber record = event.record;
    if (event.op == TraceOp::kGather) ++gathers;
    if (event.op == TraceOp::kCreate || event.op == TraceOp::kDirty) now[record] = event.bytes;
    if (event.op == TraceOp::kDirty) {
      requests.events[last[record]].op = TraceOp::kPut;
      requests.events[last[record]].bytes = event.bytes;
    }
    if (event.op != TraceOp::kRead) continue;
    last[record] = requests.events.size();
    requests.events.push_back({TraceOp::kGet, numbers.of(trace.ids[record]), now[record]});
    requests.times.push_back(gathers);
  }
  return requests;
}

Trace with_pins(const Trace& trace) {
  Trace pinned;
  pinned.pins = true;
  pinned.ids = trace.ids;
  pinned.sizes.resize(trace.ids.size());
  std::vector<bool> seen(trace.ids.size());
  std::vector<std::uint64_t> now(trace.ids.size());
  for (const TraceEvent& event : trace.events) {
    const RecordNumber record = event.record;
    if (!seen[record]) pinned.sizes[record] = now[record] = event.bytes;
    seen[record] = true;
    pinned.events.push_back({TraceOp::kRead, record, now[record]});
    if (event.op == TraceOp::kPut) {
      now[record] = event.bytes;
      pinned.events.push_back({TraceOp::kDirty, record, now[record]});
    }
    pinned.events.push_back({TraceOp::kRelease, record, now[record]});
  }
  return pinned;
}

}  // namespace atrium
