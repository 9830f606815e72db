// csv: a request a line, commas between the columns; no quotes.
#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <cmath>
#include <limits>

#include "pagestore/record.h"
#include "pagestore/trace_codecs.h"

namespace atrium {
namespace {

enum Column : std::size_t { kTime, kId, kSize, kOp, kColumns };
constexpr std::array<std::string_view, kColumns> kNames{"time", "id", "size", "op"};
constexpr const char* kHeader = "time,id,size,op\n";
constexpr const char* kColumnsRemedy =
    "name the columns: --columns time=1,id=2,size=3,op=4 by their numbers from 1, or by the names "
    "in the first line";
constexpr std::size_t kBatch = 65536;  // bytes written at once

// What others call it: libCacheSim's words, and the SCSI codes of block traces. [SBC-3]
constexpr std::string_view kGets[] = {"get", "gets", "read", "r", "08", "28", "a8", "88"};
constexpr std::string_view kPuts[] = {"put",    "set",     "write", "w",      "add",  "replace",
                                      "append", "prepend", "cas",   "update", "incr", "decr",
                                      "0a",     "2a",      "aa",    "8a"};

using Fields = std::vector<std::string_view>;
using Places = std::array<std::optional<std::size_t>, kColumns>;  // of the columns, from 0

std::string_view trimmed(std::string_view s) {
  constexpr std::string_view kBlanks = " \t\r";
  const std::size_t first = s.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return s.substr(first, s.find_last_not_of(kBlanks) - first + 1);
}

void split(std::string_view line, Fields& fields) {
  fields.clear();
  while (true) {
    const std::size_t comma = line.find(',');
    fields.push_back(trimmed(line.substr(0, comma)));
    if (comma == std::string_view::npos) return;
    line.remove_prefix(comma + 1);
  }
}

std::string lower(std::string_view s) {
  std::string text(s);
  for (char& c : text) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return text;
}

template <class T>
bool parse_whole(std::string_view field, T& value) {
  const char* end = field.data() + field.size();
  const auto [rest, error] = std::from_chars(field.data(), end, value);
  return error == std::errc() && rest == end;
}

// Seconds from 0 up, fractions cut off.
bool parse_time(std::string_view field, std::uint32_t& seconds) {
  double value = 0;
  if (!parse_whole(field, value)) return false;
  if (!(value >= 0 && value < double(std::numeric_limits<std::uint32_t>::max()) + 1)) return false;
  seconds = static_cast<std::uint32_t>(value);
  return true;
}

// A number as it is written without need is that number; any other text is its hash.
std::uint64_t id_of(std::string_view field) {
  std::uint64_t number = 0;
  const bool plain = field.front() != '0' || field.size() == 1;
  if (plain && parse_whole(field, number)) return number;
  return hash_bytes(std::as_bytes(std::span(field)));
}

std::optional<TraceOp> op_of(std::string_view field) {
  const std::string word = lower(field);
  if (std::ranges::find(kGets, word) != std::end(kGets)) return TraceOp::kGet;
  if (std::ranges::find(kPuts, word) != std::end(kPuts)) return TraceOp::kPut;
  return std::nullopt;
}

// Where the columns are: from the caller's words and the first line.
class Layout {
 public:
  explicit Layout(const std::string& file) : file_(file) {}

  // True where the first line is a header.
  Result<bool> find(const std::string& columns, const Fields& first) {
    if (columns.empty()) return find_by_our_names(first);
    ATRIUM_RETURN_IF_ERROR(find_as_told(columns, first));
    std::uint64_t size = 0;
    const std::size_t at = *places_[kSize];
    return named_ || at >= first.size() || !parse_whole(first[at], size);
  }

  const Places& places() const { return places_; }

 private:
  // Without a header the columns are in our order, op perhaps missing.
  Result<bool> find_by_our_names(const Fields& first) {
    for (std::size_t c = 0; c < kColumns; ++c) places_[c] = place_of(kNames[c], first);
    if (places_[kId] && places_[kSize]) return true;
    if (std::uint32_t time = 0; first.size() < kOp || !parse_time(first[kTime], time))
      return refused("line 1", "it names no columns 'id' and 'size'");
    for (std::size_t c = 0; c < kColumns; ++c)
      places_[c] = c < first.size() ? std::optional(c) : std::nullopt;
    return false;
  }

  Status find_as_told(const std::string& columns, const Fields& first) {
    Fields words;
    split(columns, words);
    for (const std::string_view word : words) ATRIUM_RETURN_IF_ERROR(take_word(word, first));
    if (places_[kId] && places_[kSize]) return {};
    return Status(Code::kUsage, "--columns", "", "names no 'id' or no 'size'", kColumnsRemedy);
  }

  Status take_word(std::string_view word, const Fields& first) {
    const std::size_t equals = word.find('=');
    const auto column = std::ranges::find(kNames, trimmed(word.substr(0, equals)));
    if (equals == std::string_view::npos || column == kNames.end())
      return Status(Code::kUsage, "--columns", "", "'" + std::string(word) + "' is not understood",
                    kColumnsRemedy);
    auto& place = places_[static_cast<std::size_t>(column - kNames.begin())];
    const std::string_view value = trimmed(word.substr(equals + 1));
    if (std::size_t number = 0; parse_whole(value, number) && number > 0) {
      place = number - 1;
      return {};
    }
    place = place_of(value, first);
    named_ = true;
    if (place) return {};
    return refused("line 1", "it names no column '" + std::string(value) + "'");
  }

  static std::optional<std::size_t> place_of(std::string_view name, const Fields& first) {
    for (std::size_t i = 0; i < first.size(); ++i)
      if (lower(first[i]) == lower(name)) return i;
    return std::nullopt;
  }

  Status refused(const std::string& place, const std::string& cause) const {
    return Status(Code::kUsage, file_, place, cause, kColumnsRemedy);
  }

  std::string file_;
  Places places_;
  bool named_ = false;  // some column by its name
};

class CsvReader {
 public:
  CsvReader(const std::string& file, const std::string& columns)
      : file_(file), columns_(columns), numbers_(trace_) {}

  Result<Trace> read(std::string_view text) {
    while (!text.empty()) {
      const std::size_t end = text.find('\n');
      const std::string_view line = trimmed(text.substr(0, end));
      text.remove_prefix(end == std::string_view::npos ? text.size() : end + 1);
      ++line_;
      if (line.empty()) continue;
      split(line, fields_);
      ATRIUM_RETURN_IF_ERROR(take_line());
    }
    if (!started_) return Status(Code::kUsage, file_, "line 1", "it is empty", kColumnsRemedy);
    return std::move(trace_);
  }

 private:
  Status take_line() {
    if (started_) return take_request();
    started_ = true;
    Layout layout(file_);
    const Result<bool> header = layout.find(columns_, fields_);
    if (!header.ok()) return header.status();
    places_ = layout.places();
    return *header ? Status() : take_request();
  }

  Status take_request() {
    for (std::size_t c = 0; c < kColumns; ++c) {
      if (!places_[c]) continue;
      if (*places_[c] >= fields_.size() || fields_[*places_[c]].empty())
        return wrong("it has no " + std::string(kNames[c]), kColumnsRemedy);
      if (fields_[*places_[c]].front() == '"')
        return wrong("it has quotes", "write it without quotes");
    }
    TraceEvent event{TraceOp::kGet};
    std::uint32_t time = 0;
    ATRIUM_RETURN_IF_ERROR(take_size(event));
    ATRIUM_RETURN_IF_ERROR(take_op(event));
    if (places_[kTime] && !parse_time(field(kTime), time))
      return wrong(shown(kTime) + " is no time",
                   "a time is in seconds, from 0 to below 2^32; leave it out of --columns if it is "
                   "anything else");
    event.record = numbers_.of(id_of(field(kId)));
    trace_.events.push_back(event);
    trace_.times.push_back(time);
    return {};
  }

  Status take_size(TraceEvent& event) const {
    if (parse_whole(field(kSize), event.bytes) && event.bytes <= kLargestTraceRecord) return {};
    return wrong(shown(kSize) + " is no size", "a size is in whole bytes, from 0 to 2^40");
  }

  Status take_op(TraceEvent& event) const {
    if (!places_[kOp]) return {};
    const auto op = op_of(field(kOp));
    if (!op)
      return wrong(shown(kOp) + " is no op that reads or writes",
                   "write get or put; leave others out");
    event.op = *op;
    return {};
  }

  std::string_view field(Column c) const { return fields_[*places_[c]]; }
  std::string shown(Column c) const { return "'" + std::string(field(c)) + "'"; }
  Status wrong(const std::string& cause, const char* remedy) const {
    return Status(Code::kUsage, file_, "line " + std::to_string(line_), cause, remedy);
  }

  std::string file_, columns_;
  Trace trace_;
  RecordNumbers numbers_;
  Places places_;
  Fields fields_;
  std::size_t line_ = 0;
  bool started_ = false;
};

}  // namespace

Result<Trace> decode_csv(std::string_view text, const std::string& file,
                         const std::string& columns) {
  return CsvReader(file, columns).read(text);
}

Status write_csv(const Trace& trace, const std::string& path) {
  auto file = AppendFile::create(path);
  if (!file.ok()) return file.status();
  std::string batch = kHeader;
  for (std::size_t i = 0; i < trace.events.size(); ++i) {
    const TraceEvent& event = trace.events[i];
    batch += std::to_string(trace.times.empty() ? 0 : trace.times[i]) + ",";
    batch += std::to_string(trace.ids[event.record]) + ",";
    batch += std::to_string(event.bytes) + (event.op == TraceOp::kPut ? ",put\n" : ",get\n");
    if (batch.size() < kBatch) continue;
    ATRIUM_RETURN_IF_ERROR(file->append(batch));
    batch.clear();
  }
  ATRIUM_RETURN_IF_ERROR(file->append(batch));
  return file->close();
}

}  // namespace atrium
