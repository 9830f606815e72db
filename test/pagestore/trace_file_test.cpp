// Trace files: there and back on random traces, damage and cuts at every byte, hostile files, what
// others call a csv, and the worked example of pagestore/TRACE.md.
#include <sys/resource.h>

#include <algorithm>
#include <csignal>
#include <fstream>
#include <map>
#include <set>

#include "pagestore/trace_codecs.h"
#include "pagestore/trace_file.h"
#include "pagestore/trace_writer.h"
#include "test/pagestore/store_fixture.h"

namespace atrium {

bool operator==(const TraceEvent& a, const TraceEvent& b) {
  return a.op == b.op && a.record == b.record && a.bytes == b.bytes;
}

namespace {

void expect_equal(const Trace& found, const Trace& expected) {
  EXPECT_EQ(found.pins, expected.pins);
  EXPECT_EQ(found.ids, expected.ids);
  EXPECT_EQ(found.sizes, expected.sizes);
  EXPECT_EQ(found.times, expected.times);
  EXPECT_TRUE(found.events == expected.events);
}

class TraceFileTest : public StoreTest {
 protected:
  std::string path(const std::string& name) const { return dir_ + "/" + name; }

  std::string bytes(const std::string& name) const {
    std::ifstream in(path(name), std::ios::binary);
    return {std::istreambuf_iterator<char>(in), {}};
  }
  void put(const std::string& name, const std::string& text) const {
    std::ofstream(path(name), std::ios::binary) << text;
  }
  // What stands under `name` after it was written and read again.
  TraceFile there_and_back(const Trace& trace, const std::string& name, TraceFormat format) const {
    EXPECT_OK(write_trace(trace, path(name), format));
    return read(name);
  }
  TraceFile read(const std::string& name) const {
    Result<TraceFile> file = read_trace(path(name));
    EXPECT_TRUE(file.ok()) << file.status().message();
    return file.ok() ? std::move(*file) : TraceFile{};
  }
  Status error(const std::string& text, const std::string& name, const std::string& columns = "") {
    put(name, text);
    const auto file = read_trace(path(name), columns);
    return file.ok() ? Status() : file.status();
  }
};

// A live store's life: records there and made, nested pins, growth, marks; some ids far apart.
Trace random_life(std::uint64_t seed, int steps) {
  std::mt19937_64 random(seed);
  Trace t;
  t.pins = true;
  std::vector<std::uint64_t> now, pins;
  const auto add = [&](TraceOp op, RecordNumber r) { t.events.push_back({op, r, now[r]}); };
  const auto meet = [&](bool made) {
    const std::uint64_t far = random() % 8 == 0 ? random() << 20 : 0;
    t.ids.push_back((far << 32) + 3 * t.ids.size());
    now.push_back(random() % (1u << random() % 20));
    t.sizes.push_back(made ? 0 : now.back());
    pins.push_back(0);
    return static_cast<RecordNumber>(now.size() - 1);
  };
  const auto some = [&] {
    return now.empty() || random() % 10 == 0 ? meet(false)
                                             : static_cast<RecordNumber>(random() % now.size());
  };
  for (int i = 0; i < steps; ++i) {
    const std::uint64_t kind = random() % 16;
    if (kind == 0) {
      t.events.push_back({TraceOp::kIteration, 0, random() >> random() % 64});
    } else if (kind == 1) {
      t.events.push_back({TraceOp::kCheckpoint, 0, 0});
    } else if (kind == 2) {
      add(TraceOp::kCreate, meet(true));
    } else if (kind == 3) {
      add(TraceOp::kGather, some());
    } else {
      const RecordNumber r = some();
      const bool unpin = pins[r] > 0 && kind < 10;
      if (unpin && kind < 6) {
        now[r] = random() % (1u << 20);
        add(TraceOp::kDirty, r);
        continue;
      }
      pins[r] += unpin ? -1 : 1;
      add(unpin ? TraceOp::kRelease : TraceOp::kRead, r);
      if (unpin || random() % 2 == 0) continue;
      --pins[r];
      add(TraceOp::kRelease, r);
    }
  }
  return t;
}

// Requests of another system: sizes that change, puts, times that jump.
Trace random_requests(std::uint64_t seed, int requests, bool puts) {
  std::mt19937_64 random(seed);
  Trace t;
  std::map<std::uint64_t, RecordNumber> numbers;
  for (int i = 0; i < requests; ++i) {
    const std::uint64_t id = (random() % 50) * 0x9e3779b97f4a7c15u;
    const auto [at, is_new] = numbers.try_emplace(id, static_cast<RecordNumber>(t.ids.size()));
    if (is_new) t.ids.push_back(id), t.sizes.push_back(0);
    t.events.push_back({puts && random() % 3 == 0 ? TraceOp::kPut : TraceOp::kGet, at->second,
                        random() >> (32 + random() % 32)});
    t.times.push_back(static_cast<std::uint32_t>(random()));
  }
  return t;
}

TEST_F(TraceFileTest, OurTracesComeBackAsTheyWere) {
  for (std::uint64_t seed = 0; seed < 200; ++seed) {
    const Trace trace = random_life(seed, 1 + static_cast<int>(seed) * 5);
    const TraceFile back = there_and_back(trace, "t.atr", TraceFormat::kAtr);
    EXPECT_EQ(back.format, TraceFormat::kAtr);
    EXPECT_TRUE(back.complete);
    EXPECT_EQ(back.left_over, 0u);
    expect_equal(back.trace, trace);
  }
}

TEST_F(TraceFileTest, AnEmptyTraceOfOursIsAHeaderAndTheEmptyChunk) {
  Trace trace;
  trace.pins = true;
  expect_equal(there_and_back(trace, "t.atr", TraceFormat::kAtr).trace, trace);
  EXPECT_EQ(bytes("t.atr").size(), 16u + 24u);
}

TEST_F(TraceFileTest, ManyChunksComeBackAsTheyWere) {
  const Trace trace = random_life(7, 200'000);
  const TraceFile back = there_and_back(trace, "t.atr", TraceFormat::kAtr);
  expect_equal(back.trace, trace);
  EXPECT_GT(bytes("t.atr").size(), 4u * 65536u);
}

TEST_F(TraceFileTest, RequestsComeBackAsTheyWere) {
  for (std::uint64_t seed = 0; seed < 100; ++seed) {
    const int requests = 1 + static_cast<int>(seed) * 10;
    const Trace gets = random_requests(seed, requests, false);
    expect_equal(there_and_back(gets, "t.bin", TraceFormat::kOracle).trace, gets);
    const Trace puts = random_requests(seed, requests, true);
    expect_equal(there_and_back(puts, "t.csv", TraceFormat::kCsv).trace, puts);
  }
}

TEST_F(TraceFileTest, RequestsThatDoNotResizeSurviveOurFormat) {
  // 3 is read at 10 bytes, made 20 long, read; 4 is put at once.
  Trace requests;
  requests.ids = {3, 4};
  requests.sizes = {0, 0};
  requests.events = {{TraceOp::kGet, 0, 10},
                     {TraceOp::kPut, 0, 20},
                     {TraceOp::kGet, 0, 20},
                     {TraceOp::kPut, 1, 5}};
  requests.times = {0, 0, 0, 0};
  const Trace pinned = there_and_back(requests, "t.atr", TraceFormat::kAtr).trace;
  const std::vector<TraceEvent> expected{
      {TraceOp::kRead, 0, 10}, {TraceOp::kRelease, 0, 10},  //
      {TraceOp::kRead, 0, 10}, {TraceOp::kDirty, 0, 20},   {TraceOp::kRelease, 0, 20},
      {TraceOp::kRead, 0, 20}, {TraceOp::kRelease, 0, 20},  //
      {TraceOp::kRead, 1, 5},  {TraceOp::kDirty, 1, 5},    {TraceOp::kRelease, 1, 5}};
  EXPECT_TRUE(pinned.events == expected);
  EXPECT_EQ(pinned.sizes, (std::vector<std::uint64_t>{10, 5}));
  expect_equal(requests_only(pinned), requests);
}

TEST_F(TraceFileTest, RequestsOfALifeAreItsReadsAndWhatWasDirtiedAfterThemIsPut) {
  Trace t;
  t.pins = true;
  t.ids = {70, 80, 90};
  t.sizes = {10, 20, 0};
  t.events = {{TraceOp::kCreate, 2, 7},  {TraceOp::kGather, 1, 20},  {TraceOp::kRead, 1, 20},
              {TraceOp::kRead, 0, 10},   {TraceOp::kRelease, 0, 10}, {TraceOp::kDirty, 1, 30},
              {TraceOp::kDirty, 1, 40},  {TraceOp::kRelease, 1, 40}, {TraceOp::kCheckpoint, 0, 0},
              {TraceOp::kGather, 0, 10}, {TraceOp::kRead, 1, 40},    {TraceOp::kRelease, 1, 40},
              {TraceOp::kRead, 2, 7},    {TraceOp::kRelease, 2, 7}};
  ASSERT_OK(write_trace(t, path("t.csv"), TraceFormat::kCsv));
  EXPECT_EQ(bytes("t.csv"), "time,id,size,op\n1,80,40,put\n1,70,10,get\n2,80,40,get\n2,90,7,get\n");
  const std::vector<std::string> lost = what_is_lost(t, TraceFormat::kCsv);
  EXPECT_NE(std::ranges::find(lost, "1 records made"), lost.end());
  EXPECT_NE(std::ranges::find(lost, "1 checkpoints"), lost.end());
  EXPECT_TRUE(what_is_lost(t, TraceFormat::kAtr).empty());
}

TEST_F(TraceFileTest, OracleNextIsComputedWhenWrittenAndIgnoredWhenRead) {
  Trace t;
  t.ids = {5, 6};
  t.sizes = {0, 0};
  t.events = {{TraceOp::kGet, 0, 1}, {TraceOp::kGet, 1, 2}, {TraceOp::kGet, 0, 1}};
  t.times = {9, 9, 10};
  ASSERT_OK(write_trace(t, path("t.bin"), TraceFormat::kOracle));
  std::string text = bytes("t.bin");
  ASSERT_EQ(text.size(), 72u);
  const auto next = [&](std::size_t request) {
    std::int64_t value = 0;
    std::memcpy(&value, text.data() + 24 * request + 16, sizeof value);
    return value;
  };
  EXPECT_EQ(next(0), 3);  // request 1 comes again as number 3
  EXPECT_EQ(next(1), -1);
  EXPECT_EQ(next(2), -1);
  for (std::size_t request = 0; request < 3; ++request)
    text.replace(24 * request + 16, 8, "garbage!");
  put("t.bin", text);
  expect_equal(read("t.bin").trace, t);
}

TEST_F(TraceFileTest, ASizeBeyondOraclesIsRefused) {
  Trace t;
  t.ids = {5};
  t.sizes = {0};
  t.events = {{TraceOp::kGet, 0, std::uint64_t{1} << 32}};
  const Status status = write_trace(t, path("t.bin"), TraceFormat::kOracle);
  EXPECT_EQ(status.code(), Code::kUsage);
  EXPECT_EQ(status.place(), "request 1");
  EXPECT_FALSE(std::filesystem::exists(path("t.bin")));
}

// A small file of several chunks: a checkpoint ends one.
Trace small_life() { return random_life(3, 60); }

TEST_F(TraceFileTest, DamageAtAnyByteIsFound) {
  ASSERT_OK(write_trace(small_life(), path("t.atr"), TraceFormat::kAtr));
  const std::string whole = bytes("t.atr");
  for (std::size_t at = 0; at < whole.size(); ++at)
    for (const int bit : {0, 3, 7}) {
      std::string text = whole;
      text[at] = static_cast<char>(text[at] ^ (1 << bit));
      const auto file = decode_atr(bytes_of(text), "t.atr");
      ASSERT_FALSE(file.ok()) << at;
      ASSERT_EQ(file.status().code(), Code::kStore) << at;
      ASSERT_NE(file.status().place().find("byte"), std::string::npos) << at;
    }
}

TEST_F(TraceFileTest, ChunksOutOfTheirPlaceAreFound) {
  auto writer = TraceWriter::create(path("t.atr"));
  ASSERT_OK(writer.status());
  for (int chunk = 0; chunk < 2; ++chunk) (*writer)->iteration(1), (*writer)->checkpoint();
  ASSERT_OK((*writer)->close());
  const std::string whole = bytes("t.atr");
  constexpr std::size_t kHead = 16, kChunk = 24 + 3;  // two marks: two bytes and one
  ASSERT_EQ(whole.size(), kHead + 2 * kChunk + 24);
  const std::string first = whole.substr(kHead, kChunk),
                    second = whole.substr(kHead + kChunk, kChunk);
  const std::string head = whole.substr(0, kHead), end = whole.substr(kHead + 2 * kChunk);
  EXPECT_TRUE(error(head + first + second + end, "t.atr").ok());
  for (const std::string& moved : {head + second + first + end, head + first + first + second + end,
                                   head + second + end, head + first + end})
    EXPECT_EQ(error(moved, "t.atr").code(), Code::kStore);
  const Status longer = error(whole + "x", "t.atr");
  EXPECT_EQ(longer.code(), Code::kStore);
  EXPECT_EQ(longer.place(), "byte " + std::to_string(whole.size()));
}

TEST_F(TraceFileTest, AFileCutAnywhereIsReadUpToItsLastWholeChunk) {
  const Trace trace = small_life();
  ASSERT_OK(write_trace(trace, path("t.atr"), TraceFormat::kAtr));
  const std::string whole = bytes("t.atr");
  std::set<std::size_t> lengths;
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const auto cut = decode_atr(bytes_of(whole.substr(0, size)), "t.atr");
    if (size < 16) {
      ASSERT_FALSE(cut.ok());
      continue;
    }
    ASSERT_TRUE(cut.ok()) << cut.status().message();
    ASSERT_FALSE(cut->complete);
    ASSERT_LE(cut->left_over, size - 16);
    const std::vector<TraceEvent>& events = cut->trace.events;
    ASSERT_TRUE(std::equal(events.begin(), events.end(), trace.events.begin()));
    lengths.insert(events.size());
  }
  const auto checkpoints = static_cast<std::size_t>(
      std::ranges::count(trace.events, TraceOp::kCheckpoint, &TraceEvent::op));
  EXPECT_GE(lengths.size(), checkpoints + 1);  // each ends a chunk
  EXPECT_GE(checkpoints, 2u);
}

// A file of one chunk with this payload, its hashes right: only its events can be wrong.
std::string sealed(const std::string& payload, std::uint32_t events) {
  const auto number = [](auto value) {
    return std::string(reinterpret_cast<char*>(&value), sizeof value);
  };
  const std::string sizes = number(static_cast<std::uint32_t>(payload.size())) + number(events);
  const std::string hashed =
      sizes + number(hash_bytes(bytes_of(number(std::uint64_t{0}) + payload)));
  return std::string("ATRTRACE\1\0\0\0\0\0\0\0", 16) + hashed +
         number(hash_bytes(bytes_of(hashed))) + payload;
}

TEST_F(TraceFileTest, EventsThatMakeNoSenseAreRefused) {
  using namespace std::string_literals;
  // A read of new record 0: operand 0; id zigzag(7) = 14, size 5. Then what is wrong, if anything.
  const std::string good = "\x00\x0e\x05"s;
  put("t.atr", sealed(good, 1));
  EXPECT_EQ(read("t.atr").trace.events.size(), 1u);
  const std::vector<std::pair<std::string, std::string>> wrong{
      {"\x18\x00"s, "not heard of"},        // read of record 2 (operand 3 is -2: below 0)
      {"\x20\x00"s, "not heard of"},        // read of record 2, when 1 would be the next
      {"\x10"s, "no id"},                   // read of record 1, and the end
      {"\x10\x00\x05"s, "id of another"},   // record 1 with id 7, too
      {"\x13\x02\x05\x03"s, "not pinned"},  // release of record 1, never read
      {"\x12\x02\x05\x00"s, "not pinned"},  // the same dirtied
      {"\x03\x03"s, "not pinned"},          // released twice
      {"\x04"s, "there already"},           // made when it is there
      {"\x02"s, "no size"},                 // dirtied, and the end
      {"\x02\x0d"s, "beyond"},              // 5 - 7 bytes long
      {"\x0f"s, "names a record"},          // a checkpoint of record 1
      {"\x06"s, "no number"},               // an iteration without one
      {"\x80"s, "no end"},                  // a number that goes on
      {"\xff\xff\xff\xff\xff\xff\xff\xff\xff\x7f"s, "no end"},
      {"\x10\x02\xff\xff\xff\xff\xff\xff\xff\x7f"s, "larger than any"}};
  for (const auto& [events, cause] : wrong) {
    const Status status = error(sealed(good + events, 2), "t.atr");
    EXPECT_EQ(status.code(), Code::kStore);
    EXPECT_NE(status.cause().find(cause), std::string::npos) << cause << ": " << status.message();
  }
  EXPECT_EQ(error(sealed(good, 2), "t.atr").code(), Code::kStore);  // two events, it says
}

TEST(TraceCodecs, RandomEventsNeverCrashAndNeverBreakTheRules) {
  std::mt19937_64 random(11);
  int read_well = 0;
  for (int i = 0; i < 100'000; ++i) {
    std::string payload(1 + random() % 12, '\0');
    for (char& c : payload) c = static_cast<char>(random() % 24);
    const auto events = static_cast<std::uint32_t>(1 + random() % 8);
    const auto file = decode_atr(bytes_of(sealed(payload, events)), "t.atr");
    if (!file.ok()) continue;
    ++read_well;
    const Status sound = check_trace(file->trace);
    ASSERT_TRUE(sound.ok()) << sound.message();
  }
  EXPECT_GT(read_well, 100);
}

TEST_F(TraceFileTest, AFormatToComeAndFilesThatAreNoTraces) {
  std::string later("ATRTRACE\2\0\0\0\0\0\0\0", 16);
  EXPECT_EQ(error(later, "t.atr").code(), Code::kStore);
  EXPECT_NE(error(later, "t.atr").cause().find("format 2"), std::string::npos);
  EXPECT_EQ(error("no trace", "t.atr").code(), Code::kStore);
  EXPECT_EQ(error("", "t.atr").code(), Code::kStore);
  EXPECT_EQ(error("", "t.csv").code(), Code::kUsage);
  EXPECT_EQ(error("", "t.bin").code(), Code::kUsage);
  EXPECT_EQ(error("", "t").code(), Code::kUsage);
  EXPECT_EQ(error(std::string(25, 'x'), "t.bin").code(), Code::kUsage);
  EXPECT_EQ(error(std::string(25, 'x'), "t").code(), Code::kUsage);
  EXPECT_TRUE(error(std::string(48, 'x'), "t").ok());
  EXPECT_EQ(read_trace(path("missing.atr")).status().code(), Code::kUsage);
  EXPECT_EQ(read_trace(dir_).status().code(), Code::kUsage);
}

TEST_F(TraceFileTest, CsvColumnsAreFoundByTheirNamesOrAsTold) {
  // 12 is got and put, in whatever way that is written.
  Trace t;
  t.ids = {12};
  t.sizes = {0};
  t.events = {{TraceOp::kGet, 0, 7}, {TraceOp::kPut, 0, 8}};
  t.times = {3, 4};
  struct Way {
    std::string text, columns;
  };
  const std::vector<Way> ways{
      {"time,id,size,op\n3,12,7,get\n4,12,8,put\n", ""},
      {"3,12,7,read\n4,12,8,set\n", ""},
      {"Op, Size, ID, Time, more\r\nREAD, 7, 12, 3.5, x\r\n\r\nWrite, 8, 12, 4.9,\r\n", ""},
      {"version,time,op,size,lbn\n1,3,28,7,12\n1,4,2a,8,12\n", "time=2,op=3,size=4,id=5"},
      {"version,time,op,size,lbn\n1,3,28,7,12\n1,4,2a,8,12\n", "time=time,op=op,size=size,id=lbn"},
      {"12,7,get,3\n12,8,replace,4", "id=1,size=2,op=3,time=4"}};
  for (const Way& way : ways) {
    put("t.csv", way.text);
    const auto file = read_trace(path("t.csv"), way.columns);
    ASSERT_TRUE(file.ok()) << file.status().message();
    expect_equal(file->trace, t);
  }
  put("t.csv", "id,size\n12,7\n");
  const Trace bare = read("t.csv").trace;  // no time, no op
  EXPECT_TRUE(bare.events == std::vector<TraceEvent>({{TraceOp::kGet, 0, 7}}));
  EXPECT_EQ(bare.times, std::vector<std::uint32_t>{0});
}

TEST_F(TraceFileTest, CsvIdsThatAreTextStayApart) {
  put("t.csv",
      "time,id,size,op\n0,a/b.html,1,get\n0,18446744073709551615,1,get\n"
      "0,18446744073709551616,1,get\n0,07,1,get\n0,7,1,get\n0,a/b.html,1,get\n");
  const Trace t = read("t.csv").trace;
  ASSERT_EQ(t.ids.size(), 5u);
  EXPECT_EQ(t.ids[1], ~std::uint64_t{0});  // a number keeps its value
  EXPECT_EQ(t.ids[4], 7u);
  EXPECT_EQ(t.events[5].record, 0u);
  EXPECT_EQ(std::set<std::uint64_t>(t.ids.begin(), t.ids.end()).size(), 5u);
}

TEST_F(TraceFileTest, CsvFaultsAreNamedByTheirLine) {
  const std::string head = "time,id,size,op\n0,1,1,get\n";
  for (const std::string line :
       {"0,1,1,delete", "0,1,1,", "0,1,1", "0,1,-1,get", "0,1,1.5,get", "0,1,1099511627777,get",
        "0,1,99999999999999999999,get", "0,,1,get", "-1,1,1,get", "nan,1,1,get",
        "4294967296,1,1,get", "x,1,1,get", "0,\"1\",1,get"}) {
    const Status status = error(head + line + "\n", "t.csv");
    EXPECT_EQ(status.code(), Code::kUsage) << line;
    EXPECT_EQ(status.place(), "line 3") << line;
  }
  EXPECT_EQ(error("when,what\n1,2\n", "t.csv").place(), "line 1");
  EXPECT_EQ(error(head, "t.csv", "id=2").code(), Code::kUsage);
  EXPECT_EQ(error(head, "t.csv", "id=2,size=none").place(), "line 1");
  EXPECT_EQ(error(head, "t.csv", "id=2,size=3,colour=4").code(), Code::kUsage);
  EXPECT_EQ(error(head, "t.csv", "id=2,size=9").code(), Code::kUsage);
}

TEST(TraceCodecs, RandomTextNeverCrashesTheCsvReader) {
  std::mt19937_64 random(5);
  const std::string letters = "01,,\n\r .-egtpuid\"\xff";
  for (int i = 0; i < 20'000; ++i) {
    std::string text = i % 2 == 0 ? "time,id,size,op\n" : "";
    for (std::uint64_t n = random() % 40; n > 0; --n) text += letters[random() % letters.size()];
    const auto trace = decode_csv(text, "t.csv", "");
    ASSERT_TRUE(trace.ok() || trace.status().place().starts_with("line")) << text;
  }
}

// Files of this process end at so many bytes: a write beyond fails as on a full disk.
class FileLimit {
 public:
  explicit FileLimit(rlim_t bytes) : signal_(std::signal(SIGXFSZ, SIG_IGN)) {
    ::getrlimit(RLIMIT_FSIZE, &before_);
    const rlimit now{bytes, before_.rlim_max};
    ::setrlimit(RLIMIT_FSIZE, &now);
  }
  ~FileLimit() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, signal_);
  }

 private:
  rlimit before_{};
  void (*signal_)(int);
};

TEST_F(TraceFileTest, ADiskThatIsFullIsToldAndDisturbsNobody) {
  auto writer = TraceWriter::create(path("t.atr"));
  ASSERT_OK(writer.status());
  (*writer)->read(cluster(1), 10);
  (*writer)->checkpoint();
  ASSERT_OK((*writer)->status());
  {
    const FileLimit limit((*writer)->file_bytes());
    (*writer)->release(cluster(1));
    (*writer)->checkpoint();
  }
  EXPECT_EQ((*writer)->status().code(), Code::kStore);
  (*writer)->iteration(2);
  (*writer)->checkpoint();
  EXPECT_EQ((*writer)->close().code(), Code::kStore);  // what is missing stays missing
  EXPECT_EQ(read("t.atr").trace.events.size(), 2u);    // what was written stays whole
}

TEST(TraceWriter, WhatIsNoPlainFileIsNotReplaced) {
  EXPECT_EQ(TraceWriter::create("/dev/null").status().code(), Code::kUsage);
  EXPECT_TRUE(std::filesystem::exists("/dev/null"));
}

TEST_F(TraceFileTest, AWriterThatWasNeverClosedLeavesWhatTheLastCheckpointHad) {
  {
    auto writer = TraceWriter::create(path("t.atr"));
    ASSERT_OK(writer.status());
    (*writer)->read(cluster(1), 10);
    (*writer)->checkpoint();
    (*writer)->release(cluster(1));
  }
  const TraceFile file = read("t.atr");
  EXPECT_FALSE(file.complete);
  EXPECT_EQ(file.left_over, 0u);
  EXPECT_EQ(file.trace.events.size(), 2u);
}

TEST_F(TraceFileTest, AVisitOfANeighbourTakesOneByte) {
  // 10,000 records read and released in a row, twice: two events a byte the second time.
  constexpr std::uint64_t kRecords = 10'000;
  auto writer = TraceWriter::create(path("t.atr"));
  ASSERT_OK(writer.status());
  std::uint64_t before = 0;
  for (int pass = 0; pass < 2; ++pass) {
    before = (*writer)->file_bytes();
    for (std::uint64_t i = 0; i < kRecords; ++i)
      (*writer)->read(cluster(i), 4000), (*writer)->release(cluster(i));
    (*writer)->checkpoint();
  }
  // A chunk's header, the checkpoint, and the way back from the last record to the first.
  EXPECT_LE((*writer)->file_bytes() - before, kRecords + 24 + 1 + 2);
}

// The worked example of TRACE.md, byte by byte.
TEST_F(TraceFileTest, TheWorkedExample) {
  auto writer = TraceWriter::create(path("t.atr"));
  ASSERT_OK(writer.status());
  TraceWriter& w = **writer;
  w.create_record(cluster(7), 100);
  w.iteration(1);
  w.gather(cluster(7), 100);
  w.read(cluster(7), 100);
  w.read(cluster(9), 5000);
  w.release(cluster(9));
  w.read(cluster(9), 5000);
  w.release(cluster(9));
  w.dirty(cluster(7), 300);
  w.release(cluster(7));
  w.checkpoint();
  ASSERT_OK(w.close());
  const std::vector<unsigned char> expected{
      0x41, 0x54, 0x52, 0x54, 0x52, 0x41, 0x43, 0x45, 0x01, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00,
      0x00, 0x1a, 0x00, 0x00, 0x00, 0x0b, 0x00, 0x00, 0x00, 0x14, 0xd3, 0x55, 0x53, 0xf0, 0x2f,
      0x5f, 0xcb, 0x6a, 0x9d, 0xac, 0xca, 0xee, 0x75, 0xc8, 0x24, 0x04, 0x8e, 0x80, 0x80, 0x80,
      0x80, 0x80, 0x80, 0x80, 0x02, 0x64, 0x06, 0x01, 0x05, 0x00, 0x10, 0x04, 0x88, 0x27, 0x03,
      0x01, 0x0a, 0x90, 0x03, 0x03, 0x07, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x00, 0x39,
      0xd0, 0xcb, 0x00, 0x61, 0x5e, 0xa0, 0x7e, 0xa4, 0x8d, 0xcb, 0x8d, 0x8d, 0x32, 0x50, 0x78};
  EXPECT_EQ(bytes("t.atr"), std::string(expected.begin(), expected.end()));
  // The hashes are what they are said to be.
  const std::string payload = bytes("t.atr").substr(40, 26);
  EXPECT_EQ(bytes("t.atr").substr(0, 66), sealed(payload, 11));

  const Trace trace = read("t.atr").trace;
  EXPECT_EQ(trace.ids, (std::vector<std::uint64_t>{cluster(7).value, cluster(9).value}));
  EXPECT_EQ(trace.sizes, (std::vector<std::uint64_t>{0, 5000}));
  EXPECT_TRUE(trace.events == std::vector<TraceEvent>({{TraceOp::kCreate, 0, 100},
                                                       {TraceOp::kIteration, 0, 1},
                                                       {TraceOp::kGather, 0, 100},
                                                       {TraceOp::kRead, 0, 100},
                                                       {TraceOp::kRead, 1, 5000},
                                                       {TraceOp::kRelease, 1, 5000},
                                                       {TraceOp::kRead, 1, 5000},
                                                       {TraceOp::kRelease, 1, 5000},
                                                       {TraceOp::kDirty, 0, 300},
                                                       {TraceOp::kRelease, 0, 300},
                                                       {TraceOp::kCheckpoint, 0, 0}}));
}

}  // namespace
}  // namespace atrium
