#include "apps/settings_file.h"

#include <toml++/toml.h>

#include <optional>
#include <sstream>

namespace atrium {
namespace {

std::string place_of(const toml::source_region& source) {
  return source.begin ? "line " + std::to_string(source.begin.line) : "";
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

std::optional<std::vector<std::string>> node_values(const toml::node& node) {
  std::vector<std::string> values;
  const auto add = [&](const toml::node& scalar) {
    const auto text = scalar_text(scalar);
    if (text) values.push_back(*text);
    return text.has_value();
  };
  const toml::array* array = node.as_array();
  if (array == nullptr) return add(node) ? std::optional(values) : std::nullopt;
  for (const toml::node& item : *array)
    if (!add(item)) return std::nullopt;
  return values;
}

Status take(const std::string& table, const std::string& key, const toml::node& node,
            SettingsFile& file) {
  const std::string place = place_of(node.source());
  auto values = node_values(node);
  if (!values)
    return Status(Code::kUsage, file.path, place,
                  "'" + key + "' is neither a text, a number, a truth value nor a list of them",
                  "write it as on the command line, in quotes");
  file.settings.push_back({table, key, place, std::move(*values)});
  return {};
}

Status take_table(const std::string& name, const toml::table& table, SettingsFile& file) {
  file.tables.push_back({name, place_of(table.source())});
  for (const auto& [key, node] : table)
    ATRIUM_RETURN_IF_ERROR(take(name, std::string(key.str()), node, file));
  return {};
}

Result<SettingsFile> settings_of(const toml::table& root, const std::string& path) {
  SettingsFile file{path, {}, {}};
  for (const auto& [key, node] : root) {
    const std::string name(key.str());
    const toml::table* table = node.as_table();
    ATRIUM_RETURN_IF_ERROR(table == nullptr ? take("", name, node, file)
                                            : take_table(name, *table, file));
  }
  return file;
}

Status not_toml(const toml::parse_error& e, const std::string& path) {
  return Status(Code::kUsage, path, place_of(e.source()), std::string(e.description()),
                "mend the file");
}

}  // namespace

Result<SettingsFile> parse_settings(const std::string& text, const std::string& path) {
  try {
    return settings_of(toml::parse(text), path);
  } catch (const toml::parse_error& e) {
    return not_toml(e, path);
  }
}

Result<SettingsFile> read_settings(const std::string& path) {
  try {
    return settings_of(toml::parse_file(path), path);
  } catch (const toml::parse_error& e) {
    return not_toml(e, path);
  }
}

std::vector<std::string> values_for(const Option& option, const Setting& setting) {
  if (option.repeats || setting.values.size() == 1) return setting.values;
  std::string all;
  for (const std::string& v : setting.values) all += (all.empty() ? "" : ",") + v;
  return {all};
}

}  // namespace atrium
