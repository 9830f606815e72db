// A strict little reader of HTML that claims to be XML: every tag closed in its order, attributes
// in double quotes and no two of a name, nothing bare that has a meaning. "" where all is well,
// else what is wrong and where.
#pragma once

#include <cctype>
#include <regex>
#include <set>
#include <string>
#include <vector>

namespace atrium::testing {

inline bool bare_ampersand(const std::string& text) {
  static const std::regex kEntity("&(?!(amp|lt|gt|quot|#[0-9]+);)");
  return std::regex_search(text, kEntity);
}

// Of `<name a="b" c="d"` or `</name`, without what closes it.
inline std::string fault_of_tag(const std::string& tag) {
  static const std::regex kTag("/?[a-z][a-z0-9]*(\\s+[a-zA-Z-]+=\"[^\"<]*\")*\\s*");
  static const std::regex kAttribute("\\s([a-zA-Z-]+)=");
  if (!std::regex_match(tag, kTag)) return "no tag: <" + tag;
  std::set<std::string> names;
  for (std::sregex_iterator a(tag.begin(), tag.end(), kAttribute), end; a != end; ++a)
    if (!names.insert((*a)[1]).second) return "two attributes of a name: <" + tag;
  return "";
}

inline std::string fault_of(const std::string& page) {
  static const std::string kDoctype = "<!DOCTYPE html>\n";
  std::vector<std::string> open;
  std::size_t at = page.starts_with(kDoctype) ? kDoctype.size() : 0;
  while (at < page.size()) {
    const std::size_t begin = std::min(page.find('<', at), page.size());
    const std::string text = page.substr(at, begin - at);
    if (bare_ampersand(text) || text.find('>') != std::string::npos) return "bare: " + text;
    if (begin == page.size()) break;
    const std::size_t end = page.find('>', begin);
    if (end == std::string::npos) return "a tag without end";
    std::string tag = page.substr(begin + 1, end - begin - 1);
    at = end + 1;
    const bool empty = tag.ends_with('/');
    if (empty) tag.pop_back();
    if (const std::string fault = fault_of_tag(tag); !fault.empty()) return fault;
    if (bare_ampersand(tag)) return "bare: <" + tag;
    const std::string name = tag.substr(0, tag.find_first_of(" \n\t"));
    if (name[0] != '/') {
      if (!empty) open.push_back(name);
      continue;
    }
    if (open.empty() || open.back() != name.substr(1)) return "<" + name + "> closes nothing";
    open.pop_back();
  }
  return open.empty() ? "" : "<" + open.back() + "> is not closed";
}

}  // namespace atrium::testing
