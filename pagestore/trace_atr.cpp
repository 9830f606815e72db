// .atr: ours, byte by byte as TRACE.md has it.
#include <algorithm>
#include <cstring>
#include <limits>
#include <unordered_set>

#include "pagestore/record.h"
#include "pagestore/trace_codecs.h"
#include "pagestore/trace_format.h"
#include "pagestore/trace_writer.h"

namespace atrium {
namespace {

using namespace trace_format;

constexpr const char* kRemedy = "restore it from a copy, or record it again";

// Adds the events of one payload after the other to a trace. What it refuses it says in one clause.
class EventReader {
 public:
  explicit EventReader(TraceFile& file) : trace_(file.trace) {}

  std::string take(std::span<const std::byte> payload) {
    payload_ = payload;
    at_ = 0;
    std::string fault;
    while (at_ < payload_.size() && fault.empty()) fault = take_event();
    return fault;
  }

  std::size_t at() const { return at_; }  // bytes of the payload that were looked at

 private:
  bool varint(std::uint64_t& value) {
    value = 0;
    for (int shift = 0; at_ < payload_.size(); shift += kVarintBits) {
      const auto byte = static_cast<std::uint64_t>(payload_[at_++]);
      const std::uint64_t bits = byte & kVarintMask;
      if (shift >= std::numeric_limits<std::uint64_t>::digits || bits << shift >> shift != bits)
        return false;
      value |= bits << shift;
      if ((byte & kVarintMore) == 0) return true;
    }
    return false;
  }

  std::string take_event() {
    std::uint64_t head = 0;
    if (!varint(head)) return "a number there has no end, or more than 64 bits";
    const Kind kind = static_cast<Kind>(head & kKindMask);
    const std::uint64_t operand = head >> kKindBits;
    if (is_mark(kind)) return take_mark(kind, operand);
    const std::uint64_t number = last_ + unzigzag(operand);
    if (number > trace_.ids.size()) return "it names a record that was not heard of before";
    const bool is_new = number == trace_.ids.size();
    if (is_new)
      if (const std::string fault = take_new(kind); !fault.empty()) return fault;
    last_ = number;
    return take_record(kind, static_cast<RecordNumber>(number), is_new);
  }

  std::string take_mark(Kind kind, std::uint64_t operand) {
    if (operand != 0) return "a mark there names a record";
    std::uint64_t number = 0;
    if (kind == Kind::kIteration && !varint(number)) return "an iteration there has no number";
    trace_.events.push_back(
        {kind == Kind::kIteration ? TraceOp::kIteration : TraceOp::kCheckpoint, 0, number});
    return "";
  }

  // Id and size of a record that was not heard of before.
  std::string take_new(Kind kind) {
    if (trace_.ids.size() > std::numeric_limits<RecordNumber>::max())
      return "more records than have numbers";
    std::uint64_t id = 0, size = 0;
    if (!varint(id) || !varint(size)) return "a new record there has no id or no size";
    if (size > kLargestTraceRecord) return "a record there is larger than any can be";
    last_id_ += unzigzag(id);
    if (!ids_.insert(last_id_).second) return "a new record there has the id of another";
    trace_.ids.push_back(last_id_);
    trace_.sizes.push_back(kind == Kind::kCreate ? 0 : size);
    now_.push_back({size, 0});
    return "";
  }

  std::string take_record(Kind kind, RecordNumber number, bool is_new) {
    State& record = now_[number];
    switch (kind) {
      case Kind::kRead:
        ++record.pins;
        add(TraceOp::kRead, number);
        return "";
      case Kind::kVisit:
        add(TraceOp::kRead, number);
        add(TraceOp::kRelease, number);
        return "";
      case Kind::kDirty:
        return take_dirty(number);
      case Kind::kRelease:
        if (record.pins == 0) return "it releases a record that is not pinned";
        --record.pins;
        add(TraceOp::kRelease, number);
        return "";
      case Kind::kCreate:
        if (!is_new) return "it creates a record that is there already";
        add(TraceOp::kCreate, number);
        return "";
      default:  // kGather; marks do not come here
        add(TraceOp::kGather, number);
        return "";
    }
  }

  std::string take_dirty(RecordNumber number) {
    State& record = now_[number];
    std::uint64_t growth = 0;
    if (record.pins == 0) return "it dirties a record that is not pinned";
    if (!varint(growth)) return "a dirtied record there has no size";
    record.size += unzigzag(growth);
    if (record.size > kLargestTraceRecord) return "a record there grows beyond what any can be";
    add(TraceOp::kDirty, number);
    return "";
  }

  void add(TraceOp op, RecordNumber number) {
    trace_.events.push_back({op, number, now_[number].size});
  }

  struct State {
    std::uint64_t size, pins;
  };

  Trace& trace_;
  std::span<const std::byte> payload_;
  std::size_t at_ = 0;
  std::vector<State> now_;
  std::uint64_t last_ = 0, last_id_ = 0;
  std::unordered_set<std::uint64_t> ids_;
};

class ChunkReader {
 public:
  ChunkReader(std::span<const std::byte> bytes, const std::string& file)
      : bytes_(bytes), name_(file), events_(file_) {
    file_.complete = false;
  }

  Result<TraceFile> read() {
    ATRIUM_RETURN_IF_ERROR(check_file_header());
    file_.trace.pins = true;
    while (!file_.complete && whole_chunk_ahead()) ATRIUM_RETURN_IF_ERROR(take_chunk());
    if (!status_.ok()) return status_;
    file_.left_over = bytes_.size() - at_;
    if (file_.complete && file_.left_over > 0)
      return Status(Code::kStore, name_, "byte " + std::to_string(at_),
                    std::to_string(file_.left_over) + " bytes lie behind its end", kRemedy);
    return std::move(file_);
  }

 private:
  Status check_file_header() {
    FileHeader header;
    if (bytes_.size() < sizeof header)
      return Status(Code::kStore, name_, "", "it ends within its header", kRemedy);
    std::memcpy(&header, bytes_.data(), sizeof header);
    const FileHeader expected;
    if (header.magic != expected.magic || header.zero != 0)
      return Status(Code::kStore, name_, "byte 0", "its header is damaged", kRemedy);
    if (header.format != kFormat)
      return Status(Code::kStore, name_, "byte 8", "it has format " + std::to_string(header.format),
                    "read it with the version that wrote it; this one knows format " +
                        std::to_string(kFormat));
    at_ = sizeof header;
    return {};
  }

  // False at the end of what is whole; a header that is there must be sound.
  bool whole_chunk_ahead() {
    if (bytes_.size() - at_ < sizeof header_) return false;
    std::memcpy(&header_, bytes_.data() + at_, sizeof header_);
    const auto hashed = bytes_.subspan(at_, offsetof(ChunkHeader, header_hash));
    if (hash_bytes(hashed) != header_.header_hash)
      status_ = damage(at_, "its header does not match its hash");
    else if (header_.length > kLargestChunk)
      status_ = damage(at_, "it is longer than a chunk can be");
    return status_.ok() && bytes_.size() - at_ - sizeof header_ >= header_.length;
  }

  Status take_chunk() {
    const std::size_t payload_at = at_ + sizeof header_;
    const auto payload = bytes_.subspan(payload_at, header_.length);
    if (payload_hash(payload) != header_.payload_hash)
      return damage(at_, "its events do not match their hash");
    const std::size_t before = file_.trace.events.size();
    const std::string fault = events_.take(payload);
    if (!fault.empty()) return damage(payload_at + events_.at(), fault);
    if (file_.trace.events.size() - before != header_.events)
      return damage(at_, "it has another number of events than it says");
    file_.complete = header_.length == 0;
    last_hash_ = header_.header_hash;
    at_ = payload_at + header_.length;
    ++chunk_;
    return {};
  }

  std::uint64_t payload_hash(std::span<const std::byte> payload) {
    scratch_.resize(sizeof last_hash_ + payload.size());
    std::memcpy(scratch_.data(), &last_hash_, sizeof last_hash_);
    std::ranges::copy(payload, scratch_.begin() + sizeof last_hash_);
    return hash_bytes(scratch_);
  }

  Status damage(std::size_t byte, const std::string& cause) const {
    return Status(Code::kStore, name_,
                  "chunk " + std::to_string(chunk_) + ", byte " + std::to_string(byte), cause,
                  kRemedy);
  }

  std::span<const std::byte> bytes_;
  std::string name_;
  TraceFile file_;
  EventReader events_;
  ChunkHeader header_;
  Status status_;  // of the header ahead
  std::size_t at_ = 0, chunk_ = 0;
  std::uint64_t last_hash_ = 0;
  std::vector<std::byte> scratch_;
};

// size: of the event's record after it.
void tell_of_record(TraceWriter& writer, TraceOp op, RecordId id, std::uint64_t size) {
  switch (op) {
    case TraceOp::kRead:
      return writer.read(id, size);
    case TraceOp::kDirty:
      return writer.dirty(id, size);
    case TraceOp::kRelease:
      return writer.release(id);
    case TraceOp::kCreate:
      return writer.create_record(id, size);
    case TraceOp::kGather:
      return writer.gather(id, size);
    default:
      ATRIUM_CHECK(false);  // of a trace without pins
  }
}

}  // namespace

Result<TraceFile> decode_atr(std::span<const std::byte> bytes, const std::string& file) {
  return ChunkReader(bytes, file).read();
}

Status write_atr(const Trace& trace, const std::string& path) {
  const auto writer = TraceWriter::create(path);
  if (!writer.ok()) return writer.status();
  std::vector<std::uint64_t> now = trace.sizes;
  for (const TraceEvent& event : trace.events) {
    if (event.op == TraceOp::kIteration) {
      (*writer)->iteration(event.bytes);
      continue;
    }
    if (event.op == TraceOp::kCheckpoint) {
      (*writer)->checkpoint();
      continue;
    }
    std::uint64_t& size = now[event.record];
    if (event.op == TraceOp::kDirty || event.op == TraceOp::kCreate) size = event.bytes;
    tell_of_record(**writer, event.op, RecordId{trace.ids[event.record]}, size);
  }
  return (*writer)->close();
}

}  // namespace atrium
