#include "apps/options.h"

#include <charconv>
#include <cmath>
#include <sstream>
#include <utility>

#include "engine/quantity.h"

namespace atrium {
namespace {

Status usage(std::string cause, std::string remedy) {
  return Status(Code::kUsage, "", "", std::move(cause), std::move(remedy));
}

// A parser that stores what `parse` makes of the text.
template <class Parse, class T>
OptionSet::Parser storing(Parse parse, T& target) {
  return [parse, &target](const std::string& text) -> Status {
    auto value = parse(text);
    if (!value.ok()) return value.status();
    target = *value;
    return {};
  };
}

std::string shown(double x) {
  std::ostringstream out;
  out << x;
  return out.str();
}

}  // namespace

void OptionSet::custom(std::string name, std::string help, std::string value, Parser set) {
  std::string flags = "--" + name;
  options_.push_back({std::move(name), std::move(flags), std::move(help), std::move(value), false,
                      std::move(set)});
}

void OptionSet::argument(std::string name, std::string help, std::size_t least, std::size_t most,
                         std::vector<std::string>& target) {
  arguments_.push_back({std::move(name), std::move(help), least, most, &target});
}

void OptionSet::output(std::string help, std::string& target) {
  text("output", std::move(help), target);
  options_.back().flags = "-o,--output";
  options_.back().value = "FILE";
}

void OptionSet::flag(std::string name, std::string help, bool& target, std::string short_flag) {
  custom(std::move(name), std::move(help), "", storing(parse_switch, target));
  if (!short_flag.empty()) options_.back().flags = short_flag + "," + options_.back().flags;
}

void OptionSet::text(std::string name, std::string help, std::string& target) {
  custom(std::move(name), std::move(help), "TEXT", [&target](const std::string& text) -> Status {
    if (text.empty()) return usage("is empty", "give it a value or leave it out");
    target = text;
    return {};
  });
}

void OptionSet::text_list(std::string name, std::string help, std::vector<std::string>& target) {
  custom(std::move(name), std::move(help), "TEXT", [&target](const std::string& text) -> Status {
    if (text.empty()) return usage("is empty", "give it a value or leave it out");
    target.push_back(text);
    return {};
  });
  options_.back().repeats = true;
}

void OptionSet::choice(std::string name, std::string help, std::vector<std::string> names,
                       std::string& target) {
  help += " (" + joined(names) + ")";
  custom(std::move(name), std::move(help), "NAME",
         [names = std::move(names), &target](const std::string& text) -> Status {
           for (const std::string& n : names)
             if (n == text) {
               target = text;
               return {};
             }
           return usage("there is no '" + text + "'", "it is one of " + joined(names));
         });
}

void OptionSet::size(std::string name, std::string help, std::uint64_t& bytes) {
  custom(std::move(name), std::move(help), "SIZE", storing(parse_size, bytes));
}

void OptionSet::length(std::string name, std::string help, double& metres) {
  custom(std::move(name), std::move(help), "LENGTH", storing(parse_length, metres));
}

void OptionSet::time(std::string name, std::string help, double& seconds) {
  custom(std::move(name), std::move(help), "TIME", storing(parse_time, seconds));
}

void OptionSet::share(std::string name, std::string help, double& share) {
  custom(std::move(name), std::move(help), "SHARE", storing(parse_share, share));
}

void OptionSet::number(std::string name, std::string help, double least, double most,
                       double& target) {
  custom(std::move(name), std::move(help), "NUMBER",
         [least, most, &target](const std::string& text) -> Status {
           const Result<double> value = parse_number(text);
           if (!value.ok()) return value.status();
           if (*value < least || *value > most)
             return usage("'" + text + "' is out of range",
                          "it lies from " + shown(least) + " to " + shown(most));
           target = *value;
           return {};
         });
}

void OptionSet::count(std::string name, std::string help, std::uint64_t least, std::uint64_t most,
                      std::function<void(std::uint64_t)> take) {
  custom(std::move(name), std::move(help), "N",
         [least, most, take = std::move(take)](const std::string& text) -> Status {
           std::uint64_t value = 0;
           const char* end = text.data() + text.size();
           const auto [rest, error] = std::from_chars(text.data(), end, value);
           if (error != std::errc() || rest != end || value < least || value > most)
             return usage("'" + text + "' will not do",
                          "it is a whole number from " + std::to_string(least) +
                              (most == UINT64_MAX ? "" : " to " + std::to_string(most)));
           take(value);
           return {};
         });
}

void OptionSet::point(std::string name, std::string help, std::optional<Vec3>& target) {
  custom(std::move(name), std::move(help), "X,Y,Z", storing(parse_triple, target));
}

const Option* OptionSet::find(const std::string& name) const {
  for (const Option& o : options_)
    if (o.name == name) return &o;
  return nullptr;
}

Status set_option(const Option& option, const std::string& where,
                  const std::vector<std::string>& values) {
  for (const std::string& value : values) {
    const Status s = option.set(value);
    if (!s.ok()) return Status(s.code(), where, s.place(), s.cause(), s.remedy());
  }
  return {};
}

Result<double> parse_number(const std::string& text) {
  double value = 0;
  const char* end = text.data() + text.size();
  const auto [rest, error] = std::from_chars(text.data(), end, value);
  if (error != std::errc() || rest != end || !std::isfinite(value))
    return usage("'" + text + "' is not a finite number", "write it as 0.5 or 1e-3");
  return value;
}

Result<Vec3> parse_triple(const std::string& text) {
  std::string blanks = text;
  for (char& c : blanks)
    if (c == ',') c = ' ';
  std::istringstream words(blanks);
  std::vector<double> numbers;
  for (std::string word; words >> word;) {
    const Result<double> number = parse_number(word);
    if (!number.ok()) return number.status();
    numbers.push_back(*number);
  }
  if (numbers.size() != 3)
    return usage("'" + text + "' is not three numbers", "write it as 1.5,0,-2");
  return Vec3(numbers[0], numbers[1], numbers[2]);
}

Result<bool> parse_switch(const std::string& text) {
  if (text == "true" || text == "1" || text == "on") return true;
  if (text == "false" || text == "0" || text == "off") return false;
  return usage("'" + text + "' is neither true nor false", "write true or false");
}

std::string joined(const std::vector<std::string>& words) {
  std::string all;
  for (const std::string& w : words) all += (all.empty() ? "" : ", ") + w;
  return all;
}

}  // namespace atrium
