// atrium validate SUITE: what is computed, held against what must come out. A suite is a function
// and a line in kSuites.
#include <tbb/global_control.h>
#include <tbb/info.h>

#include <iomanip>
#include <iostream>
#include <memory>

#include "apps/command.h"
#include "apps/report_json.h"
#include "apps/validation.h"
#include "engine/stopwatch.h"
#include "visibility/partition.h"
#include "visibility/soundness.h"

namespace atrium {
namespace {

constexpr std::size_t kMostWords = 4096;  // the suite, and the files of one scene

// A chain of tubes costs about as much as so many segments.
constexpr std::uint64_t kSegmentsATube = 100;

struct ValidateOptions {
  std::vector<std::string> words;
  ImportOptions scene;
  PartitionOptions partition;
  SoundnessOptions soundness;
};

ValidationCase none_of(std::string name, std::uint64_t found) {
  return {std::move(name), 0, double(found), found == 0};
}

// The oracles never wrongly exclude, and tubes say what is so. [THFH94 §4]
Result<Validation> validate_visibility(const ValidateOptions& o) {
  if (o.scene.files.empty())
    return usage_error("the suite visibility judges a scene, and none is given",
                       "name its files: atrium validate visibility SCENE...");
  const Result<Scene> scene = import_scene(o.scene);
  if (!scene.ok()) return scene.status();
  const Stopwatch partitioning;
  const Result<Model> model = partition(*scene, o.partition);
  if (!model.ok()) return model.status();
  const double partition_seconds = partitioning.seconds();
  const Stopwatch judging;
  const SoundnessReport r = judge_visibility(*scene, *model, o.soundness);
  Validation v;
  v.cases = {none_of("sources that a row misses", r.missed_sources),
             none_of("blockers that a row misses", r.missed_blockers),
             none_of("segments through INVISIBLE tubes", r.tubes.wrongly_invisible),
             none_of("segments blocked in VISIBLE tubes", r.tubes.wrongly_visible)};
  v.figures = {{"segments", double(o.soundness.segments)},
               {"joined", double(r.joined)},
               {"blocked", double(r.blocked)},
               {"exempt_through_closed_gaps", double(r.exempt)},
               {"closed_gaps", double(model->closed_gaps.size())},
               {"pairs_kept", double(r.pairs().kept)},
               {"pairs_witnessed", double(r.pairs().witnessed)},
               {"kept_per_witnessed", r.pairs().ratio()},
               {"self_pairs_kept", double(r.selves.kept)},
               {"self_pairs_witnessed", double(r.selves.witnessed)},
               {"mean_share_kept", r.mean_share},
               {"largest_share_kept", r.largest_share},
               {"tubes_invisible", double(r.tubes.invisible)},
               {"tubes_visible", double(r.tubes.visible)},
               {"tubes_partial", double(r.tubes.partial)},
               {"clusters", double(model->clusters.size())},
               {"patches", double(model->patches.size())},
               {"cells", double(model->cells.size())},
               {"portals", double(model->portals.size())},
               {"partition_seconds", partition_seconds},
               {"seconds", judging.seconds()}};
  v.examples = r.examples;
  return v;
}

struct Suite {
  const char* name;
  Result<Validation> (*run)(const ValidateOptions&);
};
constexpr Suite kSuites[] = {{"visibility", validate_visibility}};

std::string suite_names() {
  std::vector<std::string> names;
  for (const Suite& s : kSuites) names.push_back(s.name);
  return joined(names);
}

void print(const Validation& v) {
  constexpr int kName = 36, kColumn = 14, kDigits = 8;
  std::cout << std::setprecision(kDigits) << std::left << std::setw(kName) << v.suite << std::right;
  for (const char* column : {"expected", "found", "difference"})
    std::cout << std::setw(kColumn) << column;
  std::cout << "  pass\n";
  for (const ValidationCase& c : v.cases)
    std::cout << std::left << std::setw(kName) << c.name << std::right << std::setw(kColumn)
              << c.expected << std::setw(kColumn) << c.found << std::setw(kColumn) << c.difference()
              << (c.pass ? "  yes\n" : "  NO\n");
  std::cout << '\n';
  for (const auto& [name, value] : v.figures)
    std::cout << std::left << std::setw(kName) << name << std::right << std::setw(kColumn) << value
              << '\n';
  for (const std::string& e : v.examples) std::cout << '\n' << e << '\n';
}

Result<int> validate(ValidateOptions& options, const Global& global) {
  const std::string& name = options.words.front();
  options.scene.files.assign(options.words.begin() + 1, options.words.end());
  for (const Suite& suite : kSuites) {
    if (name != suite.name) continue;
    Result<Validation> found = suite.run(options);
    if (!found.ok()) return found.status();
    found->suite = name;
    if (global.json)
      std::cout << validation_json(*found);
    else
      print(*found);
    return found->pass() ? 0 : static_cast<int>(Code::kInternal);
  }
  return usage_error("there is no suite '" + name + "'", "it is one of " + suite_names());
}

}  // namespace

Command validate_command() {
  auto options = std::make_shared<ValidateOptions>();
  Command command{"validate", "what is computed, held against what must come out", {}, {}};
  OptionSet& set = command.options;
  set.argument("SUITE", "visibility SCENE...: random segments judge the oracles", 1, kMostWords,
               options->words);
  add_scene_options(set, options->scene);
  add_partition_options(set, options->partition);
  set.count("segments", "visibility: how many are drawn (1000000)", 1, UINT64_MAX,
            [options](std::uint64_t n) {
              options->soundness.segments = n;
              options->soundness.tubes = n / kSegmentsATube;
            });
  set.count("seed", "of what is drawn", 0, UINT64_MAX,
            [options](std::uint64_t seed) { options->soundness.seed = seed; });
  command.run = [options](const Global& global, Console&) {
    const int threads = global.threads > 0 ? global.threads : tbb::info::default_concurrency();
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(threads));
    return validate(*options, global);
  };
  return command;
}

}  // namespace atrium
