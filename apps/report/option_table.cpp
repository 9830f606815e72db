#include "apps/report/option_table.h"

#include <algorithm>
#include <filesystem>

#include "apps/options.h"
#include "apps/report/number_text.h"
#include "engine/quantity.h"
#include "scheduler/history.h"

namespace atrium {
namespace {

std::string size_words(const std::string& text) {
  const Result<std::uint64_t> size = parse_size(text);
  return size.ok() ? format_size(*size) : text;
}

std::string length_words(const std::string& text) {
  const Result<double> length = parse_length(text);
  return length.ok() ? format_length(*length) : text;
}

std::string time_words(const std::string& text) {
  const Result<double> time = parse_time(text);
  return time.ok() ? format_time(*time) : text;
}

std::string share_words(const std::string& text) {
  const Result<double> share = parse_share(text);
  return share.ok() ? percent_text(*share) : text;
}

std::string number_words(const std::string& text) {
  const Result<double> number = parse_number(text);
  return number.ok() ? number_text(*number) : text;
}

std::string file_words(const std::string& text) {
  return std::filesystem::path(text).filename().string();
}

// Of options that are not written as they stand.
constexpr struct {
  const char* key;
  std::string (*words)(const std::string&);
} kWords[] = {
    {"scene", file_words},      {"assign", file_words},           {"reference", file_words},
    {"trace", file_words},      {"memory", size_words},           {"arena", size_words},
    {"unit", length_words},     {"close-gaps", length_words},     {"min-edge", length_words},
    {"time-limit", time_words}, {"checkpoint-every", time_words}, {"error", share_words},
    {"white", number_words},    {"residual", number_words}};

const Setting* find(const std::vector<Setting>& settings, const std::string& key) {
  for (const Setting& s : settings)
    if (s.table.empty() && s.key == key) return &s;
  return nullptr;
}

std::string text_of(const std::vector<Setting>& settings, const std::string& key) {
  const Setting* setting = find(settings, key);
  return setting ? option_text(*setting) : "";
}

// As a run that was told nothing writes them.
std::vector<Setting> defaults() {
  const Result<SettingsFile> settings = parse_settings(run_toml(SolveOptions{}), "");
  ATRIUM_CHECK(settings.ok());
  return settings->settings;
}

}  // namespace

std::string option_text(const Setting& setting) {
  std::vector<std::string> texts = setting.values;
  for (const auto& [key, words] : kWords)
    if (setting.key == key) std::transform(texts.begin(), texts.end(), texts.begin(), words);
  return joined(texts);
}

std::vector<OptionRow> telling_options(const std::vector<const RunData*>& runs) {
  const std::vector<Setting> usual = defaults();
  std::vector<std::string> keys;
  for (const RunData* run : runs)
    for (const Setting& s : run->options)
      if (s.table.empty() && s.key != "scene" && s.key != "version" &&
          std::find(keys.begin(), keys.end(), s.key) == keys.end())
        keys.push_back(s.key);
  std::vector<OptionRow> rows;
  for (const std::string& key : keys) {
    OptionRow row{key, {}, false};
    bool told = false;
    for (const RunData* run : runs) {
      row.values.push_back(text_of(run->options, key));
      row.differs |= row.values.back() != row.values.front();
      told |= row.values.back() != text_of(usual, key);
    }
    if (row.differs || told) rows.push_back(std::move(row));
  }
  return rows;
}

}  // namespace atrium
