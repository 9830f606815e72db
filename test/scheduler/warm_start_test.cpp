// A solve that starts from the run of the scene before an edit: it gathers to what the edit reaches
// and to nothing else, and ends where a fresh solve of the edited scene does, within the error
// asked for.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <memory>

#include "scheduler/warm_start.h"
#include "test/agree/scenes.h"
#include "test/pagestore/simulated_disk.h"

namespace atrium::testing {
namespace {

constexpr double kAsked = 0.1;
// The run before is more exact, so that no estimate of what starts from it, which chance has a part
// in, calls for finer links everywhere.
constexpr double kBefore = 0.75 * kAsked;

// Changes the faces of one group.
void edit(GeneratedModel& model, const std::string& group,
          const std::function<void(GeneratedFace&)>& change) {
  bool found = false;
  for (const GeneratedGroup& g : model.groups)
    for (std::uint32_t f = g.first_face; g.name == group && f < g.first_face + g.face_count; ++f) {
      change(model.faces[f]);
      found = true;
    }
  ASSERT_TRUE(found) << group;
}

// A paint of its own for a group, made of those that its faces had.
void repaint(GeneratedModel& model, const std::string& group,
             const std::function<void(Paint&)>& change) {
  std::map<PaintId, PaintId> edited;
  edit(model, group, [&](GeneratedFace& f) {
    if (!edited.contains(f.paint)) {
      Paint paint = model.paints[f.paint];
      paint.name += "_edited";
      change(paint);
      edited[f.paint] = PaintId(model.paints.size());
      model.paints.push_back(paint);
    }
    f.paint = edited[f.paint];
  });
}

void dim(GeneratedModel& model, const std::string& lamp) {
  repaint(model, lamp, [](Paint& p) { p.luminance *= .5; });
}

void move(GeneratedModel& model, const std::string& group, const Vec3& by) {
  std::vector<bool> moved(model.vertices.size(), false);
  edit(model, group, [&](GeneratedFace& f) {
    for (std::uint32_t v = f.first_vertex; v < f.first_vertex + f.vertex_count; ++v)
      moved[v] = true;
  });
  for (std::size_t v = 0; v < moved.size(); ++v)
    if (moved[v]) model.vertices[v] += by;
}

// Nine rooms with a lamp and three boxes each, and doorways between neighbours.
class WarmStartOfRooms : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    before_ = std::make_unique<GeneratedModel>(
        generated({.kind = "rooms", .rho = .5, .grid = 3}));
    bench_ = std::make_unique<Bench>(*before_);
    from_ = bench_->options().run_directory;
    SolveOptions o = bench_->options();
    o.error = kBefore;
    o.run_directory = from_;
    const Result<SolveSummary> summary = solve(o, {}, {});
    ASSERT_TRUE(summary.ok()) << summary.status().message();
    ASSERT_EQ(summary->exit_code, 0);
    records_ = contents();
  }
  static void TearDownTestSuite() {
    EXPECT_EQ(contents(), records_);  // it was read, and not written
    bench_.reset();
    before_.reset();
  }

  static SolveOptions options(Bench& bench, const std::string& from) {
    SolveOptions o = bench.options();
    o.error = kAsked;
    o.from = from;
    return o;
  }

  static std::map<std::uint64_t, std::uint64_t> contents() {
    auto store = ClusterStore::open(from_, {}, OpenMode::kReadOnly);
    EXPECT_TRUE(store.ok()) << store.status().message();
    std::map<std::uint64_t, std::uint64_t> hashes;
    if (store.ok())
      for (const RecordId id : (*store)->record_ids()) {
        const auto bytes = (*store)->stream_in(id);
        EXPECT_TRUE(bytes.ok());
        hashes[id.value] = hash_bytes(*bytes);
      }
    return hashes;
  }

  // As the command line's contract has it: root mean square of the difference, relative to the
  // larger of what is there and the mean.
  static double difference(const GeneratedModel& model, SolvedRun& run, SolvedRun& fresh) {
    double mean = 0;
    std::vector<std::pair<double, double>> found;
    for (const Probe& p : probes_on(model, 2)) {
      const std::optional<SurfaceSample> a = run.at(p), b = fresh.at(p);
      if (!a || !b || !(luminance(b->irradiance) > 0)) continue;
      found.push_back({luminance(a->irradiance), luminance(b->irradiance)});
      mean += found.back().second;
    }
    mean /= double(found.size());
    double squares = 0;
    for (const auto& [x, y] : found) squares += std::pow((x - y) / std::max(y, mean), 2);
    return std::sqrt(squares / double(found.size()));
  }

  // Solves the edited scene from the old run and afresh; how many clusters the first gathered to.
  static std::uint64_t reached(const GeneratedModel& edited, WarmFigures* figures = nullptr) {
    Bench bench(edited);
    SolvedRun warm(options(bench, from_)), fresh(options(bench, ""));
    if (!warm.ok() || !fresh.ok()) return 0;
    EXPECT_EQ(warm.summary().exit_code, 0) << warm.summary().stop_reason;
    EXPECT_LT(difference(edited, warm, fresh), kAsked);
    EXPECT_NEAR(warm.summary().flux_absorbed, fresh.summary().flux_absorbed,
                kAsked * fresh.summary().flux_absorbed);
    if (figures) *figures = warm.summary().warm;
    return warm.summary().warm.clusters_reached;
  }

  static inline std::unique_ptr<GeneratedModel> before_;
  static inline std::unique_ptr<Bench> bench_;
  static inline std::string from_;
  static inline std::map<std::uint64_t, std::uint64_t> records_;
};

// Eleven clusters stand in a room, with its lamp and its door; what goes through the doors is the
// little that the coarse system carries.
TEST_F(WarmStartOfRooms, DimmedLampReachesItsRoomAndFewClustersMore) {
  GeneratedModel edited = *before_;
  dim(edited, "room1_1/lamp");
  WarmFigures figures;
  const std::uint64_t count = reached(edited, &figures);
  EXPECT_GE(count, 9u);
  EXPECT_LE(count, before_->groups.size() / 4);
  EXPECT_EQ(figures.clusters_changed, 1u);
}

TEST_F(WarmStartOfRooms, RepaintedWallReachesItsRoomAndFewClustersMore) {
  GeneratedModel edited = *before_;
  repaint(edited, "room2_2/wall_west", [](Paint& p) { p.reflectance = {.1, .02, .02}; });
  WarmFigures figures;
  const std::uint64_t count = reached(edited, &figures);
  EXPECT_GE(count, 3u);
  EXPECT_LE(count, before_->groups.size() / 2);
  EXPECT_EQ(figures.clusters_changed, 1u);
}

// All that may see it gather anew, for it may have stood in their light.
TEST_F(WarmStartOfRooms, MovedBoxIsGatheredToAndAllThatMaySeeIt) {
  GeneratedModel edited = *before_;
  move(edited, "room3_1/furniture/box2", {.2, .1, 0});
  WarmFigures figures;
  const std::uint64_t count = reached(edited, &figures);
  EXPECT_GE(count, 10u);
  // The floor is cut along other lines, so that all that see it make links with it anew.
  EXPECT_LE(count, before_->groups.size() * 4 / 5);
  EXPECT_GE(figures.clusters_changed, 2u);  // it, and the floor that it stands on
  EXPECT_LE(figures.clusters_changed, 3u);
}

TEST_F(WarmStartOfRooms, NothingChangedIsNothingGathered) {
  SolvedRun run(options(*bench_, from_));
  ASSERT_TRUE(run.ok());
  EXPECT_EQ(run.summary().exit_code, 0) << run.summary().stop_reason;
  EXPECT_EQ(run.summary().iterations, 0u);
  EXPECT_EQ(run.summary().warm.clusters_reached, 0u);
  EXPECT_EQ(run.summary().warm.clusters_changed, 0u);
  // Cluster by cluster the same bytes.
  auto store = ClusterStore::open(from_, {}, OpenMode::kReadOnly);
  ASSERT_TRUE(store.ok());
  for (std::size_t c = 0; c < run.summary().clusters; ++c) {
    const Result<ClusterView> now = run.solution().cluster(ClusterId(c));
    const auto before = (*store)->stream_in(record_id(RecordKind::kCluster, c));
    ASSERT_TRUE(now.ok() && before.ok());
    const ClusterView was = ClusterView::parse(*before).value();
    ASSERT_EQ(now->head().elements, was.head().elements);
    for (std::size_t p = 0; p < was.size(); ++p)
      ASSERT_TRUE(std::ranges::equal(now->patch(p).e, was.patch(p).e));
  }
}

// Patches are matched by where they are: all of them moved by a metre are all new.
TEST_F(WarmStartOfRooms, EverythingMovedIsAFreshSolveBitForBit) {
  GeneratedModel edited = *before_;
  for (Vec3& v : edited.vertices) v.x += 1;
  Bench bench(edited);
  SolvedRun warm(options(bench, from_)), fresh(options(bench, ""));
  ASSERT_TRUE(warm.ok() && fresh.ok());
  EXPECT_EQ(warm.summary().warm.patches_kept, 0u);
  EXPECT_TRUE(warm.records() == fresh.records());
}

// By the coarse system alone all light is halved: every cluster is reached, none is new.
TEST_F(WarmStartOfRooms, EveryLampDimmedIsGatheredEverywhereFromElementsThatAreKept) {
  GeneratedModel edited = *before_;
  for (Paint& p : edited.paints) p.luminance *= .5;
  WarmFigures figures;
  EXPECT_EQ(reached(edited, &figures), before_->groups.size());
  EXPECT_GT(figures.elements_kept, figures.patches_kept);
}

TEST_F(WarmStartOfRooms, AWarmStartCanBeStartedFromInTurn) {
  GeneratedModel dimmed = *before_;
  dim(dimmed, "room1_1/lamp");
  Bench first(dimmed);
  const SolveOptions once = options(first, from_);
  ASSERT_TRUE(SolvedRun(once).ok());
  Bench second(*before_);
  SolvedRun back(options(second, once.run_directory)), fresh(options(second, ""));
  ASSERT_TRUE(back.ok() && fresh.ok());
  EXPECT_LT(difference(*before_, back, fresh), kAsked);
}

TEST_F(WarmStartOfRooms, LinksDiscardedReachTheSameClusters) {
  GeneratedModel edited = *before_;
  dim(edited, "room1_1/lamp");
  Bench bench(edited);
  SolveOptions kept = options(bench, from_), discarded = options(bench, from_);
  discarded.links = "discard";
  SolvedRun a(kept), b(discarded);
  ASSERT_TRUE(a.ok() && b.ok());
  EXPECT_EQ(a.summary().warm.clusters_reached, b.summary().warm.clusters_reached);
  EXPECT_LT(difference(edited, a, b), kAsked);
}

TEST_F(WarmStartOfRooms, PlanSaysWhatSolveWillDo) {
  GeneratedModel edited = *before_;
  dim(edited, "room1_1/lamp");
  Bench bench(edited);
  const Result<Plan> planned = plan(options(bench, from_));
  ASSERT_TRUE(planned.ok()) << planned.status().message();
  ASSERT_TRUE(planned->warm.has_value());
  EXPECT_EQ(planned->warm->patches_kept, planned->patches);
  EXPECT_EQ(planned->warm->clusters_changed, 1u);
  EXPECT_GT(planned->warm->clusters_reached, 0u);
}

TEST_F(WarmStartOfRooms, WhatCannotBeStartedFromIsRefused) {
  SolveOptions o = options(*bench_, from_);
  o.error = kAsked / 10;
  EXPECT_EQ(solve(o, {}, {}).status().code(), Code::kUsage);
  o = options(*bench_, from_);
  o.basis = 3;
  EXPECT_EQ(solve(o, {}, {}).status().code(), Code::kUsage);
  o = options(*bench_, from_ + "/none");
  EXPECT_EQ(solve(o, {}, {}).status().code(), Code::kUsage);
  o = options(*bench_, from_);
  o.run_directory = from_;
  EXPECT_EQ(solve(o, {}, {}).status().code(), Code::kUsage);
  SolveOptions cut_short = options(*bench_, "");
  cut_short.iterations = 1;
  ASSERT_TRUE(solve(cut_short, {}, {}).ok());
  EXPECT_EQ(solve(options(*bench_, cut_short.run_directory), {}, {}).status().code(),
            Code::kUsage);
}

// ---- Cut short.

using Fault = SimulatedDisk::Fault;

// Two rooms, the walls of one repainted, on a disk in memory that holds the run before the edit.
class WarmStartCutShort : public ::testing::Test {
 protected:
  static void SetUpTestSuite() {
    before_ = std::make_unique<Bench>(two_rooms_model());
    GeneratedModel edited = two_rooms_model();
    edited.paints[2].reflectance = {.2, .1, .1};
    after_ = std::make_unique<Bench>(edited);
    SolveOptions o = small(*before_, "old");
    o.disk = &disk_;
    const Result<SolveSummary> old = solve(o, {}, {});
    ASSERT_TRUE(old.ok()) << old.status().message();
    ASSERT_EQ(old->exit_code, 0) << old->stop_reason;
    SimulatedDisk disk = disk_;
    const Result<SolveSummary> summary = start_on(disk);
    ASSERT_TRUE(summary.ok()) << summary.status().message();
    ASSERT_GT(summary->iterations, 1u);
    ASSERT_GT(summary->warm.clusters_reached, 0u);
    ASSERT_LT(summary->warm.clusters_reached, summary->clusters);
    undisturbed_ = contents_of(disk);
    calls_ = disk.calls - disk_.calls;
  }
  static void TearDownTestSuite() {
    before_.reset();
    after_.reset();
  }

  static SolveOptions small(Bench& bench, const std::string& run) {
    SolveOptions o = bench.options();
    o.run_directory = run;
    o.error = 0.2;
    o.min_edge = 0.1;
    o.threads = 1;
    o.memory = std::uint64_t{2200} << 10;
    o.arena = std::uint64_t{540} << 10;
    o.checkpoint_every = 1e-9;
    o.recover = true;
    return o;
  }
  static Result<SolveSummary> start_on(SimulatedDisk& disk) {
    SolveOptions o = small(*after_, "new");
    o.from = "old";
    o.disk = &disk;
    return solve(o, {}, {});
  }
  static std::map<std::uint64_t, std::uint64_t> contents_of(SimulatedDisk& disk) {
    auto store = ClusterStore::open("new", {.disk = &disk}, OpenMode::kReadOnly);
    EXPECT_TRUE(store.ok()) << store.status().message();
    std::map<std::uint64_t, std::uint64_t> hashes;
    if (store.ok())
      for (const RecordId id : (*store)->record_ids())
        hashes[id.value] = hash_bytes((*store)->stream_in(id).value());
    return hashes;
  }

  static inline std::unique_ptr<Bench> before_, after_;
  static inline SimulatedDisk disk_;
  static inline std::map<std::uint64_t, std::uint64_t> undisturbed_;
  static inline std::uint64_t calls_ = 0;
};

TEST_F(WarmStartCutShort, PowerLostAtAnyCallLeavesTheBitsOfAStartThatWasNotDisturbed) {
  constexpr std::uint64_t kTried = 24;
  for (std::uint64_t i = 0; i < kTried; ++i) {
    const std::uint64_t n = i * calls_ / kTried;
    SCOPED_TRACE("call " + std::to_string(n) + " of " + std::to_string(calls_));
    SimulatedDisk disk = disk_;
    disk.fault = [at = disk.calls + n](std::uint64_t call, const std::string&) {
      return call == at ? Fault::kPowerOff : Fault::kNone;
    };
    static_cast<void>(start_on(disk));
    ASSERT_FALSE(disk.powered);
    disk.fault = nullptr;
    disk.lose_power_and_restart(n);
    const Result<SolveSummary> summary = start_on(disk);
    ASSERT_TRUE(summary.ok()) << summary.status().message();
    ASSERT_TRUE(contents_of(disk) == undisturbed_);
  }
}

TEST_F(WarmStartCutShort, TheOldRunIsNotNeededAfterTheFirstGather) {
  SimulatedDisk disk = disk_;
  disk.fault = [at = disk.calls + calls_ / 2](std::uint64_t call, const std::string&) {
    return call == at ? Fault::kError : Fault::kNone;
  };
  ASSERT_FALSE(start_on(disk).ok());
  disk.fault = nullptr;
  std::erase_if(disk.files, [](const auto& file) { return file.first.starts_with("old"); });
  const Result<SolveSummary> summary = start_on(disk);
  ASSERT_TRUE(summary.ok()) << summary.status().message();
  EXPECT_TRUE(contents_of(disk) == undisturbed_);
}

}  // namespace
}  // namespace atrium::testing
