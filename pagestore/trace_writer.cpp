#include "pagestore/trace_writer.h"

#include <cstring>
#include <span>

namespace atrium {

using namespace trace_format;

Result<std::unique_ptr<TraceWriter>> TraceWriter::create(const std::string& path, Disk& disk) {
  auto file = AppendFile::create(path, disk);
  if (!file.ok()) return file.status();
  const FileHeader header;
  ATRIUM_RETURN_IF_ERROR(file->append(std::as_bytes(std::span(&header, 1))));
  return std::unique_ptr<TraceWriter>(new TraceWriter(std::move(*file)));
}

TraceWriter::TraceWriter(AppendFile file) : file_(std::move(file)) {
  chunk_.reserve(sizeof(ChunkHeader) + kLargestChunk);
  chunk_.resize(sizeof(ChunkHeader));
}

void TraceWriter::read(RecordId id, std::uint64_t payload_bytes) {
  put_pending_read();
  const auto at = known_.find(id);
  if (at == known_.end()) return put_record(Kind::kRead, id, payload_bytes);
  ATRIUM_CHECK(at->second.size == payload_bytes);
  pending_read_ = at->second.number;
}

void TraceWriter::dirty(RecordId id, std::uint64_t payload_bytes) {
  put_pending_read();
  Known& record = known(id);
  begin_record(Kind::kDirty, record.number);
  put_varint(zigzag(payload_bytes - record.size));
  record.size = payload_bytes;
}

void TraceWriter::release(RecordId id) {
  const RecordNumber number = known(id).number;
  if (pending_read_ != number) {
    put_pending_read();
    return begin_record(Kind::kRelease, number);
  }
  pending_read_.reset();
  begin_record(Kind::kVisit, number);
  ++events_;
}

void TraceWriter::create_record(RecordId id, std::uint64_t payload_bytes) {
  ATRIUM_CHECK(!known_.contains(id));
  put_pending_read();
  put_record(Kind::kCreate, id, payload_bytes);
}

void TraceWriter::gather(RecordId id, std::uint64_t payload_bytes) {
  put_pending_read();
  put_record(Kind::kGather, id, payload_bytes);
}

void TraceWriter::iteration(std::uint64_t number) {
  put_pending_read();
  begin(Kind::kIteration, 0);
  put_varint(number);
}

void TraceWriter::checkpoint() {
  put_pending_read();
  begin(Kind::kCheckpoint, 0);
  flush();
}

Status TraceWriter::close() {
  put_pending_read();
  flush();
  write_chunk();  // the empty one at the end
  return file_.close();
}

TraceWriter::Known& TraceWriter::known(RecordId id) {
  const auto at = known_.find(id);
  ATRIUM_CHECK(at != known_.end());
  return at->second;
}

void TraceWriter::put_varint(std::uint64_t value) {
  for (; value > kVarintMask; value >>= kVarintBits)
    chunk_.push_back(static_cast<std::byte>(value | kVarintMore));
  chunk_.push_back(static_cast<std::byte>(value));
}

void TraceWriter::begin(Kind kind, std::uint64_t operand) {
  if (chunk_.size() + kLongestEvent > sizeof(ChunkHeader) + kLargestChunk) flush();
  put_varint(operand << kKindBits | static_cast<std::uint64_t>(kind));
  ++events_;
}

void TraceWriter::begin_record(Kind kind, RecordNumber number) {
  begin(kind, zigzag(std::uint64_t{number} - last_number_));
  last_number_ = number;
}

void TraceWriter::put_record(Kind kind, RecordId id, std::uint64_t payload_bytes) {
  const auto [at, is_new] =
      known_.try_emplace(id, static_cast<RecordNumber>(known_.size()), payload_bytes);
  begin_record(kind, at->second.number);
  if (!is_new) return;
  put_varint(zigzag(id.value - last_new_id_));
  put_varint(payload_bytes);
  last_new_id_ = id.value;
}

void TraceWriter::put_pending_read() {
  if (pending_read_) begin_record(Kind::kRead, *pending_read_);
  pending_read_.reset();
}

void TraceWriter::flush() {
  if (events_ > 0) write_chunk();
}

void TraceWriter::write_chunk() {
  ChunkHeader header{.length = static_cast<std::uint32_t>(chunk_.size() - sizeof(ChunkHeader)),
                     .events = events_,
                     .header_hash = last_hash_};
  std::memcpy(chunk_.data(), &header, sizeof header);
  constexpr std::size_t kHashed = offsetof(ChunkHeader, header_hash);
  header.payload_hash = hash_bytes(std::span(chunk_).subspan(kHashed));
  header.header_hash = hash_bytes(std::as_bytes(std::span(&header, 1)).first(kHashed));
  std::memcpy(chunk_.data(), &header, sizeof header);
  // An error is kept by the file, for status() and close().
  if (file_.status().ok()) static_cast<void>(file_.append(chunk_));
  last_hash_ = header.header_hash;
  events_ = 0;
  chunk_.resize(sizeof header);
}

}  // namespace atrium
