// Levels: refinement goes from coarse to fine, so that brightness is known roughly before it
// decides what is worth refining. Here is when a level ends, what comes next, and whether the
// answer is good enough: rules on the Cursor alone, which know nothing of how a sweep or an
// estimate is made.
//
//   after_sweep      what a complete sweep across links means: another one, the next level, an
//                    estimate to judge by, or an end
//   after_estimate   whether the solution is as exact as asked; if not, a local pass may make it
//                    so, and then finer links
//   needs_look       how closely the error is looked at
//
// Invariants:
//  1. A level's number never falls, and links become finer only by a new level or the last one
//     over again, whose links are then all made anew but where it would make them the same.
//  2. An end that going on would not change stands in the cursor (done): a run that is taken up
//     again ends so at once. An iteration or time limit is none, nor is a stop on request.
// Functions of their arguments; the cursor is the caller's.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "scheduler/error_estimate.h"
#include "scheduler/run_state.h"
#include "scheduler/solve.h"

namespace atrium {

// Each level's link threshold is this many times the last's.
inline constexpr std::array<double, 3> kLevels{16, 4, 1};
// The first level alone knows brightness too little for its estimate to be the last word: its rows
// may be so far off that they had to be scaled.
inline constexpr std::uint32_t kFirstTaken = 1;
// A coarse level's answer is taken where so many times the estimate's upper end is below the error
// asked: few elements hide errors in few places, which its points miss (rooms of ρ = .9: 1.4
// [1.2, 1.5] where 2.9% is true).
inline constexpr double kBeyondDoubt = 1.4;
// A level ends when the light still to come is below this share of all: coarse ones, and for the
// last relative to the error asked for. An institute at 1% took 18 sweeps of 16 s across streamed
// links to a fiftieth of that, of which the last 13 changed nothing that the truth would tell.
inline constexpr double kCoarseRest = 0.01;
inline constexpr double kFineRestOfError = 1.0 / 10;
// An answer that is taken has settled beyond that, but not beyond what the error asked would tell:
// a grid of 400 rooms took four sweeps of 20 s across streamed links to 4e-8.
inline constexpr double kTakenRestOfError = 1.0 / 100;
inline constexpr std::uint32_t kMostSettling = 24;
// So many sweeps in a row without progress, and none is to be expected. Links that are made anew
// each time are not quite the same each time: where there are such, the change stays at their
// noise, and progress is a change that falls by a tenth.
inline constexpr std::uint32_t kStalledSweeps = 30, kNoisySweeps = 6;
inline constexpr double kNoisyProgress = 0.9;
// Where the estimate is above the error asked, links are made finer: by the square of how much, in
// these bounds, beyond the last level so often at most.
inline constexpr double kTightest = 1.0 / 8, kLoosest = 1.0 / 2;
inline constexpr std::uint32_t kMostTightened = 1;
// A local pass takes a quarter off the error of the last level (hospital 5.9 to 4.7% and 2.65 to
// 2.0, rooms 1.8 to 1.5), for about what links of half the threshold cost, and is lost when links
// are made anew: it is made if that will do, or where links become no finer. Coarse ones gain too
// little from it.
inline constexpr double kMendedByPass = 1.3;
// The error is looked at closer where the interval is vague, its ends so many times apart; and, to
// be judged, ever closer while what was asked lies within. The first look is for few links, which
// cost less than the second one.
inline constexpr double kVague = 2.5;
inline constexpr std::array<EstimateSettings, 3> kLooks{
    {{.points = 256, .directions = 128, .seed = 4},
     {.points = 768, .directions = 128, .seed = 2},
     {.points = 2048, .directions = 256, .seed = 3}}};
inline constexpr std::uint64_t kFewLinks = 1 << 16;
// What sweeps have changed since the last estimate, as a share of the light, against the error that
// it found: below this it still holds, for a line of the history and to be judged by.
inline constexpr double kStale = 0.3, kStaleToJudge = 0.1;

// How a run ends. The numbers stand in checkpoints (Cursor::done).
enum class Stop {
  kNone,
  kConverged,
  kResidual,
  kIterations,
  kTime,
  kRequested,
  kStalled,
  kTooCoarse,
  kFailed
};

const char* reason(Stop stop);
// Of the program; kFailed has its Status's own.
int exit_code(Stop stop);

// What a complete sweep across links has measured.
struct SweepOutcome {
  double change = 0;    // of reflected flux, as a share of it
  double awaited = 0;   // of the light, as a share: what the coarse system has found to be to come
  double residual = 0;  // relative, as SolveOptions has it
  bool noisy = false;   // links were made anew
};

struct Next {
  Stop stop = Stop::kNone;
  bool level_begins = false;  // links are made anew
};

// The link threshold of where the iteration stands.
double link_threshold(const Cursor& cursor, const SolveOptions& options);

Next after_sweep(Cursor& cursor, const SolveOptions& options, const SweepOutcome& sweep);

// links: as many were gathered across in the last sweep.
Next after_estimate(Cursor& cursor, const SolveOptions& options, const ErrorEstimate& estimate,
                    std::uint64_t links);

// Is kLooks[look] needed, beside what is known already? Asked look by look, from the first on.
bool needs_look(std::size_t look, const Cursor& cursor, const SolveOptions& options,
                const ErrorEstimate& known, std::uint64_t links);

}  // namespace atrium
