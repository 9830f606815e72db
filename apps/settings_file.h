// A TOML file of settings: what --config names, and the run.toml of a run. Its values become the
// texts that they would be on the command line, so that each option has one parser.
// Plain data; no thread safety of its own.
#pragma once

#include <string>
#include <vector>

#include "apps/options.h"
#include "engine/status.h"

namespace atrium {

struct Setting {
  std::string table, key;           // table: "" at the top of the file
  std::string place;                // "line 3"
  std::vector<std::string> values;  // of an array several
};

struct SettingsTable {
  std::string name, place;
};

struct SettingsFile {
  std::string path;
  std::vector<SettingsTable> tables;
  std::vector<Setting> settings;
};

// kUsage, with the line, where the file is not TOML or a value is no text, number, truth value or
// list of them. The name of a text that is no file stands in errors.
Result<SettingsFile> parse_settings(const std::string& text, const std::string& path);
Result<SettingsFile> read_settings(const std::string& path);

// As the option takes them: an array is several values, or the parts of one.
std::vector<std::string> values_for(const Option& option, const Setting& setting);

}  // namespace atrium
