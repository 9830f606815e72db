// Options: a command's settings, each with one strict parser, wherever its value comes from: the
// command line, else the environment (ATRIUM_MIN_EDGE for --min-edge), else the --config file.
//
// Invariants:
//  1. An option's name is its flag, its key in a configuration file and, in capitals, its variable.
//  2. A value is set by `set` alone; what `set` refuses names the option and says what it takes.
// The targets handed in must outlive the set. Not thread safe.
#pragma once

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "engine/status.h"
#include "engine/vec.h"

namespace atrium {

struct Option {
  std::string name;   // "min-edge"
  std::string flags;  // as CLI11 spells them: "-o,--output"
  std::string help;
  std::string value;  // what it takes: "LENGTH"; empty: a switch
  bool repeats = false;
  std::function<Status(const std::string&)> set;
};

// A word of the command line that is no option.
struct Argument {
  std::string name, help;
  std::size_t least = 1, most = 1;
  std::vector<std::string>* target = nullptr;
};

class OptionSet {
 public:
  using Parser = std::function<Status(const std::string&)>;

  void argument(std::string name, std::string help, std::size_t least, std::size_t most,
                std::vector<std::string>& target);
  void output(std::string help, std::string& target);  // -o FILE
  void flag(std::string name, std::string help, bool& target, std::string short_flag = "");
  void text(std::string name, std::string help, std::string& target);
  void text_list(std::string name, std::string help, std::vector<std::string>& target);
  void choice(std::string name, std::string help, std::vector<std::string> names,
              std::string& target);
  void size(std::string name, std::string help, std::uint64_t& bytes);
  void length(std::string name, std::string help, double& metres);
  void time(std::string name, std::string help, double& seconds);
  void share(std::string name, std::string help, double& share);
  void number(std::string name, std::string help, double least, double most, double& target);
  void count(std::string name, std::string help, std::uint64_t least, std::uint64_t most,
             std::function<void(std::uint64_t)> take);
  void point(std::string name, std::string help, std::optional<Vec3>& target);
  void custom(std::string name, std::string help, std::string value, Parser set);

  const std::vector<Option>& options() const { return options_; }
  const std::vector<Argument>& arguments() const { return arguments_; }
  const Option* find(const std::string& name) const;

 private:
  std::vector<Option> options_;
  std::vector<Argument> arguments_;
};

// Each value in turn. `where` it was found ("--min-edge", "house.toml:line 3: min-edge") is the
// error's file.
Status set_option(const Option& option, const std::string& where,
                  const std::vector<std::string>& values);

// Strict: decimal, finite, nothing behind it.
Result<double> parse_number(const std::string& text);
// Three numbers, with commas or blanks between them.
Result<Vec3> parse_triple(const std::string& text);
Result<bool> parse_switch(const std::string& text);  // true, false, 1, 0, on, off

// "a, b, c"
std::string joined(const std::vector<std::string>& words);

}  // namespace atrium
