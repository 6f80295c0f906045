#include <client/timing/delivery_simulator.h>

#include <equistream/error.h>

#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <optional>
#include <string>
#include <vector>

namespace equistream::test {
namespace {

using Arrivals = std::vector<std::optional<double>>;

struct SentFrame {
    double sent_s = 0;
    std::int64_t bytes = 0;
};

/// All at once, by index.
Arrivals simulate_delivery(const NetworkConditions& conditions, const std::vector<SentFrame>& frames) {
    DeliverySimulator simulator(conditions);
    Arrivals arrivals;
    for (const SentFrame& frame : frames)
        arrivals.push_back(simulator.send(frame.sent_s, frame.bytes));
    return arrivals;
}

/// At 30 frames/s.
std::vector<SentFrame> frames(std::size_t count, std::int64_t bytes) {
    std::vector<SentFrame> sent;
    for (std::size_t i = 0; i < count; ++i)
        sent.push_back({double(i) / 30, bytes});
    return sent;
}

TEST(DeliverySimulator, DelayAloneShiftsAll) {
    const auto sent = frames(10, 5000);
    const Arrivals arrivals = simulate_delivery({.delay_s = 0.08}, sent);
    for (std::size_t i = 0; i < sent.size(); ++i)
        EXPECT_DOUBLE_EQ(*arrivals[i], sent[i].sent_s + 0.08);
}

TEST(DeliverySimulator, JitterIsUniformAndAStreamKeepsItsOrder) {
    const auto sent = frames(20000, 100);
    const Arrivals loose = simulate_delivery({.delay_s = 0.05, .jitter_s = 0.1, .datagrams = true}, sent);
    const Arrivals stream = simulate_delivery({.delay_s = 0.05, .jitter_s = 0.1}, sent);
    double sum = 0, squares = 0, highest = 0;
    std::int64_t overtaken = 0;
    for (std::size_t i = 0; i < sent.size(); ++i) {
        const double extra = *loose[i] - sent[i].sent_s - 0.05;
        ASSERT_GE(extra, -1e-9);
        ASSERT_LT(extra, 0.1 + 1e-9);
        sum += extra;
        squares += extra * extra;
        overtaken += i > 0 && *loose[i] < *loose[i - 1];
        highest = std::max(highest, *loose[i]);
        ASSERT_DOUBLE_EQ(*stream[i], highest);  // the same draws, waiting for those before
    }
    const double mean = sum / double(sent.size());
    EXPECT_NEAR(mean, 0.05, 0.001);  // 5 sigma
    EXPECT_NEAR(squares / double(sent.size()) - mean * mean, 0.01 / 12, 2.5e-5);
    EXPECT_GT(overtaken, 3000);
}

TEST(DeliverySimulator, BandwidthQueuesFrames) {
    // 50,000 bytes at 4 Mbit/s take 0.1 s, three times what is between frames.
    const Arrivals arrivals = simulate_delivery({.delay_s = 0.02, .bandwidth_bps = 4e6}, frames(10, 50000));
    for (std::size_t i = 0; i < arrivals.size(); ++i)
        EXPECT_NEAR(*arrivals[i], 0.02 + 0.1 * double(i + 1), 1e-12);
}

TEST(DeliverySimulator, NothingLeavesWhileTheLinkStalls) {
    const auto sent = frames(300, 1000);
    const Arrivals arrivals = simulate_delivery({.delay_s = 0.1, .stalls = {{2, 3}, {7, 0.5}}}, sent);
    for (std::size_t i = 0; i < sent.size(); ++i) {
        const double t = sent[i].sent_s;
        const double left = t >= 2 && t < 5 ? 5 : t >= 7 && t < 7.5 ? 7.5 : t;
        EXPECT_NEAR(*arrivals[i], left + 0.1, 1e-12) << t;
    }
    // Half of what takes 1 s to send is through when the link stalls.
    const std::vector<SentFrame> large = {{1.5, 125000}};
    EXPECT_NEAR(*simulate_delivery({.bandwidth_bps = 1e6, .stalls = {{2, 3}}}, large)[0], 5.5, 1e-12);
}

/// Of n packets at share p all come through with (1 - p)^n.
TEST(DeliverySimulator, ALostPacketLosesADatagramFrameAndDelaysAStreams) {
    const auto sent = frames(20000, 5 * packet_bytes);
    const NetworkConditions lossy{.delay_s = 0.05, .loss = 0.02, .datagrams = true};
    const Arrivals loose = simulate_delivery(lossy, sent);
    const double came = double(std::ranges::count_if(loose, [](const auto& a) { return a.has_value(); }));
    EXPECT_NEAR(came / double(sent.size()), std::pow(0.98, 5), 0.01);  // 5 sigma

    NetworkConditions reliable = lossy;
    reliable.datagrams = false;
    DeliverySimulator simulator(reliable);
    std::int64_t in_time = 0, twice = 0;
    for (std::size_t i = 0; i < sent.size(); ++i) {
        const double apart_s = 10.0 * double(i);  // nobody waits for anybody
        const double extra = *simulator.send(apart_s, 5 * packet_bytes) - apart_s - 0.05;
        const double round_trips = extra / 0.1;
        EXPECT_NEAR(round_trips, std::round(round_trips), 1e-6);
        EXPECT_EQ(round_trips < 0.5, loose[i].has_value());  // the same packets
        in_time += round_trips < 0.5;
        twice += round_trips > 1.5;
    }
    EXPECT_EQ(double(in_time), came);
    EXPECT_NEAR(double(twice) / double(sent.size()), 5 * 0.02 * 0.02, 0.0016);
}

TEST(DeliverySimulator, DrawsAreOfTheSeedAndOfEachFrameAlone) {
    const auto sent = frames(2000, 3000);
    const NetworkConditions conditions{.jitter_s = 1, .datagrams = true, .seed = 5};
    EXPECT_EQ(simulate_delivery(conditions, sent), simulate_delivery(conditions, sent));
    NetworkConditions other = conditions;
    other.seed = 6;
    EXPECT_NE(simulate_delivery(conditions, sent), simulate_delivery(other, sent));
    other = conditions;
    other.loss = 0.1;
    const Arrivals all = simulate_delivery(conditions, sent), some = simulate_delivery(other, sent);
    double jitter_of_lost_s = 0, lost = 0;
    for (std::size_t i = 0; i < sent.size(); ++i)
        if (some[i]) {
            EXPECT_EQ(some[i], all[i]);
        } else {
            jitter_of_lost_s += *all[i] - sent[i].sent_s;
            ++lost;
        }
    EXPECT_NEAR(jitter_of_lost_s / lost, 0.5, 0.06);  // neither the early ones nor the late: 5 sigma
    // On every platform: SplitMix64 by hand.
    EXPECT_NEAR(*all[0] - sent[0].sent_s, 0.887059738873719, 1e-15);
    EXPECT_NEAR(*all[1] - sent[1].sent_s, 0.730901940491933, 1e-15);
}

TEST(DeliverySimulator, SaysWhenTheNextCanComeAtTheEarliest) {
    for (const bool datagrams : {false, true}) {
        DeliverySimulator simulator({.delay_s = 0.05,
                                     .jitter_s = 0.2,
                                     .loss = 0.01,
                                     .bandwidth_bps = 3e6,
                                     .datagrams = datagrams,
                                     .stalls = {{2, 3}},
                                     .seed = 9});
        double slack_s = 1e9;
        for (const SentFrame& frame : frames(300, 10000)) {
            const double earliest_s = simulator.earliest_arrival_s(frame.sent_s);
            if (const auto arrival_s = simulator.send(frame.sent_s, frame.bytes)) {
                EXPECT_GE(*arrival_s, earliest_s);
                slack_s = std::min(slack_s, *arrival_s - earliest_s);
            }
            if (frame.sent_s > 2 && frame.sent_s < 5) {
                EXPECT_GE(simulator.earliest_arrival_s(frame.sent_s), 5);
            }
        }
        EXPECT_LT(slack_s, 0.05);
    }
}

TEST(NetworkSpec, ReadsEveryKey) {
    const NetworkConditions read = parse_network(
        "delay=80,jitter=15, loss=0.01,stall=2:3,bandwidth=20,seed=7,stall=8.5:0.25,transport=datagrams", "--network");
    EXPECT_DOUBLE_EQ(read.delay_s, 0.08);
    EXPECT_DOUBLE_EQ(read.jitter_s, 0.015);
    EXPECT_DOUBLE_EQ(read.loss, 0.01);
    EXPECT_DOUBLE_EQ(read.bandwidth_bps, 20e6);
    ASSERT_EQ(read.stalls.size(), 2u);
    EXPECT_EQ(read.stalls[0].at_s, 2);
    EXPECT_EQ(read.stalls[0].lasts_s, 3);
    EXPECT_EQ(read.stalls[1].at_s, 8.5);
    EXPECT_EQ(read.stalls[1].lasts_s, 0.25);
    EXPECT_TRUE(read.datagrams);
    EXPECT_EQ(read.seed, 7u);
    EXPECT_FALSE(parse_network("transport=stream", "").datagrams);
    EXPECT_EQ(parse_network("", "--network").delay_s, 0);
}

std::string problem_of(const std::string& spec) {
    try {
        parse_network(spec, "--network");
    } catch (const InputError& error) {
        return error.what();
    }
    return "none";
}

TEST(NetworkSpec, OneClearLineForWhatItCannotRead) {
    EXPECT_EQ(problem_of("delay=fast"), "--network delay: expected milliseconds from 0 to 60000, found 'fast'");
    EXPECT_EQ(problem_of("delay=80ms"), "--network delay: expected milliseconds from 0 to 60000, found '80ms'");
    EXPECT_EQ(problem_of("loss=1"), "--network loss: expected a share from 0 to 0.9, found '1'");
    EXPECT_EQ(problem_of("loss=nan"), "--network loss: expected a share from 0 to 0.9, found 'nan'");
    EXPECT_EQ(problem_of("stall=2"), "--network stall: expected seconds:seconds, each from 0 to 86400, found '2'");
    EXPECT_EQ(problem_of("bandwidth=0"),
              "--network bandwidth: expected megabits per second, above 0 and at most 1e6, found '0'");
    EXPECT_EQ(problem_of("seed=-1"), "--network seed: expected a whole number, not negative, found '-1'");
    EXPECT_EQ(problem_of("transport=pigeon"), "--network transport: expected stream or datagrams, found 'pigeon'");
    EXPECT_EQ(problem_of("delay=1,delay=2"), "--network delay: expected one value, found a second one");
    for (const char* unknown : {"latency=80", "delay", "delay=1,,jitter=2", "=3"})
        EXPECT_EQ(problem_of(unknown).find("--network: expected delay=MS, jitter=MS, loss=SHARE, bandwidth=MBIT/S, "
                                           "stall=AT:FOR, transport=KIND, seed=N or trace=FILE, found '"),
                  0u)
            << problem_of(unknown);
}

TEST(NetworkSpec, HelpNamesWhatIsRead) {
    const std::string help = network_help();
    EXPECT_EQ(std::ranges::count(help, '\n'), 8);
    for (const char* key : {"delay=MS", "jitter=MS", "loss=SHARE", "bandwidth=MBIT/S", "stall=AT:FOR", "transport=KIND",
                            "seed=N", "trace=FILE"})
        EXPECT_NE(help.find(key), help.npos) << key;
}

class Trace : public testing::Test {
protected:
    ~Trace() override { std::filesystem::remove(file_); }
    std::string spec(const std::string& text) const {
        std::ofstream(file_) << text;
        return "trace=" + file_;
    }
    std::string problem(const std::string& text) const {
        std::string found = problem_of(spec(text));
        return found.starts_with(file_) ? found.substr(file_.size()) : found;
    }

    const std::string file_ = testing::TempDir() + "equistream-trace-" + std::to_string(getpid()) + ".csv";
};

TEST_F(Trace, DeliversEachFrameWhenItCame) {
    const NetworkConditions conditions = parse_network(spec("time_s,arrival_s\n0,0.05\n0.0333,0.3\n0.1,0.2\n"), "");
    const Arrivals arrivals = simulate_delivery(conditions, {{0, 9}, {1.0 / 30, 9}, {2.0 / 30, 9}, {0.1, 9}});
    EXPECT_EQ(arrivals, (Arrivals{0.05, 0.3, std::nullopt, 0.2}));
}

TEST_F(Trace, SaysWhenTheNextCanComeAtTheEarliest) {
    const DeliverySimulator simulator(parse_network(spec("time_s,arrival_s\n0,0.05\n1,3\n2,2.5\n"), ""));
    EXPECT_EQ(simulator.earliest_arrival_s(0), 0.05);
    EXPECT_EQ(simulator.earliest_arrival_s(1), 2.5) << "the second one overtakes it";
    EXPECT_EQ(simulator.earliest_arrival_s(3), 3) << "lost: that is known at once";
}

TEST_F(Trace, OneClearLineForWhatItCannotRead) {
    EXPECT_EQ(problem("time,arrival\n"), ", line 1: expected time_s,arrival_s, found 'time,arrival'");
    const std::string wanted = "expected time_s,arrival_s in seconds, with time_s above that of the line before, ";
    EXPECT_EQ(problem("time_s,arrival_s\n0,1\n0,2\n"), ", line 3: " + wanted + "found '0,2'");
    EXPECT_EQ(problem("time_s,arrival_s\n0,nan\n"), ", line 2: " + wanted + "found '0,nan'");
    EXPECT_EQ(problem("time_s,arrival_s\n0\n"), ", line 2: " + wanted + "found '0'");
    EXPECT_EQ(problem("time_s,arrival_s\n0,1,2\n"), ", line 2: " + wanted + "found '0,1,2'");
    EXPECT_EQ(problem("time_s,arrival_s\n"), ": expected at least one arrival, found none");
    EXPECT_EQ(problem_of("trace=/nowhere.csv"),
              "/nowhere.csv: expected a trace of arrivals (CSV) that can be read, found No such file or directory");
    EXPECT_EQ(problem_of(spec("time_s,arrival_s\n0,1\n") + ",loss=0.1")
                  .find("--network trace: expected trace as the only key"),
              0u);
}

}  // namespace
}  // namespace equistream::test
