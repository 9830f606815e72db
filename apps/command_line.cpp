#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <iostream>
#include <map>
#include <memory>
#include <sstream>

#include <toml++/toml.h>
#include <CLI/CLI.hpp>

#include "apps/command.h"

namespace atrium {
namespace {

using Values = std::vector<std::string>;

constexpr std::uint64_t kMostThreads = 1024;

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

std::string number_text(double x) {
  std::ostringstream out;
  out.precision(17);
  out << x;
  return out.str();
}

// A scalar of TOML as it would stand on the command line.
std::optional<std::string> scalar_text(const toml::node& node) {
  if (const auto* s = node.as_string()) return s->get();
  if (const auto* i = node.as_integer()) return std::to_string(i->get());
  if (const auto* f = node.as_floating_point()) return number_text(f->get());
  if (const auto* b = node.as_boolean()) return b->get() ? "true" : "false";
  return std::nullopt;
}

// The values that a node gives an option; an array is several, or the parts of one.
std::optional<Values> node_values(const toml::node& node, const Option& option) {
  const toml::array* array = node.as_array();
  if (array == nullptr) {
    const auto text = scalar_text(node);
    return text ? std::optional(Values{*text}) : std::nullopt;
  }
  Values parts;
  for (const toml::node& item : *array) {
    const auto text = scalar_text(item);
    if (!text) return std::nullopt;
    parts.push_back(*text);
  }
  if (option.repeats) return parts;
  std::string all;
  for (const std::string& p : parts) all += (all.empty() ? "" : ",") + p;
  return Values{all};
}

class ConfigReader {
 public:
  ConfigReader(std::string path, const OptionSet& global, const std::vector<Command>& commands)
      : path_(std::move(path)), global_(global), commands_(commands) {}

  Result<ConfigFile> read() {
    toml::table root;
    try {
      root = toml::parse_file(path_);
    } catch (const toml::parse_error& e) {
      return Status(Code::kUsage, path_, place(e.source()), std::string(e.description()),
                    "mend the configuration file");
    }
    for (const auto& [key, node] : root) {
      const std::string name(key.str());
      const toml::table* table = node.as_table();
      const Status status = table == nullptr ? take("", name, node) : take_table(name, *table);
      if (!status.ok()) return status;
    }
    return std::move(file_);
  }

 private:
  static std::string place(const toml::source_region& source) {
    return source.begin ? "line " + std::to_string(source.begin.line) : "";
  }

  Status unknown(const std::string& what, const toml::node& node) const {
    return Status(Code::kUsage, path_, place(node.source()), "unknown " + what,
                  "take it out, or see `atrium COMMAND --help` for what there is");
  }

  Status take_table(const std::string& command, const toml::table& table) {
    const bool known = std::any_of(commands_.begin(), commands_.end(),
                                   [&](const Command& c) { return c.name == command; });
    if (!known) return unknown("table [" + command + "]", table);
    for (const auto& [key, node] : table)
      ATRIUM_RETURN_IF_ERROR(take(command, std::string(key.str()), node));
    return {};
  }

  const Option* option_of(const std::string& command, const std::string& name) const {
    if (const Option* o = global_.find(name)) return o;
    for (const Command& c : commands_)
      if (command.empty() || c.name == command)
        if (const Option* o = c.options.find(name)) return o;
    return nullptr;
  }

  Status take(const std::string& command, const std::string& name, const toml::node& node) {
    const Option* option = option_of(command, name);
    if (option == nullptr || name == "config") return unknown("key '" + name + "'", node);
    const auto values = node_values(node, *option);
    if (!values)
      return Status(Code::kUsage, path_, place(node.source()),
                    "'" + name + "' is neither a text, a number, a truth value nor a list of them",
                    "write it as on the command line, in quotes");
    const std::string key = command.empty() ? name : command + "." + name;
    file_.keys[key] = {path_ + ":" + place(node.source()) + ": " + name, *values};
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

Status set_option(const Option& option, const Found& found) {
  for (const std::string& value : found.values) {
    const Status s = option.set(value);
    if (!s.ok()) return Status(s.code(), found.where, s.place(), s.cause(), s.remedy());
  }
  return {};
}

// Flag over environment over file.
Status settle(const std::vector<Bound>& bound, const std::string& command, const ConfigFile& file) {
  for (const auto& [option, parsed] : bound) {
    if (parsed->count() > 0) {
      const Values values = option->value.empty() ? Values{"true"} : parsed->results();
      ATRIUM_RETURN_IF_ERROR(set_option(*option, {"--" + option->name, values}));
      continue;
    }
    const std::string variable = variable_name(option->name);
    if (const char* text = std::getenv(variable.c_str())) {
      ATRIUM_RETURN_IF_ERROR(set_option(*option, {variable, {text}}));
      continue;
    }
    if (const Found* found = file.find(command, option->name))
      ATRIUM_RETURN_IF_ERROR(set_option(*option, *found));
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
