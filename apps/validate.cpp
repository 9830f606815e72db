// atrium validate SUITE: what is computed, held against what must come out. A suite is a function
// and a line in kSuites.
#include <tbb/global_control.h>
#include <tbb/info.h>

#include <algorithm>
#include <iomanip>
#include <iostream>
#include <memory>

#include "apps/command.h"
#include "apps/report_json.h"
#include "apps/validation.h"
#include "apps/validation/suites.h"
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
  int basis = 0;  // 0: the suite's own
  ImportOptions scene;
  PartitionOptions partition;
  SoundnessOptions soundness;
};

ValidationCase none_of(std::string name, std::uint64_t found) {
  return within(std::move(name), 0, double(found), 0);
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
               {"partition_seconds", partition_seconds}};
  v.examples = r.examples;
  return v;
}

int basis_of(const ValidateOptions& o) { return o.basis > 0 ? o.basis : kUsualBasis; }

Result<Validation> validate_form_factors(const ValidateOptions&) { return judge_form_factors({}); }

// With every basis there is, unless one is asked for.
Result<Validation> validate_furnace(const ValidateOptions& o) {
  FurnaceChoice choice;
  for (int basis = 1; basis <= kMaxOrder; ++basis)
    if (o.basis == 0 || o.basis == basis) choice.bases.push_back(basis);
  return judge_furnaces(choice);
}

Result<Validation> validate_cie171(const ValidateOptions& o) { return judge_cie171(basis_of(o)); }

Result<Validation> validate_stiffness(const ValidateOptions& o) {
  return judge_stiffness(basis_of(o));
}

Result<Validation> validate_extremes(const ValidateOptions& o) {
  return judge_extremes(basis_of(o));
}

struct Suite {
  const char* name;
  Result<Validation> (*run)(const ValidateOptions&);
  bool needs_scene = false;  // the others bring their own
};
constexpr Suite kSuites[] = {{"form-factors", validate_form_factors},
                             {"furnace", validate_furnace},
                             {"cie171", validate_cie171},
                             {"stiffness", validate_stiffness},
                             {"extremes", validate_extremes},
                             {"visibility", validate_visibility, true}};

std::string suite_names() {
  std::vector<std::string> names;
  for (const Suite& s : kSuites) names.push_back(s.name);
  return joined(names);
}

void print(const Validation& v) {
  constexpr int kName = 48, kColumn = 14, kDigits = 8, kDifferenceDigits = 3;
  std::cout << std::setprecision(kDigits) << std::left << std::setw(kName) << v.suite << std::right;
  for (const char* column : {"expected", "found", "difference", "allowed"})
    std::cout << std::setw(kColumn) << column;
  std::cout << "  pass\n";
  for (const ValidationCase& c : v.cases) {
    std::cout << std::left << std::setw(kName) << c.name << std::right << std::setw(kColumn)
              << c.expected << std::setw(kColumn) << c.found << std::setprecision(kDifferenceDigits)
              << std::setw(kColumn) << c.difference() << std::setw(kColumn) << c.allowed
              << std::setprecision(kDigits) << (c.pass ? "  yes\n" : "  NO\n");
  }
  std::cout << '\n';
  for (const auto& [name, value] : v.figures)
    std::cout << std::left << std::setw(kName) << name << std::right << std::setw(kColumn) << value
              << '\n';
  for (const std::string& e : v.examples) std::cout << e << '\n';
  std::cout << std::flush;
}

// The suites that are meant: the one that is named, or all that bring their own scenes.
Result<std::vector<const Suite*>> chosen(const std::vector<std::string>& words) {
  std::vector<const Suite*> suites;
  for (const Suite& s : kSuites)
    if (words.empty() ? !s.needs_scene : words.front() == s.name) suites.push_back(&s);
  if (suites.empty())
    return usage_error("there is no suite '" + words.front() + "'",
                       "it is one of " + suite_names());
  if (words.size() > 1 && !suites.front()->needs_scene)
    return usage_error("the suite " + words.front() + " brings its own scenes",
                       "leave out " + words[1]);
  return suites;
}

Result<int> validate(ValidateOptions& options, const Global& global, Console& console) {
  const auto suites = chosen(options.words);
  if (!suites.ok()) return suites.status();
  if (!options.words.empty())
    options.scene.files.assign(options.words.begin() + 1, options.words.end());
  std::vector<Validation> all;
  for (const Suite* suite : *suites) {
    console.detail(suite->name);
    const Stopwatch watch;
    Result<Validation> found = suite->run(options);
    if (!found.ok()) return found.status();
    found->suite = suite->name;
    found->figures.emplace_back("seconds", watch.seconds());
    if (!global.json) print(*found);
    all.push_back(std::move(found).value());
  }
  if (global.json)
    std::cout << (options.words.empty() ? validations_json(all) : validation_json(all.front()));
  const bool passed =
      std::all_of(all.begin(), all.end(), [](const Validation& v) { return v.pass(); });
  return passed ? 0 : static_cast<int>(Code::kInternal);
}

}  // namespace

Command validate_command() {
  auto options = std::make_shared<ValidateOptions>();
  Command command{"validate", "what is computed, held against what must come out", {}, {}};
  OptionSet& set = command.options;
  set.argument("SUITE",
               "form-factors, furnace, cie171, stiffness, extremes (all of these); or visibility "
               "SCENE...: random segments judge the oracles",
               0, kMostWords, options->words);
  set.count("basis", "of elements in what is solved (furnace: each in turn; else 2)", 1, kMaxOrder,
            [options](std::uint64_t n) { options->basis = static_cast<int>(n); });
  add_scene_options(set, options->scene);
  add_partition_options(set, options->partition);
  set.count("segments", "visibility: how many are drawn (1000000)", 1, UINT64_MAX,
            [options](std::uint64_t n) {
              options->soundness.segments = n;
              options->soundness.tubes = n / kSegmentsATube;
            });
  set.count("seed", "of what is drawn", 0, UINT64_MAX,
            [options](std::uint64_t seed) { options->soundness.seed = seed; });
  command.run = [options](const Global& global, Console& console) {
    const int threads = global.threads > 0 ? global.threads : tbb::info::default_concurrency();
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism,
                                    static_cast<std::size_t>(threads));
    return validate(*options, global, console);
  };
  return command;
}

}  // namespace atrium
