// What pagestore/trace_file.cpp is made of: each format's reader and writer. Readers take the whole
// file's bytes and its name for messages.
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <unordered_map>

#include "pagestore/append_file.h"
#include "pagestore/trace_file.h"

namespace atrium {

// Numbers for records, in the order in which they are first asked for.
class RecordNumbers {
 public:
  explicit RecordNumbers(Trace& trace) : trace_(trace) {}
  RecordNumber of(std::uint64_t id) {
    const auto [at, is_new] =
        numbers_.try_emplace(id, static_cast<RecordNumber>(trace_.ids.size()));
    if (is_new) {
      trace_.ids.push_back(id);
      trace_.sizes.push_back(0);
    }
    return at->second;
  }

 private:
  Trace& trace_;
  std::unordered_map<std::uint64_t, RecordNumber> numbers_;
};

Result<TraceFile> decode_atr(std::span<const std::byte> bytes, const std::string& file);
Result<Trace> decode_oracle(std::span<const std::byte> bytes, const std::string& file);
Result<Trace> decode_csv(std::string_view text, const std::string& file,
                         const std::string& columns);

Status write_atr(const Trace& trace, const std::string& path);     // with pins
Status write_oracle(const Trace& trace, const std::string& path);  // without
Status write_csv(const Trace& trace, const std::string& path);     // without

}  // namespace atrium
