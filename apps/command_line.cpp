#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <iostream>
#include <map>
#include <memory>

#include <CLI/CLI.hpp>

#include "apps/command.h"
#include "apps/settings_file.h"

namespace atrium {
namespace {

using Values = std::vector<std::string>;

// Where a value was found, and what it is.
struct Found {
  std::string where;  // "--min-edge", "ATRIUM_MIN_EDGE", "house.toml:3: min-edge"
  Values values;
};

// The --config file: keys that hold for all commands, and tables of the commands' own.
struct ConfigFile {
  std::map<std::string, Found> keys;  // "memory", "solve.memory"

  const Found* find(const std::string& command, const std::string& name) const {
    auto at = keys.find(command + "." + name);
    if (at == keys.end()) at = keys.find(name);
    return at == keys.end() ? nullptr : &at->second;
  }
};

std::string variable_name(std::string name) {
  for (char& c : name) c = c == '-' ? '_' : static_cast<char>(std::toupper(c));
  return "ATRIUM_" + name;
}

// Gives the settings of a file to the options that they are of.
class ConfigReader {
 public:
  ConfigReader(std::string path, const OptionSet& global, const std::vector<Command>& commands)
      : path_(std::move(path)), global_(global), commands_(commands) {}

  Result<ConfigFile> read() {
    const Result<SettingsFile> file = read_settings(path_);
    if (!file.ok()) return file.status();
    for (const SettingsTable& table : file->tables)
      if (!is_command(table.name)) return unknown("table [" + table.name + "]", table.place);
    for (const Setting& setting : file->settings) ATRIUM_RETURN_IF_ERROR(take(setting));
    return std::move(file_);
  }

 private:
  bool is_command(const std::string& name) const {
    return std::any_of(commands_.begin(), commands_.end(),
                       [&](const Command& c) { return c.name == name; });
  }

  Status unknown(const std::string& what, const std::string& place) const {
    return Status(Code::kUsage, path_, place, "unknown " + what,
                  "take it out, or see `atrium COMMAND --help` for what there is");
  }

  const Option* option_of(const std::string& command, const std::string& name) const {
    if (const Option* o = global_.find(name)) return o;
    for (const Command& c : commands_)
      if (command.empty() || c.name == command)
        if (const Option* o = c.options.find(name)) return o;
    return nullptr;
  }

  Status take(const Setting& s) {
    const Option* option = option_of(s.table, s.key);
    if (option == nullptr || s.key == "config") return unknown("key '" + s.key + "'", s.place);
    const std::string key = s.table.empty() ? s.key : s.table + "." + s.key;
    file_.keys[key] = {path_ + ":" + s.place + ": " + s.key, values_for(*option, s)};
    return {};
  }

  std::string path_;
  const OptionSet& global_;
  const std::vector<Command>& commands_;
  ConfigFile file_;
};

// An option on the command line of CLI11.
struct Bound {
  const Option* option;
  CLI::Option* parsed;
};

void bind(CLI::App& app, const OptionSet& set, std::vector<Bound>& bound,
          std::map<std::string, Values>& texts) {
  for (const Option& o : set.options()) {
    Values& values = texts[app.get_name() + "." + o.name];
    CLI::Option* parsed = nullptr;
    if (o.value.empty()) {
      parsed = app.add_flag(o.flags, o.help);
    } else {
      parsed = app.add_option(o.flags, values, o.help)->type_name(o.value);
      parsed->expected(1)->multi_option_policy(o.repeats ? CLI::MultiOptionPolicy::TakeAll
                                                         : CLI::MultiOptionPolicy::Throw);
    }
    bound.push_back({&o, parsed});
  }
  for (const Argument& a : set.arguments()) {
    CLI::Option* parsed = app.add_option(a.name, *a.target, a.help)->type_name("");
    parsed->expected(static_cast<int>(a.least), static_cast<int>(a.most));
    if (a.least > 0) parsed->required();
  }
}

// Flag over environment over file.
Status settle(const std::vector<Bound>& bound, const std::string& command, const ConfigFile& file) {
  for (const auto& [option, parsed] : bound) {
    if (parsed->count() > 0) {
      const Values values = option->value.empty() ? Values{"true"} : parsed->results();
      ATRIUM_RETURN_IF_ERROR(set_option(*option, "--" + option->name, values));
      continue;
    }
    const std::string variable = variable_name(option->name);
    if (const char* text = std::getenv(variable.c_str())) {
      ATRIUM_RETURN_IF_ERROR(set_option(*option, variable, {text}));
      continue;
    }
    if (const Found* found = file.find(command, option->name))
      ATRIUM_RETURN_IF_ERROR(set_option(*option, found->where, found->values));
  }
  return {};
}

Status check_arguments(const Command& command) {
  for (const Argument& a : command.options.arguments()) {
    if (a.target->size() >= a.least && a.target->size() <= a.most) continue;
    return usage_error("'" + command.name + "' takes " + a.name + ": " + a.help,
                       "see `atrium " + command.name + " --help`");
  }
  return {};
}

// "-.5 0 0" is a number, not a bundle of flags: a blank before it tells CLI11 so.
std::vector<std::string> arguments_for_cli11(int argc, char** argv) {
  std::vector<std::string> words(argv + 1, argv + argc);
  for (std::string& w : words)
    if (w.size() > 2 && w[0] == '-' && w[1] == '.' &&
        std::isdigit(static_cast<unsigned char>(w[2])))
      w = " " + w;
  std::reverse(words.begin(), words.end());  // as CLI11 wants them
  return words;
}

int fail(const Status& status) {
  std::cerr << "atrium: " << status.message() << '\n';
  return static_cast<int>(status.code());
}

// The command line as CLI11 sees it, and which option is where in it.
class Parser {
 public:
  Parser(const OptionSet& globals, const std::vector<Command>& commands)
      : app_("Out-of-core hierarchical radiosity for buildings larger than memory.", "atrium"),
        bound_(commands.size()) {
    app_.require_subcommand(0, 1);
    app_.allow_extras();
    app_.add_flag("--version", version_, "the version of the program and of its libraries");
    bind(app_, globals, bound_globals_, texts_);
    for (std::size_t i = 0; i < commands.size(); ++i) {
      CLI::App* sub = app_.add_subcommand(commands[i].name, commands[i].help);
      sub->fallthrough()->allow_extras();
      bind(*sub, commands[i].options, bound_[i], texts_);
      subcommands_.push_back(sub);
    }
  }

  // True where the command line asks for text alone, which is then printed.
  Result<bool> parse(std::vector<std::string> words, const std::string& version) {
    try {
      app_.parse(std::move(words));
    } catch (const CLI::CallForHelp&) {
      const auto chosen = app_.get_subcommands();
      std::cout << (chosen.empty() ? app_ : *chosen.front()).help();
      return true;
    } catch (const CLI::ParseError& e) {
      return usage_error(e.what(), "see `atrium --help`");
    }
    if (version_) std::cout << version;
    return version_;
  }

  // The command that was named, by its place in the list.
  Result<std::size_t> command() const {
    const auto named = std::find_if(subcommands_.begin(), subcommands_.end(),
                                    [](const CLI::App* s) { return s->parsed(); });
    const bool none = named == subcommands_.end();
    const std::string see =
        none ? "see `atrium --help`" : "see `atrium " + (*named)->get_name() + " --help`";
    const std::vector<std::string> rest = app_.remaining(true);
    if (!rest.empty()) {
      const std::string& word = rest.front();
      if (word.size() > 1 && word[0] == '-')
        return usage_error("unknown option '" + word + "'", see);
      return usage_error(
          none ? "unknown command '" + word + "'" : "'" + word + "' is one word too many", see);
    }
    if (none) return usage_error("no command given", see);
    return static_cast<std::size_t>(named - subcommands_.begin());
  }

  const std::vector<Bound>& globals() const { return bound_globals_; }
  const std::vector<Bound>& options(std::size_t command) const { return bound_[command]; }

 private:
  CLI::App app_;
  bool version_ = false;
  std::map<std::string, Values> texts_;
  std::vector<Bound> bound_globals_;
  std::vector<std::vector<Bound>> bound_;
  std::vector<CLI::App*> subcommands_;
};

// Gives every option of the command its value; the configuration file's name comes first.
Status settle_all(const Parser& parser, std::size_t index, const OptionSet& globals,
                  const std::vector<Command>& commands, const std::string& config) {
  const std::string& name = commands[index].name;
  ConfigFile file;
  ATRIUM_RETURN_IF_ERROR(settle({parser.globals().front()}, name, file));
  if (!config.empty()) {
    Result<ConfigFile> read = ConfigReader(config, globals, commands).read();
    if (!read.ok()) return read.status();
    file = std::move(*read);
  }
  ATRIUM_RETURN_IF_ERROR(settle(parser.globals(), name, file));
  ATRIUM_RETURN_IF_ERROR(settle(parser.options(index), name, file));
  return check_arguments(commands[index]);
}

int run(const Command& command, const Global& global) {
  const auto level = global.quiet     ? Console::Level::kQuiet
                     : global.verbose ? Console::Level::kVerbose
                                      : Console::Level::kNormal;
  Console console;
  const Status opened = Console::open(level, global.log, console);
  if (!opened.ok()) return fail(opened);
  const Result<int> done = command.run(global, console);
  std::cout.flush();
  if (done.ok() && std::cout) return *done;
  const Status status = done.ok() ? Status(Code::kStore, "stdout", "", "could not be written",
                                           "see that what reads it goes on, or use -o FILE")
                                  : done.status();
  console.error(status.message());
  return static_cast<int>(status.code());
}

}  // namespace

int run_command_line(int argc, char** argv, const std::vector<Command>& commands,
                     const std::string& version) {
  Global global;
  std::string config;
  OptionSet globals;
  globals.text("config", "options from a TOML file; flags and environment go before it", config);
  globals.flag("json", "stdout is one JSON document", global.json);
  globals.flag("quiet", "errors only", global.quiet, "-q");
  globals.flag("verbose", "more of what is done", global.verbose, "-v");
  globals.count("threads", "threads to use", 1, kMostThreads,
                [&](std::uint64_t n) { global.threads = static_cast<int>(n); });
  globals.text("log", "messages into this file too", global.log);

  Parser parser(globals, commands);
  const Result<bool> told = parser.parse(arguments_for_cli11(argc, argv), version);
  if (!told.ok()) return fail(told.status());
  if (*told) return 0;
  const Result<std::size_t> index = parser.command();
  if (!index.ok()) return fail(index.status());
  const Status settled = settle_all(parser, *index, globals, commands, config);
  if (!settled.ok()) return fail(settled);
  return run(commands[*index], global);
}

}  // namespace atrium
