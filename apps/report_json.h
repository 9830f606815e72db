// Reports as JSON: what --json prints. Each function returns one document, a newline behind it, its
// keys in a fixed order.
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "apps/leak_report.h"
#include "apps/points.h"
#include "apps/run_look.h"
#include "apps/trace_report.h"
#include "apps/validation.h"
#include "engine/import/inspect.h"
#include "engine/model.h"
#include "scheduler/check_run.h"
#include "scheduler/solve.h"

namespace atrium {

std::string generated_json(const std::string& file, std::uint64_t clusters, std::uint64_t patches,
                           std::uint64_t lights);
std::string scene_json(const SceneReport& report);
std::string leaks_json(const std::vector<LeakRow>& leaks);
// Of a run that has no summary yet.
std::string run_json(const Model& model);
// The fields of a JSON object, a line each, for people.
std::string listed(const std::string& json);
// One line without its end, so that --watch gives a line a change.
std::string status_json(const RunLook& look);
std::string check_json(const RunCheck& check);
// Of a summary's text. kStore where it has none.
Result<std::string> stop_reason(const std::string& summary, const std::string& path);
std::string plan_json(const Plan& plan);
// F12, F21, A1, A2; NaN stands for null.
std::string form_factor_json(double f12, double f21, double a1, double a2);
std::string probe_json(const std::vector<ProbePoint>& points,
                       const std::vector<ProbeAnswer>& answers);
// What reference took; noise as ReferenceResult has it.
struct ReferenceFigures {
  std::uint64_t points = 0, paths = 0, rays = 0;
  double seconds = 0, cpu_seconds = 0, noise = 0;
};
std::string reference_json(const ReferenceFigures& figures);
std::string picture_json(const std::string& file, int width, int height,
                         std::optional<double> exposure_ev);
std::string export_json(const std::string& file, std::uint64_t bytes, std::uint64_t vertices,
                        std::uint64_t faces);
std::string page_json(const std::string& file, std::uint64_t bytes,
                      const std::vector<std::string>& runs);
std::string trace_info_json(const TraceInfo& info);
std::string conversion_json(const std::string& file, const std::string& format,
                            std::uint64_t requests, const std::vector<std::string>& lost);
std::string simulation_json(const SimulationTable& table);
std::string curve_json(const MissCurve& curve);
std::string validation_json(const Validation& validation);
// Of several suites.
std::string validations_json(const std::vector<Validation>& validations);
std::string replay_json(const Simulation& simulated, const Replay& replayed);

}  // namespace atrium
