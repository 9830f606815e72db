#include "engine/import/assign.h"

#include <fnmatch.h>

#include <toml++/toml.h>
#include <algorithm>
#include <cmath>
#include <map>

namespace atrium {
namespace {

class AssignReader {
 public:
  explicit AssignReader(const std::string& path) : path_(path) { assignment_.file = path; }

  Result<Assignment> read() {
    toml::table root;
    try {
      root = toml::parse_file(path_);
    } catch (const toml::parse_error& e) {
      return broken(e.source(), std::string(e.description()), "write it as TOML");
    }
    for (const auto& [key, node] : root) {
      if (key == "material") {
        ATRIUM_RETURN_IF_ERROR(tables(node, [&](const toml::table& t) { return material(t); }));
      } else if (key == "object") {
        ATRIUM_RETURN_IF_ERROR(tables(node, [&](const toml::table& t) { return object(t); }));
      } else {
        return unknown(key, "[[material]] and [[object]]");
      }
    }
    return std::move(assignment_);
  }

 private:
  Status broken(const toml::source_region& at, const std::string& cause,
                const std::string& remedy) const {
    const std::string place = at.begin.line > 0 ? "line " + std::to_string(at.begin.line) : "";
    return Status(Code::kUsage, path_, place, cause, remedy);
  }

  Status unknown(const toml::key& key, const std::string& known) const {
    return broken(key.source(), "unknown key '" + std::string(key.str()) + "'",
                  "known are " + known);
  }

  template <class Read>
  Status tables(const toml::node& node, Read read) {
    const toml::array* array = node.as_array();
    if (!array) return broken(node.source(), "is not a list of tables", "write [[...]]");
    for (const toml::node& item : *array) {
      const toml::table* table = item.as_table();
      if (!table) return broken(item.source(), "is not a table", "write [[...]]");
      ATRIUM_RETURN_IF_ERROR(read(*table));
    }
    return {};
  }

  Status match(const toml::node& node, std::string& glob) {
    const auto value = node.value_exact<std::string>();
    if (!value || value->empty())
      return broken(node.source(), "match is no text", "write match = \"glob\"");
    glob = *value;
    return {};
  }

  Status material(const toml::table& table) {
    MaterialRule rule;
    for (const auto& [key, node] : table) {
      if (key == "match") {
        ATRIUM_RETURN_IF_ERROR(match(node, rule.match));
      } else if (key == "reflectance") {
        ATRIUM_RETURN_IF_ERROR(colour(node, rule.reflectance));
        if (!in_range(*rule.reflectance, 1))
          return broken(node.source(), "a reflectance outside 0..1", "write 0 to below 1");
      } else if (key == "emission") {
        ATRIUM_RETURN_IF_ERROR(colour(node, rule.emission));
        if (!in_range(*rule.emission, HUGE_VAL))
          return broken(node.source(), "a negative or infinite emission", "write cd/m²");
      } else if (key == "sides") {
        ATRIUM_RETURN_IF_ERROR(sides(node, rule.sides));
      } else {
        return unknown(key, "match, reflectance, emission and sides");
      }
    }
    if (rule.match.empty())
      return broken(table.source(), "a [[material]] without match", "say which materials");
    if (!rule.reflectance && !rule.emission && !rule.sides)
      return broken(table.source(), "a [[material]] that sets nothing",
                    "give reflectance, emission or sides");
    assignment_.materials.push_back(std::move(rule));
    return {};
  }

  Status object(const toml::table& table) {
    std::string glob;
    std::optional<bool> drop;
    for (const auto& [key, node] : table) {
      if (key == "match") {
        ATRIUM_RETURN_IF_ERROR(match(node, glob));
      } else if (key == "drop") {
        drop = node.value_exact<bool>();
        if (!drop) return broken(node.source(), "drop is neither true nor false", "write true");
      } else {
        return unknown(key, "match and drop");
      }
    }
    if (glob.empty() || !drop)
      return broken(table.source(), "an [[object]] without match and drop",
                    "write match = \"glob\" and drop = true");
    if (*drop) assignment_.dropped_objects.push_back(glob);
    return {};
  }

  static bool in_range(const Spectrum& s, double limit) {
    for (int k = 0; k < 3; ++k)
      if (!(s[k] >= 0 && s[k] <= limit && std::isfinite(s[k]))) return false;
    return true;
  }

  // One number or three.
  Status colour(const toml::node& node, std::optional<Spectrum>& value) {
    const auto number = [](const toml::node& n) -> std::optional<double> {
      return n.is_number() ? n.value<double>() : std::nullopt;
    };
    if (const auto one = number(node)) {
      value = Spectrum{*one};
      return {};
    }
    if (const toml::array* list = node.as_array();
        list && (list->size() == 3 || list->size() == 1)) {
      Spectrum s{0};
      bool ok = true;
      for (std::size_t k = 0; k < 3; ++k) {
        const auto v = number(*list->get(std::min(k, list->size() - 1)));
        ok = ok && v.has_value();
        s[static_cast<int>(k)] = v.value_or(0);
      }
      if (ok) {
        value = s;
        return {};
      }
    }
    return broken(node.source(), "is not one number or three", "write 0.5 or [0.5, 0.4, 0.3]");
  }

  Status sides(const toml::node& node, std::optional<Sides>& value) {
    const auto number = node.value_exact<std::int64_t>();
    if (!number || (*number != 1 && *number != 2))
      return broken(node.source(), "sides is neither 1 nor 2", "write sides = 1 or sides = 2");
    value = *number == 1 ? kFront : kBothSides;
    return {};
  }

  const std::string& path_;
  Assignment assignment_;
};

void apply(const MaterialRule& rule, RawMaterial& m) {
  if (rule.reflectance) {
    m.reflectance = *rule.reflectance;
    m.has_reflectance = true;
  }
  if (rule.emission) {
    m.emission = *rule.emission;
    m.emission_is_luminance = true;
  }
  if (rule.sides) m.sides = rule.sides;
}

}  // namespace

bool glob_matches(const std::string& glob, const std::string& name) {
  return fnmatch(glob.c_str(), name.c_str(), 0) == 0;
}

Result<Assignment> read_assignment(const std::string& path) { return AssignReader(path).read(); }

void assign_materials(const Assignment& assignment, RawModel& model, WarningLog& warnings) {
  const std::size_t rules = assignment.materials.size();
  if (rules == 0) return;
  std::vector<bool> used(rules, false);
  // By object: the rules that match its name. Few distinct rows, so faces share materials.
  std::vector<std::vector<std::uint32_t>> by_object(model.objects.size());
  for (std::size_t r = 0; r < rules; ++r)
    for (std::size_t o = 0; o < model.objects.size(); ++o)
      if (glob_matches(assignment.materials[r].match, model.objects[o].name))
        by_object[o].push_back(static_cast<std::uint32_t>(r));
  const std::vector<RawMaterial> originals = model.materials;
  std::vector<std::vector<std::uint32_t>> by_material(originals.size());
  for (std::size_t m = 0; m < originals.size(); ++m)
    for (std::size_t r = 0; r < rules; ++r)
      if (glob_matches(assignment.materials[r].match, originals[m].name)) {
        by_material[m].push_back(static_cast<std::uint32_t>(r));
        apply(assignment.materials[r], model.materials[m]);
        used[r] = true;
      }
  std::map<std::pair<std::uint32_t, std::vector<std::uint32_t>>, std::uint32_t> copies;
  for (RawFace& f : model.faces) {
    const std::vector<std::uint32_t>& object_rules = by_object[f.object];
    if (object_rules.empty()) continue;
    const auto [at, added] = copies.try_emplace({f.material, object_rules},
                                                static_cast<std::uint32_t>(model.materials.size()));
    if (added) {
      RawMaterial m = originals[f.material];
      std::vector<std::uint32_t> all = by_material[f.material];
      all.insert(all.end(), object_rules.begin(), object_rules.end());
      std::sort(all.begin(), all.end());
      for (const std::uint32_t r : all) {
        apply(assignment.materials[r], m);
        used[r] = true;
      }
      m.name += " [" + assignment.materials[object_rules.back()].match + "]";
      model.materials.push_back(std::move(m));
    }
    f.material = at->second;
  }
  for (std::size_t r = 0; r < rules; ++r)
    if (!used[r])
      warnings.add("assigned names that match nothing",
                   "'" + assignment.materials[r].match + "' in " + assignment.file);
}

}  // namespace atrium
