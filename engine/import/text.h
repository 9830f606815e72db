// Reading text files line by line with strict numbers, shared by the OBJ and MTL readers.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "engine/status.h"

namespace atrium {

Result<std::string> read_whole_file(const std::string& path);

// A decimal number and nothing else; false for NaN, infinities and overflow too.
bool parse_finite(std::string_view token, double& value);

// The statements of a text: comments and empty lines left out, lines that end in a backslash
// joined. The words live as long as the text.
class Statements {
 public:
  explicit Statements(std::string_view text) : rest_(text) {}
  bool next();
  bool at_end() const { return rest_.empty(); }
  std::uint32_t line() const { return line_; }  // the first line of the statement
  std::string_view keyword() const { return words_[0]; }
  const std::vector<std::string_view>& words() const { return words_; }  // the keyword first
  // What follows the keyword, trimmed: names may hold blanks.
  std::string_view remainder() const;

 private:
  std::string_view next_line();
  std::string_view rest_;
  std::string joined_;  // of a statement over several lines
  std::string_view statement_;
  std::vector<std::string_view> words_;
  std::uint32_t line_ = 0, lines_read_ = 0;
};

}  // namespace atrium
