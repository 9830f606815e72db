// What comes after a sweep and after an estimate, without a solve: the cursor is put where the
// situation has it.
#include "scheduler/levels.h"

#include <gtest/gtest.h>

#include <string>

namespace atrium::testing {
namespace {

constexpr std::uint32_t kLast = kLevels.size() - 1;
constexpr double kBelow = 0.99, kAbove = 1.01;
constexpr std::uint64_t kManyLinks = kFewLinks;

class Levels : public ::testing::Test {
 protected:
  // By a sweep that does not tell how fast the change falls: what has changed is what is to come.
  Next sweep(double change, bool noisy = false) {
    cursor_.last_change = 0;
    ++cursor_.iteration;
    return after_sweep(cursor_, options_, {.change = change, .residual = change, .noisy = noisy});
  }

  // By an estimate with an interval of nothing.
  Next estimate(double error) {
    cursor_.phase = Phase::kJudge;
    return after_estimate(cursor_, options_, {.error = error, .low = error, .high = error},
                          kManyLinks);
  }

  void be_at(std::uint32_t level, double threshold = 1) {
    cursor_.level = level;
    cursor_.threshold = threshold;
    cursor_.sweep = 1;
  }

  double threshold() const { return link_threshold(cursor_, options_); }

  // How many of `kLooks` are made one after another, each finding the same interval.
  std::size_t looks(ErrorEstimate known, double low, double high, std::uint64_t links) {
    std::size_t made = 0;
    for (std::size_t look = 0; look < kLooks.size(); ++look) {
      if (!needs_look(look, cursor_, options_, known, links)) continue;
      known = {.error = (low + high) / 2, .low = low, .high = high};
      known.points = static_cast<std::uint64_t>(kLooks[look].points);
      cursor_.unseen = 0;
      ++made;
    }
    return made;
  }

  SolveOptions options_;
  Cursor cursor_;
};

// ---- After a sweep.

TEST_F(Levels, ACoarseLevelIsJudgedWhenTheRestIsBelowItsShare) {
  be_at(0);
  EXPECT_EQ(sweep(kAbove * kCoarseRest).stop, Stop::kNone);
  EXPECT_EQ(cursor_.phase, Phase::kLinks);
  EXPECT_EQ(sweep(kBelow * kCoarseRest).stop, Stop::kNone);
  EXPECT_EQ(cursor_.phase, Phase::kJudge);
  EXPECT_EQ(cursor_.level, 0u);
}

// The last one by the error asked for: a fiftieth of 2% is stricter than a coarse level's 1%.
TEST_F(Levels, TheLastLevelIsJudgedByTheErrorAskedFor) {
  be_at(kLast);
  sweep(kBelow * kCoarseRest);
  EXPECT_EQ(cursor_.phase, Phase::kLinks);
  sweep(kBelow * options_.error / 50);
  EXPECT_EQ(cursor_.phase, Phase::kJudge);
}

// Each sweep changes .9 of what the last one did: a geometric series, whose rest after a change d
// is .9 d + .81 d + ... = 9 d.
TEST_F(Levels, WhatIsStillToComeIsTheRestOfAGeometricSeries) {
  be_at(0);
  const double d = kCoarseRest / 2;
  cursor_.last_change = d / 0.9;
  after_sweep(cursor_, options_, {.change = d});
  EXPECT_NEAR(cursor_.rest, 9 * d, 1e-12);
  EXPECT_EQ(cursor_.phase, Phase::kLinks);
}

// A change that grows has no such rest: it is taken as falling as slowly as may be, not as
// negative.
TEST_F(Levels, AChangeThatGrowsIsFarFromSettled) {
  be_at(0);
  cursor_.last_change = 1e-4;
  after_sweep(cursor_, options_, {.change = 2e-4});
  EXPECT_GT(cursor_.rest, 1);
  EXPECT_EQ(cursor_.phase, Phase::kLinks);
}

// Of white paint, ρ = .999, a hundredth of all light is missing: a sweep brings a thousandth of
// that, far below what the last level may leave, but the coarse system knows of all of it.
TEST_F(Levels, LightThatTheCoarseSystemAwaitsIsStillToCome) {
  options_.error = 0.01;
  be_at(kLast);
  cursor_.sweep = 0;
  after_sweep(cursor_, options_, {.change = 1e-5, .awaited = 1e-2});
  EXPECT_EQ(cursor_.rest, 1e-2);
  EXPECT_EQ(cursor_.phase, Phase::kLinks);
  cursor_.last_change = 0;
  after_sweep(cursor_, options_, {.change = 1e-5, .awaited = 1e-6});
  EXPECT_EQ(cursor_.rest, 1e-5);
  EXPECT_EQ(cursor_.phase, Phase::kJudge);
}

// A coarse level ends while light is awaited, which the next one's links bring; but its answer is
// not taken before it is there.
TEST_F(Levels, ACoarseAnswerIsTakenWithTheLightThatIsAwaited) {
  be_at(1);
  cursor_.sweep = 0;
  after_sweep(cursor_, options_, {.change = 1e-8, .awaited = 1e-2});
  EXPECT_EQ(cursor_.phase, Phase::kJudge);
  EXPECT_EQ(estimate(kBelow * options_.error).stop, Stop::kNone);
  EXPECT_EQ(cursor_.phase, Phase::kLinks);
  after_sweep(cursor_, options_, {.change = 1e-9, .awaited = 1e-2});
  EXPECT_EQ(cursor_.phase, Phase::kLinks);
  after_sweep(cursor_, options_, {.change = 1e-10, .awaited = 1e-7});
  EXPECT_EQ(cursor_.phase, Phase::kJudge);
  EXPECT_EQ(estimate(kBelow * options_.error).stop, Stop::kConverged);
}

TEST_F(Levels, ALevelWithoutProgressIsJudgedAsItIs) {
  be_at(kLast);
  cursor_.sweep = 0;
  sweep(0.5);  // the first, against which the others are held
  for (std::uint32_t i = 0; i + 1 < kStalledSweeps; ++i) sweep(0.5);
  EXPECT_EQ(cursor_.phase, Phase::kLinks);
  sweep(0.5);
  EXPECT_EQ(cursor_.phase, Phase::kJudge);
}

// Links that are made anew each time: a change a twentieth below the first one's is noise, and six
// sweeps of it are enough. Of links that stay, its first fall is progress, and six are not.
TEST_F(Levels, WhereLinksAreMadeAnewASmallFallIsNone) {
  for (const bool noisy : {true, false}) {
    cursor_ = {};
    be_at(kLast);
    cursor_.sweep = 0;
    sweep(0.5, noisy);
    for (std::uint32_t i = 0; i < kNoisySweeps; ++i) sweep(0.95 * 0.5, noisy);
    EXPECT_EQ(cursor_.phase == Phase::kJudge, noisy);
  }
}

// A residual that was asked for is the only end but the limits: no estimate is judged.
TEST_F(Levels, AResidualThatWasAskedForEndsTheLastLevelAlone) {
  options_.residual = 1e-3;
  be_at(kLast - 1);
  EXPECT_EQ(sweep(1e-4).stop, Stop::kNone);
  EXPECT_EQ(cursor_.level, kLast);
  EXPECT_EQ(sweep(kAbove * options_.residual).stop, Stop::kNone);
  EXPECT_EQ(cursor_.phase, Phase::kLinks);
  EXPECT_EQ(sweep(kBelow * options_.residual).stop, Stop::kResidual);
  EXPECT_EQ(static_cast<Stop>(cursor_.done), Stop::kResidual);
}

TEST_F(Levels, AResidualOutOfReachEndsAsStalled) {
  options_.residual = 1e-9;
  be_at(kLast);
  cursor_.sweep = 0;
  Next next = sweep(0.5);
  for (std::uint32_t i = 0; i < kStalledSweeps; ++i) {
    ASSERT_EQ(next.stop, Stop::kNone) << i;
    next = sweep(0.5);
  }
  EXPECT_EQ(next.stop, Stop::kStalled);
  EXPECT_EQ(static_cast<Stop>(cursor_.done), Stop::kStalled);
}

// Nine iterations, three levels: three each, however much is still to come.
TEST_F(Levels, IterationsThatAreCountedOutAreSharedByTheLevels) {
  options_.iterations = 9;
  std::string levels;
  Next next;
  while (next.stop == Stop::kNone && cursor_.iteration < 20) {
    levels += std::to_string(cursor_.level);
    next = sweep(0.5);
    EXPECT_EQ(next.level_begins, cursor_.iteration == 3 || cursor_.iteration == 6);
  }
  EXPECT_EQ(levels, "000111222");
  EXPECT_EQ(next.stop, Stop::kIterations);
  EXPECT_EQ(cursor_.done, 0u);  // with a higher limit it goes on
}

// A coarse level that has settled before its share is used up: the next one, without an estimate.
TEST_F(Levels, WhereIterationsAreCountedOutCoarseLevelsAreNotJudged) {
  options_.iterations = 30;
  EXPECT_TRUE(sweep(kBelow * kCoarseRest).level_begins);
  EXPECT_EQ(cursor_.phase, Phase::kLinks);
  EXPECT_EQ(cursor_.level, 1u);
}

// Fewer iterations than levels: each has one, and the limit holds.
TEST_F(Levels, TwoIterationsAreOneOfEachOfTwoLevels) {
  options_.iterations = 2;
  EXPECT_TRUE(sweep(0.5).level_begins);
  EXPECT_EQ(sweep(0.5).stop, Stop::kIterations);
  EXPECT_EQ(cursor_.level, 1u);
}

// ---- After an estimate.

TEST_F(Levels, TheFirstLevelsAnswerIsNeverTaken) {
  for (std::uint32_t level = 0; level < kLevels.size(); ++level) {
    cursor_ = {};
    be_at(level);
    cursor_.rest = 0;
    const Next next = estimate(options_.error / 100);
    EXPECT_EQ(next.stop, level == 0 ? Stop::kNone : Stop::kConverged) << level;
    EXPECT_EQ(next.level_begins, level == 0) << level;
  }
}

// What is asked for lies within the interval: for a coarse level not beyond doubt.
TEST_F(Levels, OnlyTheLastLevelsAnswerIsTakenWithinDoubt) {
  const ErrorEstimate doubtful{
      .error = kBelow * options_.error, .low = 0, .high = 2 * options_.error};
  for (const std::uint32_t level : {kLast - 1, kLast}) {
    cursor_ = {};
    be_at(level);
    cursor_.rest = 0;
    const Next next = after_estimate(cursor_, options_, doubtful, kManyLinks);
    EXPECT_EQ(next.stop, level == kLast ? Stop::kConverged : Stop::kNone);
  }
}

// Exact enough, but with light still to come: sweeps go on across the same links, and then it is
// taken.
TEST_F(Levels, AnAnswerThatIsTakenSettlesFirst) {
  be_at(kLast);
  cursor_.rest = kAbove * kTakenRestOfError * options_.error;
  const Next next = estimate(kBelow * options_.error);
  EXPECT_EQ(next.stop, Stop::kNone);
  EXPECT_FALSE(next.level_begins);
  EXPECT_EQ(cursor_.phase, Phase::kLinks);
  sweep(kAbove * kTakenRestOfError * options_.error);
  EXPECT_EQ(cursor_.phase, Phase::kLinks);
  sweep(kBelow * kTakenRestOfError * options_.error);
  EXPECT_EQ(cursor_.phase, Phase::kJudge);
  EXPECT_EQ(estimate(kBelow * options_.error).stop, Stop::kConverged);
  EXPECT_EQ(static_cast<Stop>(cursor_.done), Stop::kConverged);
}

// What few elements hide an estimate may miss: only the last level is taken at its word.
TEST_F(Levels, ACoarseAnswerIsTakenWhereItIsBeyondDoubt) {
  be_at(1);
  EXPECT_TRUE(estimate(kBelow * options_.error).level_begins);
  be_at(1);
  EXPECT_FALSE(estimate(kBelow / kBeyondDoubt * options_.error).level_begins);
  be_at(kLast);
  EXPECT_FALSE(estimate(kBelow * options_.error).level_begins);
}

// Links a twelfth finer would cost a level and change next to nothing.
TEST_F(Levels, WhatIsLeftToTheLastThresholdIsGoneUnlessItIsHardlyAStep) {
  be_at(kLast);
  cursor_.threshold = 4;
  cursor_.mended = 1;
  ASSERT_TRUE(estimate(100 * options_.error).level_begins);
  EXPECT_DOUBLE_EQ(cursor_.threshold, 1);
  EXPECT_EQ(cursor_.tightened, 0u);
  be_at(kLast);
  cursor_.threshold = 12.0 / 11;
  cursor_.mended = 1;
  ASSERT_TRUE(estimate(100 * options_.error).level_begins);
  EXPECT_DOUBLE_EQ(cursor_.threshold, kTightest * 12 / 11);
  EXPECT_EQ(cursor_.tightened, 1u);
}

// Settled, its estimate is above what was asked after all: the next level starts as any other, and
// is to settle as little.
TEST_F(Levels, AnAnswerThatSettlesToAWorseOneIsNotTaken) {
  be_at(1);
  cursor_.rest = kAbove * kTakenRestOfError * options_.error;
  ASSERT_FALSE(estimate(kBelow / kBeyondDoubt * options_.error).level_begins);
  ASSERT_TRUE(estimate(1.5 * options_.error).level_begins);
  EXPECT_EQ(cursor_.level, 2u);
  sweep(kBelow * kFineRestOfError * options_.error);
  EXPECT_EQ(cursor_.phase, Phase::kJudge);
}

// No sweep follows on a local pass: what it mended is judged, and taken, as it is.
TEST_F(Levels, AnAnswerThatWasMendedIsTakenAtOnce) {
  be_at(kLast);
  cursor_.rest = kAbove * kTakenRestOfError * options_.error;
  cursor_.mended = 1;
  EXPECT_EQ(estimate(kBelow * options_.error).stop, Stop::kConverged);
}

TEST_F(Levels, SettlingHasAnEnd) {
  be_at(kLast);
  cursor_.sweep = 0;
  sweep(0.5);
  cursor_.rest = 1;
  estimate(kBelow * options_.error);
  std::uint32_t sweeps = 0;
  for (double change = 0.4; cursor_.phase == Phase::kLinks && sweeps < kStalledSweeps; ++sweeps)
    sweep(change *= kBelow);
  EXPECT_EQ(sweeps, kMostSettling);
  EXPECT_EQ(estimate(kBelow * options_.error).stop, Stop::kConverged);
}

// Links that are not kept are not the same twice, and do not settle.
TEST_F(Levels, DiscardedLinksAreNotWaitedFor) {
  options_.links = "discard";
  be_at(kLast);
  cursor_.rest = kAbove * kTakenRestOfError * options_.error;
  EXPECT_EQ(estimate(kBelow * options_.error).stop, Stop::kConverged);
}

// A local pass costs about what finer links do, and is lost when links are made anew: it comes where
// it will do, or where links become no finer.
TEST_F(Levels, ALocalPassComesWhereItWillDoOrWhereLinksBecomeNoFiner) {
  be_at(kLast);
  EXPECT_FALSE(estimate(kBelow * kMendedByPass * options_.error).level_begins);
  EXPECT_EQ(cursor_.phase, Phase::kMeasure);

  cursor_ = {};
  be_at(kLast);
  EXPECT_TRUE(estimate(kAbove * kMendedByPass * options_.error).level_begins);
  EXPECT_EQ(cursor_.phase, Phase::kLinks);
  cursor_.rest = 0;
  const Next next = estimate(kAbove * kMendedByPass * options_.error);
  EXPECT_EQ(next.stop, Stop::kNone);
  EXPECT_FALSE(next.level_begins);
  EXPECT_EQ(cursor_.phase, Phase::kMeasure);
}

// Half as much again as was asked for: the error falls as the square root of the threshold, which
// becomes (1 / 1.5)² of what it was.
TEST_F(Levels, AfterALocalPassLinksBecomeFinerByTheSquare) {
  be_at(kLast);
  cursor_.mended = 1;
  const double before = threshold();
  EXPECT_TRUE(estimate(1.5 * options_.error).level_begins);
  EXPECT_NEAR(threshold() / before, 1 / (1.5 * 1.5), 1e-12);
  EXPECT_EQ(cursor_.level, kLast);
  EXPECT_EQ(cursor_.mended, 0u);
  EXPECT_EQ(cursor_.sweep, 0u);
}

TEST_F(Levels, BeyondTheLastLevelLinksBecomeFinerOnce) {
  be_at(kLast);
  cursor_.mended = 1;
  ASSERT_TRUE(estimate(1.5 * options_.error).level_begins);
  cursor_.mended = 1;
  const double finest = threshold();
  EXPECT_EQ(estimate(1.5 * options_.error).stop, Stop::kTooCoarse);
  EXPECT_EQ(static_cast<Stop>(cursor_.done), Stop::kTooCoarse);
  EXPECT_EQ(threshold(), finest);
}

// A coarse level's successor is as fine as it must be: of level 1's threshold (1 / 1.5)², and not
// the 1/4 of level 2. Where what is missing is little, at least to a half; where it is much, no
// finer than level 2 is.
TEST_F(Levels, TheNextLevelIsNoFinerThanNeeded) {
  const struct {
    double times_asked, threshold;
  } kCases[] = {{1.5, 1 / (1.5 * 1.5)}, {1.1, kLoosest}, {10, kLevels[2] / kLevels[1]}};
  for (const auto& c : kCases) {
    cursor_ = {};
    be_at(1);
    const double before = threshold();
    EXPECT_TRUE(estimate(c.times_asked * options_.error).level_begins);
    EXPECT_EQ(cursor_.level, 2u);
    EXPECT_NEAR(threshold() / before, c.threshold, 1e-12) << c.times_asked;
  }
}

// The last level, entered with coarser links than its own: a local pass if that surely does, else
// its own links, which are not counted as finer than the last level's.
TEST_F(Levels, TheLastLevelIsMadeAsFineAsItsOwnBeforeItIsMended) {
  be_at(kLast, 2);
  estimate(kBelow * kMendedByPass * options_.error);
  EXPECT_EQ(cursor_.phase, Phase::kMeasure);
  be_at(kLast, 2);
  EXPECT_TRUE(estimate(10 * options_.error).level_begins);
  EXPECT_EQ(cursor_.threshold, 1);
  EXPECT_EQ(cursor_.tightened, 0u);
}

// Few links are refined sooner than a local pass is made.
TEST_F(Levels, FewLinksThatAreNotTheFinestAreMadeFiner) {
  const double found = kBelow * kMendedByPass * options_.error;
  be_at(kLast, 2);
  const ErrorEstimate estimate{.error = found, .low = found, .high = found};
  EXPECT_TRUE(after_estimate(cursor_, options_, estimate, kFewLinks - 1).level_begins);
}

// ---- How closely the error is looked at.

TEST_F(Levels, FewLinksAreLookedAtBriefly) {
  cursor_.unseen = 1;
  EXPECT_TRUE(needs_look(0, cursor_, options_, {}, kFewLinks - 1));
  EXPECT_FALSE(needs_look(0, cursor_, options_, {}, kFewLinks));
  EXPECT_EQ(looks({}, 0.1, 0.2, kFewLinks - 1), 1u);
}

TEST_F(Levels, WhatWasNeverLookedAtIs) {
  cursor_.unseen = 0;
  EXPECT_TRUE(needs_look(1, cursor_, options_, {.error = 1}, kManyLinks));
}

// A coarse level of few links: to make finer ones costs less than to look until it is clear. Of
// many, it is looked at as closely as may be.
TEST_F(Levels, ACoarseLevelOfFewLinksIsJudgedBriefly) {
  cursor_.phase = Phase::kJudge;
  const double asked = options_.error;
  cursor_.unseen = 1;
  EXPECT_EQ(looks({}, kBelow * asked, kAbove * asked, kFewLinks - 1), 1u);
  cursor_.unseen = 1;
  EXPECT_EQ(looks({}, kBelow * asked, kAbove * asked, kManyLinks), 2u);
  EXPECT_TRUE(needs_look(0, cursor_, options_, {}, kFewLinks - 1));
}

TEST_F(Levels, AVagueIntervalIsLookedAtOnceMore) {
  cursor_.unseen = 1;
  EXPECT_EQ(looks({}, 0.1, kAbove * kVague * 0.1, kFewLinks - 1), 2u);
}

// The last level, to be judged: the closest look where what was asked lies within, one where not.
TEST_F(Levels, WhatDecidesIsLookedAtUntilItIsClear) {
  be_at(kLast);
  cursor_.phase = Phase::kJudge;
  const double asked = options_.error;
  cursor_.unseen = 1;
  EXPECT_EQ(looks({}, kBelow * asked, kAbove * asked, kFewLinks - 1), 2u);
  cursor_.unseen = 1;
  EXPECT_EQ(looks({}, kAbove * asked, 1.5 * asked, kFewLinks - 1), 1u);
}

// What the coarse system adds after a level's first sweep is seen after its second: until then all
// is unseen. From there on it is what sweeps change.
TEST_F(Levels, WhatSweepsChangeIsUnseen) {
  for (const double unseen : {1.0, 1.0, 1.2, 1.3}) {
    sweep(cursor_.sweep == 3 ? 0.1 : 0.2);
    EXPECT_NEAR(cursor_.unseen, unseen, 1e-12);
  }
}

// What is known holds until sweeps have changed a tenth of it, to be judged by; for a line of the
// history it holds longer.
TEST_F(Levels, WhatIsKnownHoldsWhileLittleChanges) {
  const ErrorEstimate known{.error = 0.1, .low = 0.09, .high = 0.11, .points = 2048};
  be_at(kLast);
  cursor_.unseen = kAbove * kStaleToJudge * known.error;
  EXPECT_FALSE(needs_look(1, cursor_, options_, known, kManyLinks));
  cursor_.phase = Phase::kJudge;
  EXPECT_TRUE(needs_look(1, cursor_, options_, known, kManyLinks));
  cursor_.unseen = kBelow * kStaleToJudge * known.error;
  EXPECT_FALSE(needs_look(1, cursor_, options_, known, kManyLinks));
}

}  // namespace
}  // namespace atrium::testing
