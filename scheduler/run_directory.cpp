#include "scheduler/run_directory.h"

#include <utility>

#include "scheduler/history.h"

namespace atrium {

namespace {

// The arena until the plan knows the run's own.
constexpr std::size_t kFirstArena = std::size_t{1} << 20;

}  // namespace

RunDirectory::RunDirectory(const SolveOptions& options, const LogCallback& log)
    : options_(options),
      log_(log),
      disk_(options.disk != nullptr ? *options.disk : machine_disk(Io::kMmap)),
      files_(disk_, options.run_directory) {}

StoreOptions RunDirectory::store_options(std::size_t arena) const {
  StoreOptions store;
  store.arena_bytes = arena;
  store.policy = options_.policy;
  store.io = options_.io == "direct" ? Io::kDirect : Io::kMmap;
  store.disk = options_.disk;
  return store;
}

Status RunDirectory::open() {
  ATRIUM_RETURN_IF_ERROR(open_store(kFirstArena));
  if (!store_) ATRIUM_RETURN_IF_ERROR(create_store());
  Result<StatusPage> page = StatusPage::open(disk_, options_.run_directory);
  if (!page.ok()) return page.status();
  page_.emplace(std::move(*page));
  return {};
}

Status RunDirectory::reopen(std::size_t arena) {
  store_.reset();
  return open_store(arena);
}

// A store that is there, of this run, and its texts as they were left; none where none is, or its
// making was cut short.
Status RunDirectory::open_store(std::size_t arena) {
  if (!ClusterStore::is_there(disk_, options_.run_directory)) return {};
  auto opened = ClusterStore::open(options_.run_directory, store_options(arena),
                                   options_.recover ? OpenMode::kRecover : OpenMode::kReadWrite);
  if (!opened.ok()) return opened.status();
  store_ = std::move(opened).value();
  if (!store_->recovery_note().ok()) say("warning: " + store_->recovery_note().message());
  const Result<RunState> state = run_state(store_->state(), options_.run_directory);
  if (!state.ok()) return state.status();
  earlier_ = *state;
  // Where nothing was begun its making may have been cut short, before run.toml or just after.
  if (!earlier_.begun && !files_.exists(RunFile::kToml)) return become_this_run();
  if (earlier_.begun) ATRIUM_RETURN_IF_ERROR(files_.verify_all(earlier_.sums));
  const Result<std::string> there = files_.read(RunFile::kToml);
  if (!there.ok()) return there.status();
  if (*there == run_toml(options_)) return {};
  if (earlier_.begun)
    return Status(Code::kUsage, options_.run_directory, "run.toml",
                  "the directory holds another run", "give another directory with -o");
  return become_this_run();  // nothing was begun here: it may become another run
}

Status RunDirectory::create_store() {
  ATRIUM_RETURN_IF_ERROR(disk_.make_directory(options_.run_directory));
  auto created = ClusterStore::create(options_.run_directory, store_options(kFirstArena),
                                      to_bytes(RunState()));
  if (!created.ok()) return created.status();
  store_ = std::move(created).value();
  return become_this_run();
}

// run.toml, and a store that knows it.
Status RunDirectory::become_this_run() {
  ATRIUM_RETURN_IF_ERROR(files_.write(RunFile::kToml, run_toml(options_)));
  return checkpoint(RunState(), true);
}

Status RunDirectory::see_to_disk(const Plan& plan) const {
  const Result<std::uint64_t> free = disk_.free_bytes(options_.run_directory);
  if (!free.ok()) return free.status();
  const std::string there = std::to_string(*free) + " bytes are free";
  if (*free < plan.smallest_disk)
    return Status(
        Code::kStore, options_.run_directory, "",
        there + ", and the solve cannot begin with less than " + std::to_string(plan.smallest_disk),
        "make room on that disk, or solve into a directory on another");
  if (*free < plan.estimated.disk_bytes)
    say("warning: " + options_.run_directory + ": " + there +
        ", and the solution is estimated at " + std::to_string(plan.estimated.disk_bytes) +
        "; if the disk fills up, make room and resume");
  return {};
}

Status RunDirectory::checkpoint(RunState state, bool summary_is_of_now) {
  const Result<RunSums> sums = files_.sums();
  if (!sums.ok()) return sums.status();
  state.sums = *sums;
  if (!summary_is_of_now) state.sums[static_cast<std::size_t>(RunFile::kSummary)] = {};
  // Twice: then both roots name the same records, and what only the root before named is free at
  // once instead of at the next checkpoint. The second one writes a directory and a state.
  for (int root = 0; root < 2; ++root) ATRIUM_RETURN_IF_ERROR(store_->checkpoint(to_bytes(state)));
  return {};
}

Status RunDirectory::begin_trace() {
  if (options_.trace.empty()) return {};
  std::string path = options_.trace;
  for (int part = 2; earlier_.begun && disk_.exists(path); ++part)
    path = options_.trace + "." + std::to_string(part);
  Result<std::unique_ptr<TraceWriter>> trace = TraceWriter::create(path, disk_);
  if (!trace.ok()) return trace.status();
  trace_ = std::move(*trace);
  store_->record_to(trace_.get());
  return {};
}

void RunDirectory::end_trace() {
  if (!trace_) return;
  store_->record_to(nullptr);
  const Status closed = trace_->close();
  trace_.reset();
  if (!closed.ok()) say("warning: the trace is not whole: " + closed.message());
}

void RunDirectory::mark_iteration(std::uint64_t number) {
  if (trace_) trace_->iteration(number);
}

void RunDirectory::mark_gather(RecordId receiver) {
  if (!trace_) return;
  trace_->gather(receiver, store_->size(receiver));
  if (!trace_->status().ok()) end_trace();
}

}  // namespace atrium
