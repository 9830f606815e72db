// A small scene through the whole solve, for tests: generated or built by hand, written as OBJ to a
// directory of its own, solved to a run beside it, and probed. Gone when the test ends.
#pragma once

#include <gtest/gtest.h>

#include <cstddef>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "data/generate.h"
#include "scheduler/solution.h"
#include "scheduler/solve.h"
#include "test/folder.h"

namespace atrium::testing {

// A point of a surface in the file's frame and units, and the normal of the side that is meant.
struct Probe {
  Vec3 x{0}, normal{0};
};

// A scene on disk, and as many runs of it as a test wants.
class Bench {
 public:
  explicit Bench(const GeneratedModel& model) : scene_(folder_ / "scene.obj") {
    const Status written = write_obj(model, scene_);
    EXPECT_TRUE(written.ok()) << written.message();
  }

  // The front of every surface counts, and the back is black: as the generator means it.
  SolveOptions options() {
    SolveOptions o;
    o.scene.files = {scene_};
    o.scene.sides = SidesChoice::kOne;
    o.run_directory = folder_ / ("run" + std::to_string(runs_++));
    return o;
  }

 private:
  Folder folder_;
  std::string scene_;
  int runs_ = 0;
};

// A finished run, open for reading.
class SolvedRun {
 public:
  explicit SolvedRun(const SolveOptions& options) {
    Result<SolveSummary> summary = solve(options, {}, {});
    EXPECT_TRUE(summary.ok()) << summary.status().message();
    if (!summary.ok()) return;
    summary_ = std::move(summary).value();
    Result<std::unique_ptr<Solution>> opened =
        Solution::open(options.run_directory, std::size_t{64} << 20);
    EXPECT_TRUE(opened.ok()) << opened.status().message();
    if (opened.ok()) solution_ = std::move(opened).value();
  }

  bool ok() const { return solution_ != nullptr; }
  const SolveSummary& summary() const { return summary_; }
  Solution& solution() { return *solution_; }

  // None where no surface stands there.
  std::optional<SurfaceSample> at(const Probe& p) {
    const RunModel& run = solution_->run();
    const Vec3 x = run.frame.to_internal(p.x);
    const std::optional<PatchId> patch = solution_->patch_at(x, p.normal, 10 * run.tolerance);
    if (!patch) return std::nullopt;
    Result<SurfaceSample> s = solution_->sample(*patch, x);
    EXPECT_TRUE(s.ok()) << s.status().message();
    return s.ok() ? std::optional<SurfaceSample>(*s) : std::nullopt;
  }

  // Every cluster's record, byte for byte, in order.
  std::vector<std::vector<std::byte>> records() {
    std::vector<std::vector<std::byte>> all;
    const Status s = solution_->for_each_cluster([&](ClusterId id, const ClusterView& view) {
      std::vector<PatchTree> trees = read_record(view);
      all.emplace_back(record_bytes(trees));
      write_record(id.value, trees, all.back());
    });
    EXPECT_TRUE(s.ok()) << s.message();
    return all;
  }

 private:
  SolveSummary summary_;
  std::unique_ptr<Solution> solution_;
};

inline GeneratedModel generated(const GenerateOptions& options) {
  Result<GeneratedModel> model = generate(options);
  EXPECT_TRUE(model.ok()) << model.status().message();
  return model.ok() ? std::move(model).value() : GeneratedModel{};
}

// `count` points inside every face of a model, by mixing its corners; the side that the face's own
// normal points to.
inline std::vector<Probe> probes_on(const GeneratedModel& model, int count) {
  std::vector<Probe> probes;
  std::uint32_t state = 12345;
  const auto next = [&] {  // [Numerical Recipes' quick generator]
    state = state * 1664525u + 1013904223u;
    return 0.05 + (state >> 8) / 16777216.0;
  };
  for (const GeneratedFace& f : model.faces) {
    const PolygonView polygon = model.polygon(f);
    const Vec3 normal = normalize(area_vector(polygon));
    for (int i = 0; i < count; ++i) {
      Vec3 x{0};
      double sum = 0;
      for (const Vec3& v : polygon) {
        const double w = next();
        x += w * v;
        sum += w;
      }
      probes.push_back({x / sum, normal});
    }
  }
  return probes;
}

}  // namespace atrium::testing
