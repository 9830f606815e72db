#include "scheduler/check_run.h"

#include <algorithm>
#include <array>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>

#include "engine/cluster_record.h"
#include "engine/stopwatch.h"
#include "pagestore/root.h"
#include "scheduler/braid_record.h"
#include "scheduler/equilibrium.h"
#include "scheduler/record_pieces.h"
#include "scheduler/run_model.h"
#include "scheduler/run_state.h"
#include "scheduler/status_page.h"

namespace atrium {

namespace {

// Records are streamed past the arena, pieces of the model apart.
constexpr std::size_t kArena = 4 * kRunModelPiece;
// s. A live run may overtake a check; one that does for so long checkpoints all the time.
constexpr double kPatience = 20;

std::string kind_name(RecordKind kind) {
  const std::string name = to_string(record_id(kind, 0));  // "cluster 0"
  return name.substr(0, name.rfind(' '));
}

Status missing(const std::string& directory, RecordId id) {
  return Status(Code::kStore, directory, to_string(id), "it is not there", kDamageRemedy);
}

Result<std::uint64_t> whole_roots(Disk& disk, const std::string& directory) {
  const std::string path = directory + "/roots";
  auto file = disk.open(path, DiskAccess::kRead);
  if (!file.ok()) return file.status();
  const auto slots = read_roots(**file);
  if (!slots.ok()) return slots.status();
  return std::ranges::count_if(*slots, [](const RootSlot& s) { return s.root.has_value(); });
}

// Does the payload say what a record of its kind says?
Status parse_record(RecordId id, std::span<const std::byte> payload) {
  if (kind_of(id) == RecordKind::kCluster) {
    const Result<ClusterView> view = ClusterView::parse(payload);
    if (!view.ok()) return view.status();
    if (view->head().cluster == index_of(id)) return {};
    return Status(Code::kStore, "", "", "it is of another cluster", kDamageRemedy);
  }
  if (kind_of(id) == RecordKind::kBraids) return read_braids(payload).status();
  return {};
}

Status check_records(ClusterStore& store, const std::string& directory) {
  for (const RecordId id : store.record_ids()) {
    const auto payload = store.stream_in(id);
    if (!payload.ok()) return payload.status();
    const Status parsed = parse_record(id, *payload);
    if (!parsed.ok())
      return Status(Code::kStore, directory, to_string(id), parsed.cause(), kDamageRemedy);
  }
  return {};
}

// The model loads, and every cluster of it has its record, and the coarse system its units.
Status check_model(ClusterStore& store, const std::string& directory) {
  const Result<RunModel> run = load_run_model(store, directory);
  if (!run.ok()) return run.status();
  for (std::size_t c = 0; c < run->model.clusters.size(); ++c) {
    const RecordId id = record_id(RecordKind::kCluster, c);
    if (!store.contains(id)) return missing(directory, id);
  }
  if (!has_pieces(store, RecordKind::kFactors)) return {};
  const Equilibrium equilibrium(run->model, {});
  const auto pass = [](std::size_t, std::span<const CoarseFactor>) {};
  const Status factors = read_coarse_factors(store, equilibrium.units(), pass).status();
  if (factors.ok()) return {};
  return Status(Code::kStore, directory, factors.place(), factors.cause(), kDamageRemedy);
}

std::vector<CheckedRecords> counted(const ClusterStore& store) {
  std::map<RecordKind, CheckedRecords> kinds;
  for (const RecordId id : store.record_ids()) {
    CheckedRecords& r = kinds[kind_of(id)];
    r.kind = kind_name(kind_of(id));
    ++r.count;
    r.bytes += store.size(id);
  }
  std::vector<CheckedRecords> all;
  for (auto& [kind, records] : kinds) all.push_back(std::move(records));
  return all;
}

// Lines that came after the sums were taken: whole ones are JSON; the last may be being written.
Status check_lines(const std::string& path, const std::string& text, std::size_t summed) {
  std::istringstream lines(text.substr(summed));
  std::size_t number = std::count(text.begin(), text.begin() + std::ptrdiff_t(summed), '\n');
  for (std::string line; std::getline(lines, line) && !lines.eof();) {
    ++number;
    if (!nlohmann::json::accept(line))
      return Status(Code::kStore, path, "line " + std::to_string(number), "it is not JSON",
                    "take the line out: it tells of the run's progress and holds nothing else");
  }
  return {};
}

Status check_texts(const RunFiles& files, const RunSums& sums, RunCheck& check) {
  ATRIUM_RETURN_IF_ERROR(files.verify_all(sums));
  for (const FileSum& s : sums) check.summed_bytes += s.length;
  for (const RunFile file : {RunFile::kHistory, RunFile::kLog}) {
    if (!files.exists(file)) continue;
    const Result<std::string> text = files.read(file);
    if (!text.ok()) return text.status();
    const std::size_t summed = sums[static_cast<std::size_t>(file)].length;
    check.unsummed_bytes += text->size() - summed;
    if (file == RunFile::kHistory)
      ATRIUM_RETURN_IF_ERROR(check_lines(files.path(file), *text, summed));
  }
  return {};
}

// epoch: of the root it is about; 0 where none could be read.
Result<RunCheck> check_once(Disk& disk, const std::string& directory, std::uint64_t& epoch) {
  StoreOptions options;
  options.arena_bytes = kArena;
  options.disk = &disk;
  auto opened = ClusterStore::open(directory, options, OpenMode::kReadOnly);
  if (!opened.ok()) return opened.status();
  ClusterStore& store = **opened;
  epoch = store.epoch();
  ATRIUM_RETURN_IF_ERROR(store.verify_all());
  const Result<std::uint64_t> roots = whole_roots(disk, directory);
  if (!roots.ok()) return roots.status();
  if (epoch > 1 && *roots < 2)
    return Status(Code::kStore, directory + "/roots", "", "the older root is not there",
                  kDamageRemedy);
  const Result<RunState> state = run_state(store.state(), directory);
  if (!state.ok()) return state.status();
  RunCheck check;
  check.begun = state->begun != 0;
  check.epoch = epoch;
  check.roots = *roots;
  check.records = counted(store);
  ATRIUM_RETURN_IF_ERROR(check_records(store, directory));
  if (check.begun) ATRIUM_RETURN_IF_ERROR(check_model(store, directory));
  ATRIUM_RETURN_IF_ERROR(check_texts(RunFiles(disk, directory), state->sums, check));
  const auto page = read_status(disk, directory);
  if (!page.ok()) return page.status();
  return check;
}

// Has a live run gone on to another root? What was looked at may be gone then, and nothing wrong.
bool moved_on(Disk& disk, const std::string& directory, std::uint64_t epoch) {
  auto file = disk.open(directory + "/roots", DiskAccess::kRead);
  if (!file.ok()) return false;
  const auto slots = read_roots(**file);
  if (!slots.ok()) return false;
  return std::ranges::any_of(*slots,
                             [&](const RootSlot& s) { return s.root && s.root->epoch > epoch; });
}

}  // namespace

Result<RunCheck> check_run(const std::string& directory) {
  if (!std::filesystem::is_directory(directory))
    return Status(Code::kUsage, directory, "", "not a run directory",
                  "give the directory that atrium solve wrote with -o");
  Disk& disk = machine_disk(Io::kMmap);
  for (const Stopwatch watch;;) {
    std::uint64_t epoch = 0;
    Result<RunCheck> check = check_once(disk, directory, epoch);
    const bool overtaken = !check.ok() && epoch > 0 && moved_on(disk, directory, epoch);
    if (!overtaken || watch.seconds() > kPatience) return check;
  }
}

}  // namespace atrium
