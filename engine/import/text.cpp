#include "engine/import/text.h"

#include <cerrno>
#include <charconv>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace atrium {
namespace {

constexpr std::string_view kBlanks = " \t\r\v\f";

std::string_view trimmed(std::string_view s) {
  const std::size_t first = s.find_first_not_of(kBlanks);
  if (first == std::string_view::npos) return {};
  return s.substr(first, s.find_last_not_of(kBlanks) - first + 1);
}

void split_words(std::string_view s, std::vector<std::string_view>& words) {
  words.clear();
  for (std::size_t at = s.find_first_not_of(kBlanks); at != std::string_view::npos;
       at = s.find_first_not_of(kBlanks, at)) {
    const std::size_t end = std::min(s.find_first_of(kBlanks, at), s.size());
    words.push_back(s.substr(at, end - at));
    at = end;
  }
}

}  // namespace

Result<std::string> read_whole_file(const std::string& path) {
  std::error_code error;
  if (std::filesystem::is_directory(path, error))
    return Status(Code::kScene, path, "", "is a directory", "name a scene file");
  std::ifstream in(path, std::ios::binary);
  if (!in)
    return Status(Code::kScene, path, "", std::string("cannot be opened: ") + std::strerror(errno),
                  "check the path");
  std::ostringstream text;
  text << in.rdbuf();
  if (in.bad())
    return Status(Code::kScene, path, "", std::string("cannot be read: ") + std::strerror(errno),
                  "check the disk");
  return std::move(text).str();
}

bool parse_finite(std::string_view token, double& value) {
  if (token.starts_with('+')) token.remove_prefix(1);
  const char* end = token.data() + token.size();
  const auto [rest, error] = std::from_chars(token.data(), end, value);
  if (rest != end) return false;
  if (error == std::errc::result_out_of_range) {
    // Too small for a double is zero; too large is nothing.
    value = 0;
    const std::size_t exponent = token.find_first_of("eE");
    return exponent != std::string_view::npos && token.substr(exponent + 1).starts_with('-');
  }
  return error == std::errc() && std::isfinite(value);
}

std::string_view Statements::next_line() {
  const std::size_t end = rest_.find('\n');
  const std::string_view line = rest_.substr(0, end);
  rest_ = end == std::string_view::npos ? std::string_view{} : rest_.substr(end + 1);
  ++lines_read_;
  return trimmed(line);
}

bool Statements::next() {
  while (!rest_.empty()) {
    statement_ = next_line();
    line_ = lines_read_;
    if (statement_.ends_with('\\')) {
      joined_.clear();
      while (statement_.ends_with('\\')) {
        joined_.append(statement_.substr(0, statement_.size() - 1)).push_back(' ');
        statement_ = rest_.empty() ? std::string_view{} : next_line();
      }
      joined_.append(statement_);
      statement_ = trimmed(joined_);
    }
    if (statement_.empty() || statement_.front() == '#') continue;
    split_words(statement_, words_);
    // A comment may end a line of numbers.
    for (std::size_t i = 1; i < words_.size(); ++i)
      if (words_[i].front() == '#') words_.resize(i);
    return true;
  }
  return false;
}

std::string_view Statements::remainder() const {
  return trimmed(statement_.substr(words_[0].size()));
}

}  // namespace atrium
