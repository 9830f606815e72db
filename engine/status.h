// Status and Result: what can go wrong, as a value. Every error names the file, the place in it,
// the cause and the remedy; its code is the program's exit code (interface: "Exit codes").
#pragma once

#include <optional>
#include <string>
#include <utility>

#include "engine/check.h"

namespace atrium {

enum class Code {
  kOk = 0,
  kInternal = 1,
  kUsage = 2,    // usage or configuration; a budget too small
  kScene = 3,    // missing, broken, or without any light
  kStore = 4,    // store or disk
  kLimit = 5,    // a limit was reached before convergence; the result is kept
  kStopped = 75  // stopped on request with a checkpoint
};

class [[nodiscard]] Status {
 public:
  Status() = default;
  // file: what was being read or written; place: line, byte, object or record in it ("" if none).
  Status(Code code, std::string file, std::string place, std::string cause, std::string remedy = "")
      : code_(code),
        file_(std::move(file)),
        place_(std::move(place)),
        cause_(std::move(cause)),
        remedy_(std::move(remedy)) {}

  bool ok() const { return code_ == Code::kOk; }
  Code code() const { return code_; }
  const std::string& file() const { return file_; }
  const std::string& place() const { return place_; }
  const std::string& cause() const { return cause_; }
  const std::string& remedy() const { return remedy_; }

  // "file:place: cause; remedy", leaving out what is empty.
  std::string message() const;

 private:
  Code code_ = Code::kOk;
  std::string file_, place_, cause_, remedy_;
};

// A T or the Status that says why there is none.
template <class T>
class [[nodiscard]] Result {
 public:
  Result(T value) : value_(std::move(value)) {}
  Result(Status status) : status_(std::move(status)) { ATRIUM_CHECK(!status_.ok()); }

  bool ok() const { return value_.has_value(); }
  const Status& status() const { return status_; }
  T& value() & {
    ATRIUM_CHECK(ok());
    return *value_;
  }
  const T& value() const& {
    ATRIUM_CHECK(ok());
    return *value_;
  }
  T&& value() && {
    ATRIUM_CHECK(ok());
    return std::move(*value_);
  }
  T& operator*() & { return value(); }
  const T& operator*() const& { return value(); }
  T* operator->() { return &value(); }
  const T* operator->() const { return &value(); }

 private:
  std::optional<T> value_;
  Status status_;
};

}  // namespace atrium

// Returns the status of `expression` from the enclosing function if it is an error.
#define ATRIUM_RETURN_IF_ERROR(expression)                  \
  do {                                                      \
    ::atrium::Status status_or_ok = (expression);           \
    if (!status_or_ok.ok()) return status_or_ok;            \
  } while (false)
