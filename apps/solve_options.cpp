#include "apps/solve_options.h"

#include <sstream>

#include "apps/settings_file.h"
#include "engine/element.h"
#include "engine/quantity.h"
#include "pagestore/policy.h"
#include "scheduler/history.h"
#include "scheduler/order.h"

namespace atrium {
namespace {

Status set_error(const std::string& text, double& error) {
  const Result<double> share = parse_share(text);
  if (!share.ok()) return share.status();
  if (*share <= 0) return usage_error("an error of nothing is never reached", "write 2% or 0.02");
  error = *share;
  return {};
}

// "FEATURE,FEATURE": which features there are, the plan knows.
Status add_features(const std::string& text, std::vector<std::string>& features) {
  std::istringstream words(text);
  for (std::string word; std::getline(words, word, ',');) {
    if (word.empty()) return usage_error("a feature without a name", "write FEATURE,FEATURE");
    features.push_back(word);
  }
  return {};
}

// What run.toml holds: solve's options, and what is no option of solve's.
OptionSet run_toml_options(SolveOptions& solve, std::string& version) {
  OptionSet options;
  add_solve_options(options, solve);
  options.text_list("scene", "", solve.scene.files);
  options.text("version", "", version);
  options.count("threads", "", 1, kMostThreads,
                [&solve](std::uint64_t n) { solve.threads = static_cast<int>(n); });
  return options;
}

Status take(const Setting& setting, const std::string& path, const OptionSet& options) {
  const Option* option = options.find(setting.key);
  if (option == nullptr || !setting.table.empty())
    return usage_error("unknown key '" + setting.key + "'", "");
  return set_option(*option, path, values_for(*option, setting));
}

Status damaged(const std::string& path, const std::string& place, const std::string& cause) {
  return Status(Code::kStore, path, place, cause, "restore it from a copy, or solve again");
}

}  // namespace

void add_solve_options(OptionSet& o, SolveOptions& s) {
  o.argument("SCENE", "one or more files: .obj, .gltf, .glb", 1, kMostFiles, s.scene.files);
  o.output("the run directory to make", s.run_directory);
  add_scene_options(o, s.scene);
  add_partition_options(o, s.partition);
  o.size("memory", "of everything that depends on the scene", s.memory);
  o.size("arena", "the page cache's share of the memory", s.arena);
  o.custom("error", "how exact: refinement and the end of the solve go by it (2%)", "SHARE",
           [&s](const std::string& text) { return set_error(text, s.error); });
  o.number("residual", "stop only when the relative residual is below this too", 0, 1, s.residual);
  o.count("iterations", "complete gathers at most", 1, UINT64_MAX,
          [&s](std::uint64_t n) { s.iterations = n; });
  o.time("time-limit", "keep what is there after so long", s.time_limit);
  o.length("min-edge", "the smallest element's edge", s.min_edge);
  o.choice("order", "in which clusters are gathered to", order_names(), s.order);
  o.custom("policy", "which record leaves the page cache: " + joined(policy_names()), "NAME",
           [&s](const std::string& text) {
             const Result<PolicyChoice> policy = parse_policy(text);
             if (policy.ok()) s.policy = text;
             return policy.ok() ? Status() : policy.status();
           });
  o.count("basis", "of an element: 1 constant, 2 linear, 3 quadratic", 1, kMaxOrder,
          [&s](std::uint64_t n) { s.basis = static_cast<int>(n); });
  o.choice("links", "what becomes of links between iterations: auto is keep", {"keep", "discard", "auto"},
           s.links);
  o.count("seed", "of the random order and of sample points", 0, UINT64_MAX,
          [&s](std::uint64_t n) { s.seed = n; });
  o.choice("io", "how records come from disk", {"mmap", "direct"}, s.io);
  o.time("checkpoint-every", "so often all is made durable (10min)", s.checkpoint_every);
  o.text("trace", "record the store's accesses in this file (.atr)", s.trace);
  o.text("reference", "points with known irradiance: history holds the true error", s.reference);
  o.text("from", "start from this run of the scene before an edit", s.from);
  o.custom("force", "switch on what the plan left out", "FEATURE,...",
           [&s](const std::string& text) { return add_features(text, s.force); });
}

Status read_run_toml(const std::string& path, SolveOptions& options) {
  const Result<SettingsFile> file = read_settings(path);
  if (!file.ok()) return damaged(path, file.status().place(), file.status().cause());
  std::string version;
  const OptionSet known = run_toml_options(options, version);
  for (const Setting& s : file->settings) {
    const Status taken = take(s, path, known);
    if (!taken.ok()) return damaged(path, s.place + ": " + s.key, taken.cause());
  }
  if (version == program_version()) return {};
  return Status(Code::kUsage, path, "version",
                "the run was begun by '" + version + "', and this is '" + program_version() + "'",
                "go on with that version, or solve again into another directory");
}

}  // namespace atrium
